#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "banded.hpp"
#include "lumesh/core/value_of_rank.hpp"
#include "tube.hpp"

namespace lumesh::centerline {

namespace {

constexpr int kRays = 32;
constexpr int kRounds = 10;
/// Rays that end this far beyond the tube count half as much or less: shares of the radius, at first and at
/// last.
constexpr double kWideAtFirst = 0.6;
constexpr double kWideAtLast = 0.1;
/// Waves of centre and radius shorter than about six times this share of the radius are smoothed away; of the
/// radius, those of so many voxels, too.
constexpr double kSmooth = 0.5;
constexpr double kSmoothVoxels = 1.25;
/// Rays end here; the wall of the vessel is nearer.
constexpr double kRayRadii = 2.5;

using Vec4 = Eigen::Vector4d;
using Mat4 = Eigen::Matrix4d;

/// What the wall around a point says of the shift of the centre and the new radius: matrix * (shift, radius)
/// = side.
struct WallEquations {
  Mat4 matrix = Mat4::Zero();
  Vec4 side = Vec4::Zero();
};

class TubeFitter {
 public:
  TubeFitter(const Lumen& lumen, const Tube& start) : lumen_(lumen), start_(start), tube_(start) {}

  Tube run() {
    const double median_mm = value_of_rank(tube_.radii, tube_.radii.size() / 2);
    gap_mm_ = std::clamp(0.25 * median_mm, 0.5 * lumen_.voxel_mm(), 2 * lumen_.voxel_mm());
    for (int round = 0; round < kRounds; ++round) {
      tube_ = resampled(tube_, gap_mm_);
      const double t = std::min(1.0, static_cast<double>(round) / (kRounds - 3));
      exact_ = round >= kRounds - 3;
      wide_ = kWideAtFirst * std::pow(kWideAtLast / kWideAtFirst, t);
      fit_once();
    }
    return tube_;
  }

 private:
  void fit_once() {
    const auto count = static_cast<std::ptrdiff_t>(tube_.size());
    // A closed tube is cut open, with as much of the other side beyond both ends as reaches to where they
    // meet.
    std::ptrdiff_t margin = 0;
    if (tube_.closed) {
      const double widest = *std::ranges::max_element(tube_.radii);
      margin = std::min(count, static_cast<std::ptrdiff_t>(6 * widest / gap_mm_) + 4);
    }
    std::vector<std::size_t> order;
    for (std::ptrdiff_t i = -margin; i < count + margin; ++i)
      order.push_back(static_cast<std::size_t>((i + count) % count));
    std::vector<WallEquations> walls(tube_.size());
    parallel::for_each_index(tube_.size(), 4, [&](std::size_t i) { walls[i] = wall_equations(i); });
    const std::vector<double> x = solve(order, walls);
    for (std::size_t i = 0; i < tube_.size(); ++i) {
      const double* at = x.data() + 4 * (i + static_cast<std::size_t>(margin));
      tube_.centres[i] += Vec3(at[0], at[1], at[2]);
      tube_.radii[i] = std::max(at[3], 0.3 * lumen_.voxel_mm());
    }
  }

  [[nodiscard]] WallEquations wall_equations(std::size_t i) const {
    WallEquations equations;
    const double radius = tube_.radii[i];
    const Vec3& centre = tube_.centres[i];
    const Vec3 along = direction_at(tube_, i, static_cast<std::size_t>(std::lround(0.5 * radius / gap_mm_)));
    const Vec3 across = along.unitOrthogonal();
    const Vec3 third = along.cross(across);
    const auto pull = [&](const Vec3& direction, double weight) {
      equations.matrix.topLeftCorner<3, 3>() += weight * direction * direction.transpose();
    };
    for (int a = 0; a < 3; ++a) pull(Vec3::Unit(a), 1e-3 * kRays);
    pull(along, kRays);
    equations.matrix(3, 3) += 1e-3 * kRays;
    equations.side[3] += 1e-3 * kRays * radius;
    if (lumen_.inside(centre) < 0.5) {
      draw_back(centre, equations);
      return equations;
    }
    const double most = kRayRadii * radius + 2 * lumen_.voxel_mm();
    const double width = wide_ * radius + 0.4 * lumen_.voxel_mm();
    for (int n = 0; n < kRays; ++n) {
      const double turn = 2 * std::numbers::pi * n / kRays;
      const Vec3 direction = std::cos(turn) * across + std::sin(turn) * third;
      const double wall =
          exact_ ? lumen_.ray_by_area(centre, direction, most) : lumen_.ray(centre, direction, most);
      if (wall >= most || lumen_.is_guessed(centre + wall * direction, radius)) continue;
      // A wall within the tube is the vessel's own, as in a stenosis; one beyond it may be that of a sac or
      // branch.
      const double deviation = std::max(0.0, wall - radius) / width;
      const double fade = 1 + deviation * deviation;
      Vec4 row;
      row << direction, 1;
      equations.matrix += row * row.transpose() / (fade * fade);
      equations.side += row * wall / (fade * fade);
    }
    return equations;
  }

  void draw_back(const Vec3& centre, WallEquations& equations) const {
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < start_.size(); ++i)
      if ((start_.centres[i] - centre).squaredNorm() < (start_.centres[nearest] - centre).squaredNorm())
        nearest = i;
    Vec4 target;
    target << start_.centres[nearest] - centre, start_.radii[nearest];
    equations.matrix += kRays * Mat4::Identity();
    equations.side += kRays * target;
  }

  [[nodiscard]] std::vector<double> solve(const std::vector<std::size_t>& order,
                                          const std::vector<WallEquations>& walls) const {
    BandedMatrix<11> matrix(4 * order.size());
    std::vector<double> side(4 * order.size(), 0.0);
    for (std::size_t n = 0; n < order.size(); ++n) {
      const WallEquations& wall = walls[order[n]];
      for (int r = 0; r < 4; ++r) {
        side[4 * n + static_cast<std::size_t>(r)] += wall.side[r];
        for (int c = 0; c <= r; ++c)
          matrix.add(4 * n + static_cast<std::size_t>(r), 4 * n + static_cast<std::size_t>(c),
                     wall.matrix(r, c));
      }
    }
    for (std::size_t n = 1; n + 1 < order.size(); ++n) add_smoothness(n, order, matrix, side);
    return std::move(matrix).solve(std::move(side));
  }

  /// Second differences at a point, of the moved centres and of the radii.
  void add_smoothness(std::size_t n, const std::vector<std::size_t>& order, BandedMatrix<11>& matrix,
                      std::vector<double>& side) const {
    constexpr std::array<double, 3> kDifference = {1, -2, 1};
    const double radius = tube_.radii[order[n]];
    const double centre_weight = 0.5 * kRays * std::pow(kSmooth * radius / gap_mm_, 4);
    const double reach_mm = std::max(kSmooth * radius, kSmoothVoxels * lumen_.voxel_mm());
    const double radius_weight = kRays * std::pow(reach_mm / gap_mm_, 4);
    Vec3 bend = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) bend += kDifference[k] * tube_.centres[order[n + k - 1]];
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t component = 0; component < 4; ++component) {
        const double weight = component < 3 ? centre_weight : radius_weight;
        const std::size_t row = 4 * (n + k - 1) + component;
        if (component < 3) side[row] -= weight * kDifference[k] * bend[static_cast<Eigen::Index>(component)];
        for (std::size_t m = 0; m <= k; ++m)
          matrix.add(row, 4 * (n + m - 1) + component, weight * kDifference[k] * kDifference[m]);
      }
    }
  }

  const Lumen& lumen_;
  const Tube& start_;
  Tube tube_;
  double gap_mm_ = 1;
  double wide_ = 1;
  bool exact_ = false;  // Whether rays keep the area of thin vessels.
};

}  // namespace

Tube fitted(const Lumen& lumen, const Tube& start) {
  return TubeFitter(lumen, start).run();
}

}  // namespace lumesh::centerline
