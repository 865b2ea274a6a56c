#include "surface_rebuild.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/surface/contour.hpp"
#include "lumesh/surface/distance.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/winding.hpp"

namespace lumesh {
namespace {

constexpr double kInsideWinding = 0.5;  // Winding number.
constexpr double kMaxPlaces = 3e7;      // Of a grid.

/// A given surface, and questions to it.
class GivenSurface {
 public:
  explicit GivenSurface(const TriangleMesh& mesh)
      : mesh_(mesh), tree_(mesh.points, mesh.triangles), winding_(mesh.points, mesh.triangles) {
    std::vector<Cell<3>> triangles = mesh.triangles;
    parts_ = surfaces::turn_alike(triangles, surfaces::edge_neighbours(triangles)).count;
    is_closed_ = surfaces::closing_edges(mesh.triangles).empty();
  }

  /// Radius around a place on a triangle within which the surface has inside on both sides; below zero where
  /// there is outside on one. What is closed has one winding number up to its nearest triangle.
  [[nodiscard]] double inside_within(const Vec3& point, std::size_t triangle, double step_mm) const {
    const Vec3 step = step_mm * triangle_normal(mesh_.points, mesh_.triangles[triangle]);
    if (winding_.at(point + step) < kInsideWinding || winding_.at(point - step) < kInsideWinding) return -1;
    return is_closed_ ? std::min(tree_.nearest(point + step).distance, tree_.nearest(point - step).distance)
                      : 0;
  }
  [[nodiscard]] std::uint32_t parts() const { return parts_; }
  [[nodiscard]] const TriangleTree& tree() const { return tree_; }

 private:
  const TriangleMesh& mesh_;
  TriangleTree tree_;
  WindingNumbers winding_;
  std::uint32_t parts_;
  bool is_closed_;
};

/// @param max_distance_mm  What it may move at most.
RebuiltSurface rebuilt_from(surfaces::Contour contour, double spacing_mm, const TriangleMesh& given,
                            const GivenSurface& surface, double max_distance_mm) {
  RebuiltSurface made;
  made.spacing_mm = spacing_mm;
  if (contour.triangles.empty()) {
    made.failure = "nothing of its inside is left when it is rebuilt";
    made.failure_mm = given.points[given.triangles.front()[0]];
    return made;
  }
  const bool falls_apart = contour.count_parts() > surface.parts();
  surfaces::make_even(contour, given, surface.tree(), spacing_mm);
  made.surface = surfaces::with_patches(std::move(contour), given, surface.tree());
  const double step = max_distance_mm / 4;
  const TriangleTree tree(made.surface.points, made.surface.triangles);
  const surfaces::FarthestPoint out = surfaces::farthest_from(
      given, tree, step, nullptr,
      [&](const Vec3& p, std::size_t t) { return surface.inside_within(p, t, max_distance_mm / 2); });
  const surfaces::FarthestPoint back = surfaces::farthest_from(made.surface, surface.tree(), step);
  made.moved = back.distance_mm > out.distance_mm ? back : out;
  if (made.moved.distance_mm > max_distance_mm) {
    made.failure = "rebuilt it would move farther than asked";
    made.failure_mm = made.moved.place_mm;
  } else if (falls_apart) {
    made.failure = "rebuilt it falls apart";
    made.failure_mm = made.surface.points[0];
  }
  return made;
}

[[nodiscard]] bool have_one_topology(const surfaces::Contour& a, const surfaces::Contour& b) {
  return a.euler_number() == b.euler_number() && a.count_parts() == b.count_parts();
}

}  // namespace

/// On a grid twice as coarse, with a quarter of the triangles, where that has the same parts and handles.
RebuiltSurface rebuild_surface(const TriangleMesh& given, double max_distance_mm) {
  constexpr int kTries = 3;
  const GivenSurface surface(given);
  RebuiltSurface made;
  made.failure = "so small a distance needs too fine a grid";
  const auto grid_of = [&](double spacing_mm) { return surfaces::grid_around(given.points, spacing_mm); };
  double spacing = max_distance_mm / 2;
  for (int n = 0; n < kTries; ++n, spacing /= 2) {
    const surfaces::PointGrid grid = grid_of(spacing);
    if (grid.size.cast<double>().prod() > kMaxPlaces) break;
    surfaces::Contour contour = surfaces::contour_of_inside(given, grid);
    surfaces::Contour coarse;
    if (n == 0) coarse = surfaces::contour_of_inside(given, grid_of(2 * spacing));
    if (!coarse.triangles.empty() && have_one_topology(coarse, contour)) {
      made = rebuilt_from(std::move(coarse), 2 * spacing, given, surface, max_distance_mm);
      if (made.failure.empty()) break;
    }
    made = rebuilt_from(std::move(contour), spacing, given, surface, max_distance_mm);
    // Grids move a surface by about a step: what is off by more is so on finer ones, too.
    constexpr double kSteps = 2;
    if (made.failure.empty() || made.moved.distance_mm > max_distance_mm + kSteps * spacing) break;
  }
  return made;
}

}  // namespace lumesh
