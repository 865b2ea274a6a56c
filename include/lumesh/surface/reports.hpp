#pragma once
/// @file What was closed and repaired of a triangle surface.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh::surfaces {

/// A simple closed loop of edges that have one triangle each, and its best plane: through its centre, across
/// its area vector (the direction along which it surrounds the most area).
struct Rim {
  std::vector<std::uint32_t> vertices;  ///< In order; the surface goes from each one to the next.
  Vec3 centre_mm = Vec3::Zero();        ///< Centre of its edges.
  Vec3 normal = Vec3::Zero();  ///< Unit, out of the object where triangles point outwards; zero for a slit.
  double area_mm2 = 0;         ///< That it surrounds in its plane.
  double radius_mm = 0;        ///< Radius of the circle with the same area.
  double deviation_mm = 0;     ///< Largest distance of a vertex from the plane.
  double mean_edge_mm = 0;

  [[nodiscard]] double height_mm(const Vec3& point_mm) const { return normal.dot(point_mm - centre_mm); }
  /// An opening has a radius of at least this many edges, or as many edges around as that makes of a circle,
  /// which are long where a rim is ragged; what is smaller is a hole of the wall.
  static constexpr double kMinEdges = 2;
  static constexpr std::size_t kMinAround = 12;
  /// The deviation of an opening, in radii.
  static constexpr double kMaxBent = 0.15;
  /// As coarse as an end of eight edges; where it is planar, and the wall leaves its plane at an angle, it is
  /// one.
  [[nodiscard]] bool may_be_end() const { return radius_mm >= 1.2 * mean_edge_mm; }
  [[nodiscard]] bool is_wide() const {
    return radius_mm >= kMinEdges * mean_edge_mm || (vertices.size() >= kMinAround && may_be_end());
  }
  /// True if the rim leaves its plane by at most 2 % of an edge: what files round, or hardly moves a
  /// triangle.
  [[nodiscard]] bool is_almost_planar() const {
    constexpr double kShare = 0.02;  // Of an edge.
    return deviation_mm <= kShare * mean_edge_mm;
  }
  /// Radius in edges of the coarsest end, four around.
  static constexpr double kMinEndEdges = 0.5;
  /// True for the rim of an end by its plane alone, if the wall leaves that at an angle: one that is almost
  /// planar, or of few edges that lie in one plane up to rounding, as no hole of a wall does.
  [[nodiscard]] bool is_planar_end() const {
    constexpr double kRounding = 1e-4;  // Of an edge.
    return (is_almost_planar() && may_be_end()) ||
           (deviation_mm <= kRounding * mean_edge_mm && radius_mm >= kMinEndEdges * mean_edge_mm);
  }
  [[nodiscard]] bool is_flat() const { return deviation_mm <= kMaxBent * radius_mm; }
};

/// A rim, and what it was closed with.
struct ClosedRim {
  bool is_opening = false;        ///< A flat cap; else a piece of the wall.
  std::string name = {};          ///< Name of the opening, where somebody gave it one.
  Rim given;                      ///< The rim as it was; its vertices count no more.
  Vec3 centre_mm = Vec3::Zero();  ///< Centre of the area of the new triangles.
  Vec3 normal = Vec3::Zero();     ///< Unit, out of the object.
  double area_mm2 = 0;            ///< Area of the new triangles.
  double cut_off_mm = 0;          ///< Height of what was cut off to make the rim planar.
  double moved_mm = 0;            ///< Farthest way of a vertex on the wall.
  bool was_capped = false;        ///< It was closed by a cap that is not flat, which was taken off.
  bool is_ring = false;           ///< The cap goes around rims within it.
  bool ends_wall = false;         ///< True for a hole to which a wall runs up, as to the end of a vessel.
  std::int32_t patch = 0;         ///< Patch of the new triangles.
  std::size_t triangles = 0;      ///< New ones.
  double smallest_angle_deg = 0;  ///< Smallest angle of the new triangles.
};

struct FarthestPoint {
  double distance_mm = 0;
  Vec3 place_mm = Vec3::Zero();  ///< On the surface that was walked over.
};

/// Counts of a repair.
struct RepairReport {
  std::uint64_t duplicate_triangles = 0;  ///< Left out.
  std::uint64_t shared_triangles = 0;     ///< Both copies of faces between two pieces, left out.
  std::uint64_t seam_vertices = 0;        ///< Joined with what lies across a seam.
  std::uint64_t loose_triangles = 0;      ///< Left out, as they, or their part, hang at corners only.
  std::uint64_t hanging_triangles = 0;    ///< Triangles of the largest such part.
  Vec3 hanging_mm = Vec3::Zero();         ///< A place of that.
  std::uint64_t stray_pieces = 0;         ///< Flat pieces by themselves that enclose nothing, left out.
  double stray_area_mm2 = 0;              ///< Area of all of these.
  Vec3 stray_mm = Vec3::Zero();           ///< A place of the largest.
  std::uint64_t dropped_parts = 0;        ///< Specks, and parts that lie on others.
  std::uint64_t dropped_triangles = 0;    ///< Triangles of those parts.
  std::uint64_t singular_edges = 0;       ///< Edges of three triangles or more, cut.
  std::uint64_t singular_points = 0;      ///< Points of more than one fan, divided.
  std::uint64_t turned_triangles = 0;
  std::uint64_t flipped_edges = 0;   ///< Beside triangles without area.
  std::uint64_t holes = 0;           ///< Filled ones of the given surface.
  double widest_hole_mm = 0;         ///< Radius.
  std::uint64_t moved_vertices = 0;  ///< Put back, as they were pulled past their neighbours.
  std::uint64_t far_vertices = 0;    ///< Vertices among those put back farther than may move.
  FarthestPoint put_back;  ///< The farthest distance of the triangles at those, and where the vertex was.
  int rounds = 0;          ///< In which triangles that cross were replaced.
  std::uint64_t removed_triangles = 0;  ///< In those rounds.
  std::uint64_t cut_triangles = 0;      ///< Cut along the lines where they cross others.
  std::uint64_t inner_triangles = 0;    ///< Of those and pieces of them, left out as they lie inside.
  std::uint64_t inner_openings = 0;     ///< Openings that lay inside and went with those.
  std::uint64_t new_triangles = 0;      ///< Triangles that were not given.
  std::uint64_t openings = 0;           ///< That were left open.
  std::uint64_t components = 0;
  std::int64_t genus = 0;
  /// The farther of both sides of the Hausdorff distance, but for fillings of holes that were given,
  /// parts that were dropped, and triangles at vertices of `far_vertices`.
  FarthestPoint moved;
};

}  // namespace lumesh::surfaces
