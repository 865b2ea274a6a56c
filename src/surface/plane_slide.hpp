#pragma once
// Vertices that slide along a surface into a plane near by.

#include <cmath>
#include <cstdint>
#include <vector>

#include "lumesh/mesh/triangle_mesh.hpp"
#include "lumesh/parallel/adjacency.hpp"

namespace lumesh::surfaces {

/// Moves vertices of a surface into a plane, so that a cut there makes no slivers.
class PlaneSlide {
 public:
  /// @param around  Triangles around each vertex. @param normal  Of the plane, unit.
  /// @param heights  Of the vertices over the plane; those that are moved get 0.
  PlaneSlide(TriangleMesh& surface, const parallel::Adjacency& around, const Vec3& normal,
             std::vector<double>& heights)
      : surface_(surface), around_(around), normal_(normal), heights_(heights) {}

  /// Nearer to the plane than a share of the edges there, but not in it.
  [[nodiscard]] bool is_within(std::uint32_t v, double share) const {
    return heights_[v] != 0 && std::abs(heights_[v]) < share * mean_edge_at(v);
  }
  /// False if that would bend or flatten a triangle, or lay one into the plane; the vertex stays then.
  bool move(std::uint32_t v);

 private:
  [[nodiscard]] double mean_edge_at(std::uint32_t v) const;
  [[nodiscard]] Vec3 area_normal(std::uint32_t t) const;

  TriangleMesh& surface_;
  const parallel::Adjacency& around_;
  Vec3 normal_;
  std::vector<double>& heights_;
};

}  // namespace lumesh::surfaces
