#include "lumesh/surface/contour.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "cell_loops.hpp"
#include "grid_sides.hpp"
#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::surfaces {
namespace {

/// Vertices of one loop within a cell.
struct VertexLoop {
  std::array<std::uint32_t, kCellEdges.size()> vertices;
  std::uint8_t count = 0;
};

/// Marching cubes on the sides of a grid's places; lengths in steps of the grid.
class MarchingCubes {
 public:
  MarchingCubes(const GridSides& sides, const Index3& size) : sides_(sides), size_(size) {}

  [[nodiscard]] Contour made() {
    number_vertices();
    place_vertices();
    for (const VertexLoop& loop : loops()) fill(loop);
    return std::move(contour_);
  }

 private:
  /// Calls visit(key) for the steps of a row across the boundary: 3 times the first place's number and axis.
  template <class Visit>
  void for_each_crossing(std::size_t row, const Visit& visit) const {
    Index3 place = grid_row(size_, row);
    const auto x = static_cast<std::size_t>(size_.x()), y = static_cast<std::size_t>(size_.y());
    const std::array<std::size_t, 3> steps = {1, x, x * y};
    for (std::size_t i = grid_offset(size_, place); place.x() < size_.x(); ++place.x(), ++i)
      for (int axis = 0; axis < 3; ++axis)
        if (place[axis] + 1 < size_[axis] &&
            sides_.is_inside(i) != sides_.is_inside(i + steps[static_cast<std::size_t>(axis)]))
          visit(3 * i + static_cast<std::size_t>(axis));
  }

  void number_vertices() {
    const std::size_t rows = grid_row_count(size_);
    first_of_row_.assign(rows + 1, 0);
    parallel::for_each_index(rows, 16, [&](std::size_t row) {
      for_each_crossing(row, [&](std::size_t) { ++first_of_row_[row + 1]; });
    });
    for (std::size_t row = 0; row < rows; ++row) first_of_row_[row + 1] += first_of_row_[row];
    keys_.resize(first_of_row_.back());
    parallel::for_each_index(rows, 16, [&](std::size_t row) {
      std::size_t next = first_of_row_[row];
      for_each_crossing(row, [&](std::size_t key) { keys_[next++] = key; });
    });
  }

  /// Loops in different cells share no point but those of common edges, as long as none is at a place.
  void place_vertices() {
    constexpr double kAside = 0.05;
    contour_.points.resize(keys_.size());
    contour_.given.resize(keys_.size());
    parallel::for_each_index(keys_.size(), 64, [&](std::size_t v) {
      const Index3 place = grid_place(size_, keys_[v] / 3);
      const int axis = static_cast<int>(keys_[v] % 3);
      const GridSides::Crossing crossing = sides_.crossing(place, axis);
      contour_.points[v] = place.cast<double>();
      contour_.points[v][axis] += std::clamp(crossing.share, kAside, 1 - kAside);
      contour_.given[v] = crossing.triangle;
    });
  }

  [[nodiscard]] std::uint32_t vertex(const Index3& place, int axis) const {
    const std::size_t offset = grid_offset(size_, place), row = offset / static_cast<std::size_t>(size_.x());
    const auto at = [&](std::size_t r) {
      return keys_.begin() + static_cast<std::ptrdiff_t>(first_of_row_[r]);
    };
    const std::size_t key = 3 * offset + static_cast<std::size_t>(axis);
    return static_cast<std::uint32_t>(std::lower_bound(at(row), at(row + 1), key) - keys_.begin());
  }

  [[nodiscard]] std::vector<VertexLoop> loops() const {
    return parallel::collect_blocks<VertexLoop>(
        grid_row_count(size_), 16, [&](std::size_t begin, std::size_t end, std::vector<VertexLoop>& out) {
          for (std::size_t row = begin; row < end; ++row) {
            const Index3 first = grid_row(size_, row);
            if (first.y() + 1 < size_.y() && first.z() + 1 < size_.z()) collect_loops(first, out);
          }
        });
  }
  /// Loops of the cells from a row of places on.
  void collect_loops(Index3 place, std::vector<VertexLoop>& out) const {
    const std::size_t first = grid_offset(size_, place), y = static_cast<std::size_t>(size_.x()),
                      z = y * static_cast<std::size_t>(size_.y());
    const auto inner_at = [&](std::size_t i) {  // Of the four corners with one x.
      return (sides_.is_inside(i) ? 1U : 0U) | (sides_.is_inside(i + y) ? 4U : 0U) |
             (sides_.is_inside(i + z) ? 16U : 0U) | (sides_.is_inside(i + y + z) ? 64U : 0U);
    };
    unsigned low = inner_at(first);
    for (; place.x() + 1 < size_.x(); ++place.x()) {
      const unsigned high = inner_at(first + static_cast<std::size_t>(place.x()) + 1);
      for (const CellLoop& edges : cell_loops()[low | high << 1]) {
        VertexLoop& loop = out.emplace_back();
        for (const std::uint8_t e : edges) {
          const auto& [corner, axis] = kCellEdges[e];
          const Index3 of_edge = place + Index3(corner & 1, corner >> 1 & 1, corner >> 2);
          loop.vertices[loop.count++] = vertex(of_edge, axis);
        }
      }
      low = high;
    }
  }

  /// Up to four vertices need no other; of more, two may lie on one face of the cell, where an edge between
  /// them could meet one of the next cell.
  void fill(const VertexLoop& loop) {
    const auto& v = loop.vertices;
    const auto length2 = [&](std::size_t a, std::size_t b) {
      return (contour_.points[v[a]] - contour_.points[v[b]]).squaredNorm();
    };
    if (loop.count == 3) {
      contour_.triangles.push_back({v[0], v[1], v[2]});
    } else if (loop.count == 4) {
      const std::size_t s = length2(0, 2) <= length2(1, 3) ? 0 : 1;
      contour_.triangles.push_back({v[s], v[s + 1], v[s + 2]});
      contour_.triangles.push_back({v[s], v[s + 2], v[(s + 3) % 4]});
    } else {
      fill_around_middle(std::span(v).first(loop.count));
    }
  }
  void fill_around_middle(std::span<const std::uint32_t> loop) {
    const auto centre = static_cast<std::uint32_t>(contour_.points.size());
    Vec3 middle = Vec3::Zero();
    std::uint32_t given = contour_.given[loop[0]];
    for (const std::uint32_t v : loop) {
      middle += contour_.points[v];
      if (contour_.given[v] == TriangleTree::kNone) given = TriangleTree::kNone;
    }
    contour_.points.emplace_back(middle / static_cast<double>(loop.size()));
    contour_.given.push_back(given);
    for (std::size_t i = 0; i < loop.size(); ++i)
      contour_.triangles.push_back({loop[i], loop[(i + 1) % loop.size()], centre});
  }

  const GridSides& sides_;
  Index3 size_;
  std::vector<std::size_t> first_of_row_;
  std::vector<std::size_t> keys_;  // Of the vertices, ascending.
  Contour contour_;
};

}  // namespace

PointGrid grid_around(std::span<const Vec3> points, double spacing_mm) {
  constexpr double kMargin = 1.5;  // Steps.
  const Box3 box = bounding_box(points);
  PointGrid grid{box.min() - Vec3::Constant(kMargin * spacing_mm), spacing_mm, {}};
  for (int axis = 0; axis < 3; ++axis)
    grid.size[axis] = static_cast<int>(std::ceil(box.sizes()[axis] / spacing_mm + 2 * kMargin)) + 1;
  return grid;
}

std::int64_t Contour::euler_number() const {
  // Each edge has two triangles.
  return static_cast<std::int64_t>(points.size()) - static_cast<std::int64_t>(triangles.size() / 2);
}

std::uint32_t Contour::count_parts() const {
  DisjointSets sets(points.size());
  for (const auto& [a, b, c] : triangles) {
    sets.merge(a, b);
    sets.merge(b, c);
  }
  std::uint32_t count = 0;
  for (std::uint32_t v = 0; v < points.size(); ++v)
    if (sets.find(v) == v) ++count;
  return count;
}

Contour contour_of_inside(const TriangleMesh& given, const PointGrid& grid) {
  Contour contour = MarchingCubes(GridSides(given, grid), grid.size).made();
  for (Vec3& p : contour.points) p = grid.origin_mm + grid.spacing_mm * p;
  return contour;
}

TriangleMesh with_patches(Contour contour, const TriangleMesh& given, const TriangleTree& tree) {
  TriangleMesh made;
  made.patches.reserve(contour.triangles.size());
  for (const auto& corners : contour.triangles) {
    const auto& [a, b, c] = corners;
    std::uint32_t triangle = contour.given[b] == contour.given[c] ? contour.given[b] : contour.given[a];
    if (triangle == TriangleTree::kNone)
      triangle = tree.nearest(triangle_centre(contour.points, corners)).triangle;
    made.patches.push_back(given.patches[triangle]);
  }
  made.points = std::move(contour.points);
  made.triangles = std::move(contour.triangles);
  return made;
}

}  // namespace lumesh::surfaces
