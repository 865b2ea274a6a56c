#include "lumesh/domain/opening_sizes.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lumesh/geometry/triangle.hpp"

namespace lumesh {
namespace {

/// From the centre to the farthest corner of a square.
double reach_mm(const Opening& opening) {
  if (!opening.squares) return opening.radius_mm();
  const OpeningSquares& squares = *opening.squares;
  double reach_mm = 0;
  for (int row = 0; row < squares.rows; ++row)
    for (int column = 0; column < squares.columns; ++column)
      if (squares.hold(column, row))
        reach_mm = std::max(reach_mm, (squares.centre_of(column, row) - opening.centre_mm).norm());
  return reach_mm + 0.5 * std::numbers::sqrt2 * squares.step_mm;
}

}  // namespace

double OpeningSize::distance_mm(const Vec3& place) const {
  const Vec3 off = place - centre_mm;
  const double above_mm = off.dot(normal);
  const double beyond_mm = std::sqrt(std::max(0.0, off.squaredNorm() - above_mm * above_mm)) - radius_mm;
  return std::hypot(above_mm, std::max(0.0, beyond_mm));
}

OpeningSizes::OpeningSizes(const Domain& domain)
    : domain_(&domain),
      openings_(find_openings(domain)),
      edges_mm_(openings_.size(), std::numeric_limits<double>::infinity()),
      halvings_(openings_.size(), 0) {}

OpeningSizes::Faults OpeningSizes::faults_in(const MeshView& mesh) const {
  const OpeningsCompared compared = compare_openings(mesh, openings_);
  Faults faults;
  for (std::size_t o = 0; o < compared.openings.size(); ++o) {
    const OpeningInMesh& found = compared.openings[o];
    if (!is_coarse(found)) continue;
    faults.weight += is_wrong(found) ? 2 : 1;
    faults.which.push_back(o);
    faults.edges_mm.push_back(found.shape.edge_mm);
  }
  faults.walls = walls_in_planes(mesh, *domain_);
  faults.weight += 2 * faults.walls.size();
  return faults;
}

bool OpeningSizes::refine(const Faults& faults) {
  constexpr double kMinOfResolution = 0.35;
  constexpr double kEdgesAround = 8;
  constexpr double kMinFaces = 2, kShorter = 0.8;
  const double min_mm = kMinOfResolution * domain_->resolution_mm();
  bool is_finer = false;
  for (std::size_t i = 0; i < faults.which.size(); ++i) {
    const Opening& opening = openings_[faults.which[i]];
    if (opening.area_mm2 < kMinFaces * voxel_face_mm2(*domain_, opening.normal)) continue;
    const double made_mm =
        faults.edges_mm[i] > 0 ? faults.edges_mm[i] : opening.perimeter_mm() / kEdgesAround;
    double& edge_mm = edges_mm_[faults.which[i]];
    const double before_mm = std::isfinite(edge_mm) ? edge_mm : made_mm;
    const double next_mm = std::max(0.5 * before_mm, min_mm);
    if (next_mm > kShorter * before_mm) continue;
    edge_mm = next_mm;
    ++halvings_[faults.which[i]];
    is_finer = true;
  }
  for (const WallInPlane& wall : faults.walls) {
    const OpeningSize size{wall.centre_mm, wall.normal, circle_radius(wall.area_mm2),
                           std::max(0.5 * std::sqrt(wall.area_mm2), min_mm), 1};
    if (std::ranges::any_of(at_walls_, [&](const OpeningSize& other) {
          return other.edge_mm <= size.edge_mm && other.distance_mm(size.centre_mm) < other.edge_mm;
        }))
      continue;
    at_walls_.push_back(size);
    is_finer = true;
  }
  sizes_ = at_walls_;
  for (std::size_t o = 0; o < openings_.size(); ++o)
    if (std::isfinite(edges_mm_[o]))
      sizes_.push_back(
          {openings_[o].centre_mm, openings_[o].normal, reach_mm(openings_[o]), edges_mm_[o], halvings_[o]});
  return is_finer;
}

std::string OpeningSizes::text() const {
  double shortest_mm = std::numeric_limits<double>::infinity();
  for (const OpeningSize& size : sizes_) shortest_mm = std::min(shortest_mm, size.edge_mm);
  std::vector<std::string> names;
  for (std::size_t o = 0; o < openings_.size(); ++o)
    if (std::isfinite(edges_mm_[o])) names.push_back(openings_[o].name);
  if (!at_walls_.empty()) names.emplace_back("walls in planes of openings");
  return fmt::format("{:.2g} mm and more at {}", shortest_mm, fmt::join(names, ", "));
}

std::size_t max_cells_made_again(std::size_t cells) {
  constexpr std::size_t kTimes = 4, kSmall = 50'000;
  return std::max(kTimes * cells, kSmall);
}

}  // namespace lumesh
