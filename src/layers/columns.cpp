#include "columns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lumesh/core/angles.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"
#include "prism.hpp"
#include "unlayered.hpp"

namespace lumesh::layers {
namespace {

/// The prisms over one triangle, as its three columns stand.
class PrismCheck {
 public:
  PrismCheck(const ExtrusionFrame& frame, const Columns& columns) : frame_(frame), columns_(columns) {}

  [[nodiscard]] bool is_good(std::uint32_t triangle) const {
    const Cell<3>& c = frame_.surface.triangles[triangle];
    Fillings fillings;
    for (std::size_t i = 0; i < 3; ++i) fillings[i] = columns_.profile.filling(columns_.fraction[c[i]]);
    const auto [least, most] = std::minmax({fillings[0].count, fillings[1].count, fillings[2].count});
    const auto tets = tetrahedra_of_prism(c);
    std::array<Vec3, 3> lower = ends(c, fillings, -1);
    for (int k = 0; k < most; ++k) {
      const std::array<Vec3, 3> upper = ends(c, fillings, k);
      const double floor_deg = min_angle_deg(c, lower, upper, k);
      for (const PrismTet& tet : tets)
        if (k < fillings[doubled_column(tet)].count && !is_good(tet, lower, upper, floor_deg)) return false;
      const bool is_end = !columns_.profile.shrinks() && least <= k;
      if (!is_well_shaped(lower, upper, is_end ? kAtEnd : kWithin)) return false;
      lower = upper;
    }
    return true;
  }

 private:
  using Fillings = std::array<LayerProfile::Filling, 3>;

  [[nodiscard]] std::array<Vec3, 3> ends(const Cell<3>& c, const Fillings& fillings, int k) const {
    const auto end = [&](std::size_t i) { return frame_.point(columns_, c[i], fillings[i], k); };
    return {end(0), end(1), end(2)};
  }
  static bool is_good(const PrismTet& tet, const std::array<Vec3, 3>& lower, const std::array<Vec3, 3>& upper,
                      double floor_deg) {
    const auto corner = [&](std::size_t i) -> const Vec3& {
      return (tet[i].upper != 0 ? upper : lower)[tet[i].column];
    };
    if (orient3d(corner(0), corner(1), corner(2), corner(3)) <= 0) return false;
    const DihedralCosines angles = min_max_dihedral(corner(0), corner(1), corner(2), corner(3));
    const double max_cosine = cosine_deg(floor_deg);
    return angles.largest_cosine <= max_cosine && angles.smallest_cosine >= -max_cosine;
  }
  /// Cells as flat as the layer itself are what was asked for; much flatter ones, or less than a few degrees,
  /// are not. Nor is a layer that shrank much flatter than was wanted.
  [[nodiscard]] double min_angle_deg(const Cell<3>& c, const std::array<Vec3, 3>& lower,
                                     const std::array<Vec3, 3>& upper, int k) const {
    constexpr double kFloor = 2.5, kShareOfLayer = 0.3, kHardlyAny = 0.5;
    const LayerProfile& profile = columns_.profile;
    const double share =
        profile.shrinks() ? profile.level(k + 1) - (k > 0 ? profile.level(k) : 0) : profile.level(1);
    double height = std::numeric_limits<double>::infinity(), width = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double length = (upper[i] - lower[i]).norm();
      if (length > 0)
        height = std::min(height, std::max(length, kHardlyAny * share * columns_.wanted_mm[c[i]]));
      width = std::max(width, (lower[(i + 1) % 3] - lower[i]).norm());
    }
    return std::min(kFloor, kShareOfLayer * degrees(std::atan2(height, width)));
  }
  /// How a layer's upper triangle may stand to its lower one, and columns to both.
  struct Lean {
    double min_cosine, min_slope;
  };
  static constexpr Lean kWithin = {0.5, 0.35};
  /// Where a layer ends its cells are pyramids and tetrahedra, as high as the others: no prism follows.
  static constexpr Lean kAtEnd = {0.25, 0.2};

  static bool is_well_shaped(const std::array<Vec3, 3>& lower, const std::array<Vec3, 3>& upper,
                             const Lean& most) {
    constexpr double kMinArea = 0.25;
    const Vec3 below = triangle_area_normal(lower[0], lower[1], lower[2]),
               above = triangle_area_normal(upper[0], upper[1], upper[2]);
    const double area_below = below.norm(), area_above = above.norm();
    if (!(below.dot(above) >= most.min_cosine * area_below * area_above)) return false;
    if (!(area_above >= kMinArea * area_below)) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 side = upper[k] - lower[k];
      if (side.isZero(0)) continue;
      // With this, the corners of a prism are right whatever its diagonals would be.
      if (!(side.dot(below) >= most.min_slope * side.norm() * area_below)) return false;
      if (!(side.dot(above) >= most.min_slope * side.norm() * area_above)) return false;
    }
    return true;
  }

  const ExtrusionFrame& frame_;
  const Columns& columns_;
};

}  // namespace

void keep_cells_well_shaped(const ExtrusionFrame& frame, Columns& columns) {
  constexpr double kShorter = 0.75;
  constexpr int kPatientRounds = 60;
  const LayerSurface& surface = frame.surface;
  std::vector<std::uint8_t> is_stale(surface.triangles.size(), 1), is_bad(surface.triangles.size(), 0);
  for (int round = 0;; ++round) {  // Ends: every round shortens, in the end to nothing.
    const PrismCheck check(frame, columns);
    parallel::for_each_index(is_bad.size(), [&](std::size_t t) {
      if (is_stale[t] != 0) is_bad[t] = check.is_good(static_cast<std::uint32_t>(t)) ? 0 : 1;
    });
    const std::vector<double> before = columns.fraction;
    if (std::ranges::find(is_bad, 1) == is_bad.end()) {
      if (!make_termination_manifold(surface, columns)) return;
      if (!columns.profile.shrinks()) smooth_lengths(surface, columns);
    } else {
      const double factor = round < kPatientRounds ? kShorter : 0;
      parallel::for_each_index(surface.points.size(), [&](std::size_t v) {
        const auto around = surface.triangles_around.of(v);
        if (std::ranges::any_of(around, [&](std::uint32_t t) { return is_bad[t] != 0; }))
          columns.shorten(v, factor * columns.length_mm(v), LayerLimit::kShape);
      });
      smooth_lengths(surface, columns);
    }
    parallel::for_each_index(is_stale.size(), [&](std::size_t t) {
      const Cell<3>& c = surface.triangles[t];
      is_stale[t] =
          std::ranges::any_of(c, [&](std::uint32_t v) { return columns.fraction[v] != before[v]; }) ? 1 : 0;
    });
  }
}

}  // namespace lumesh::layers
