#pragma once
/// @file Which points of a grid lie in a tetrahedron.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "lumesh/core/types.hpp"
#include "lumesh/image/runs.hpp"
#include "lumesh/mesh/all_cells.hpp"

namespace lumesh::quality {

/// The closed tetrahedron over four points of a grid, in its steps, asked row by row.
class RowsOfTetrahedron {
 public:
  explicit RowsOfTetrahedron(const std::array<Vec3, 4>& corners) {
    for (const Vec3& p : corners) box_.extend(p);
    for (std::size_t side = 0; side < 4; ++side) {
      const Vec3& a = corners[(side + 1) % 4];
      Vec3 normal = (corners[(side + 2) % 4] - a).cross(corners[(side + 3) % 4] - a);
      const double length = normal.norm();
      const double height = length > 0 ? normal.dot(corners[side] - a) / length : 0;
      if (std::abs(height) <= kRounding) flat_ = true;
      normal *= (height > 0 ? -1 : 1) / (length > 0 ? length : 1);
      normals_[side] = normal;
      bounds_[side] = normal.dot(a) + kRounding;
    }
  }

  [[nodiscard]] bool flat() const { return flat_; }
  /// Whole numbers from first to last lie in its box along an axis.
  [[nodiscard]] std::int32_t first(int axis) const { return first_from(box_.min()[axis]); }
  [[nodiscard]] std::int32_t last(int axis) const { return last_to(box_.max()[axis]); }

  /// The points [begin, end) of row (j, k) that it holds.
  [[nodiscard]] image::Run in_row(int j, int k) const {
    double low = box_.min().x(), high = box_.max().x();
    for (std::size_t side = 0; side < 4; ++side) {
      const Vec3& n = normals_[side];
      const double rest = bounds_[side] - n.y() * j - n.z() * k;  // n.x() * i <= rest
      if (n.x() > 0)
        high = std::min(high, rest / n.x());
      else if (n.x() < 0)
        low = std::max(low, rest / n.x());
      else if (rest < 0)
        return {0, 0, 0};
    }
    if (!(low <= high + 2 * kRounding)) return {0, 0, 0};
    return {first_from(low), last_to(high) + 1, 0};
  }

 private:
  static constexpr double kRounding = 1e-9;  // Of a point against a side.

  [[nodiscard]] static std::int32_t first_from(double low) {
    return static_cast<std::int32_t>(std::ceil(std::max(low, -1e9) - kRounding));
  }
  [[nodiscard]] static std::int32_t last_to(double high) {
    return static_cast<std::int32_t>(std::floor(std::min(high, 1e9) + kRounding));
  }

  std::array<Vec3, 4> normals_;  // Outward, unit.
  std::array<double, 4> bounds_;
  Box3 box_;
  bool flat_ = false;
};

/// Calls use(tetrahedron) for the parts of a cell that are not flat: a tetrahedron itself, and of other
/// shapes the tetrahedra between their centre and their sides. Points as in the mesh, in steps of the grid.
template <class Use>
void for_each_tetrahedron(const MeshView& mesh, const AllCells& cells, std::size_t cell,
                          std::span<const Vec3> points, const Use& use) {
  const auto use_one = [&](const std::array<Vec3, 4>& corners) {
    const RowsOfTetrahedron rows(corners);
    if (!rows.flat() && rows.first(0) <= rows.last(0)) use(rows);
  };
  if (cell < mesh.tetrahedra.size()) {
    const auto& [a, b, c, d] = mesh.tetrahedra[cell];
    return use_one({points[a], points[b], points[c], points[d]});
  }
  const CellTriangles sides = cells.triangles(cell);
  Vec3 centre = Vec3::Zero();
  for (const auto& [a, b, c] : sides) centre += (points[a] + points[b] + points[c]) / (3 * sides.count);
  for (const auto& [a, b, c] : sides) use_one({points[a], points[b], points[c], centre});
}

/// Calls use(run number, begin, end) for the parts of an image's runs that the tetrahedron holds, none of
/// them empty: a tetrahedron that passes between two voxels holds neither.
template <class Use>
void for_each_held_run(const RowsOfTetrahedron& rows, const image::RunImage& image, const Use& use) {
  for (int k = std::max(0, rows.first(2)); k <= std::min(image.size.z() - 1, rows.last(2)); ++k)
    for (int j = std::max(0, rows.first(1)); j <= std::min(image.size.y() - 1, rows.last(1)); ++j) {
      const image::Run held = rows.in_row(j, k);
      if (held.begin >= held.end) continue;
      const std::span<const image::Run> row = image.of_row(image.row(j, k));
      auto run = std::partition_point(row.begin(), row.end(),
                                      [&](const image::Run& r) { return r.end <= held.begin; });
      for (; run != row.end() && run->begin < held.end; ++run)
        use(static_cast<std::size_t>(&*run - image.runs.data()), std::max(run->begin, held.begin),
            std::min(run->end, held.end));
    }
}

}  // namespace lumesh::quality
