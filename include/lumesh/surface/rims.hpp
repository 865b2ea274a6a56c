#pragma once
/// @file Rims: where a triangle surface ends, and what ends there.

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

/// A simple closed loop of edges that have one triangle each, and its best plane: through its centre, across
/// its area vector (the direction along which it surrounds the most area).
struct Rim {
  std::vector<std::uint32_t> vertices;  ///< In order; the surface goes from each one to the next.
  Vec3 centre_mm = Vec3::Zero();        ///< Of its edges.
  Vec3 normal = Vec3::Zero();  ///< Unit, out of the object where triangles point outwards; zero for a slit.
  double area_mm2 = 0;         ///< That it surrounds in its plane.
  double radius_mm = 0;        ///< Of the circle with the same area.
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
  [[nodiscard]] bool is_flat() const { return deviation_mm <= kMaxBent * radius_mm; }
};

/// Rims by their first vertices. Triangles must be turned alike (turn_alike()). A loop that passes a vertex
/// twice, as where two rims touch, is two of them. Edges with more than two triangles are not looked at;
/// chains that end at those are left out.
[[nodiscard]] std::vector<Rim> find_rims(const TriangleMesh& surface);

/// The rim through these vertices, measured.
[[nodiscard]] Rim measured_rim(std::span<const Vec3> points, std::vector<std::uint32_t> vertices);

/// Turns the parts of a surface (turn_alike()) that enclose a negative volume, rims closed by fans.
/// @param rims  Of the surface; turned with it.
void turn_outwards(TriangleMesh& surface, std::vector<Rim>& rims);

}  // namespace lumesh::surfaces
