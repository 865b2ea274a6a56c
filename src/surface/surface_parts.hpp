#pragma once
// Connected parts of a surface that repair drops: specks, copies, and what hangs on others.

#include <cstdint>
#include <vector>

#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

struct MarkedTriangles {
  std::vector<std::uint8_t> is_marked;  ///< Flag of each triangle.
  std::uint64_t count = 0;
  std::uint64_t parts = 0;         ///< Parts that are marked as a whole.
  std::uint64_t largest = 0;       ///< Triangles of the largest of these.
  Vec3 largest_mm = Vec3::Zero();  ///< A place of that.
};

/// Single triangles that stand on an edge of the wall, with nothing at their other edges.
[[nodiscard]] MarkedTriangles fins(const TriangleMesh& surface);

/// Connected parts of a surface, which must stay as it is.
class SurfaceParts {
 public:
  /// Turns the triangles of each part alike.
  explicit SurfaceParts(TriangleMesh& surface);
  [[nodiscard]] std::size_t count() const { return parts_.size(); }

  /// Parts below a size, and those no farther from larger ones than a distance that are open or turned as
  /// those are.
  [[nodiscard]] MarkedTriangles specks_and_copies(double speck_mm, double distance_mm) const;
  /// Small open parts that hang on larger ones at points, as cutting leaves them at ragged ends.
  [[nodiscard]] MarkedTriangles hanging() const;
  /// Small open parts that reach no opening. @param opening_of  Of each vertex, or of the first ones; 0:
  /// none.
  [[nodiscard]] MarkedTriangles islands(const std::vector<std::uint32_t>& opening_of) const;

 private:
  struct Part {
    double area_mm2 = 0;
    Box3 box;
    bool is_open = false;
    std::vector<std::uint32_t> triangles;
  };

  void mark(const Part& part, MarkedTriangles& marked) const;
  [[nodiscard]] MarkedTriangles none() const { return {std::vector<std::uint8_t>(triangle_count_, 0)}; }
  [[nodiscard]] Vec3 middle_of(std::uint32_t t) const;
  [[nodiscard]] bool lies_on(const Part& part, const TriangleTree& tree, const std::vector<Cell<3>>& others,
                             double distance_mm, bool either_way) const;

  const TriangleMesh& surface_;
  std::size_t triangle_count_;
  std::vector<Part> parts_;
};

}  // namespace lumesh::surfaces
