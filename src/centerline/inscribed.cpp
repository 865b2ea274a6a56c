#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tube.hpp"

namespace lumesh::centerline {

namespace {

constexpr int kSectionRays = 32;
/// Rays that end farther from the circle than this share of the radius, or voxels on top, count for little.
constexpr double kNear = 0.15;
constexpr double kNearVoxels = 0.4;
/// As many rays as this say that a section is round, which decides where a sac or a branch takes half of the
/// wall.
constexpr double kRound = 6;
/// Sections are averaged over so many radii to both sides: single ones see the voxels.
constexpr double kAlike = 1.5;

constexpr double kVoxelNoise = 0.15;  ///< Voxels.

/// How a section differs from a circle: radius + even * cos(2 turn) + odd * sin(2 turn).
struct Flattening {
  double even = 0;
  double odd = 0;
};

struct Section {
  Vec3 along = Vec3::UnitZ();
  Vec3 across = Vec3::UnitX();  ///< Where turns begin; turns as little as possible from section to section.
};

std::vector<Section> sections_of(const Tube& tube) {
  std::vector<Section> sections;
  for (std::size_t i = 0; i < tube.size(); ++i) {
    Section section;
    section.along = direction_at(tube, i, 2);
    const Vec3 before = i == 0 ? section.along.unitOrthogonal() : sections.back().across;
    const Vec3 across = before - before.dot(section.along) * section.along;
    section.across = across.norm() > 1e-6 ? Vec3(across.normalized()) : Vec3(section.along.unitOrthogonal());
    sections.push_back(section);
  }
  return sections;
}

Flattening flattening_at(const Lumen& lumen, const Vec3& centre, double radius, const Section& section) {
  if (lumen.inside(centre) < 0.5) return {};
  using Vec5 = Eigen::Matrix<double, 5, 1>;
  Eigen::Matrix<double, 5, 5> matrix = Eigen::Matrix<double, 5, 5>::Identity() * 1e-6;
  matrix(3, 3) = matrix(4, 4) = kRound;
  Vec5 side = Vec5::Zero();
  const Vec3 third = section.along.cross(section.across);
  const double width = kNear * radius + kNearVoxels * lumen.voxel_mm();
  const double most = 2 * radius + 2 * lumen.voxel_mm();
  for (int n = 0; n < kSectionRays; ++n) {
    const double turn = 2 * std::numbers::pi * n / kSectionRays;
    const Vec3 direction = std::cos(turn) * section.across + std::sin(turn) * third;
    const double wall = lumen.ray_by_area(centre, direction, most);
    if (wall >= most || lumen.is_guessed(centre + wall * direction, radius)) continue;
    const double deviation = (wall - radius) / width;
    const double weight = 1 / ((1 + deviation * deviation) * (1 + deviation * deviation));
    Vec5 row;
    row << 1, std::cos(turn), std::sin(turn), std::cos(2 * turn), std::sin(2 * turn);
    matrix += weight * row * row.transpose();
    side += weight * (wall - radius) * row;
  }
  const Vec5 shape = matrix.ldlt().solve(side);
  return {shape[3], shape[4]};
}

}  // namespace

Tube inscribed(const Lumen& lumen, const Tube& tube) {
  const std::vector<Section> sections = sections_of(tube);
  std::vector<Flattening> flattenings(tube.size());
  parallel::for_each_index(tube.size(), 4, [&](std::size_t i) {
    flattenings[i] = flattening_at(lumen, tube.centres[i], tube.radii[i], sections[i]);
  });
  const std::vector<double> length = lengths_along(tube);
  Tube out = tube;
  std::size_t begin = 0, end = 0;
  for (std::size_t i = 0; i < tube.size(); ++i) {
    const double reach = kAlike * tube.radii[i];
    while (begin < i && length[i] - length[begin] > reach) ++begin;
    while (begin > 0 && length[i] - length[begin - 1] <= reach) --begin;
    end = std::max(end, i);
    while (end + 1 < tube.size() && length[end + 1] - length[i] <= reach) ++end;
    while (end > i && length[end] - length[i] > reach) --end;
    Flattening mean;
    for (std::size_t n = begin; n <= end; ++n) {
      mean.even += flattenings[n].even / static_cast<double>(end - begin + 1);
      mean.odd += flattenings[n].odd / static_cast<double>(end - begin + 1);
    }
    // Voxels alone make a round section look flattened by this.
    const double noise = kVoxelNoise * lumen.voxel_mm();
    const double squared = mean.even * mean.even + mean.odd * mean.odd - noise * noise;
    out.radii[i] -= std::min(std::sqrt(std::max(0.0, squared)), 0.5 * tube.radii[i]);
  }
  return out;
}

}  // namespace lumesh::centerline
