#pragma once
// A triangulation of a polygon of the plane that can be flipped and refined.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lumesh/geometry/predicates.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::surfaces {

/// Triangles stay anticlockwise by the exact predicate, and edges of the polygon stay.
class FlatTriangulation {
 public:
  static constexpr std::uint32_t kNone = ~0U;

  /// Of a simple polygon that runs anticlockwise, by cutting off ears; not Delaunay yet.
  explicit FlatTriangulation(std::span<const Vec2> corners);

  /// Flips edges until all but those of the polygon are Delaunay (Lawson 1977).
  void make_delaunay();
  /// Adds a point strictly within a triangle, and flips edges around it.
  void insert(const Vec2& point, std::uint32_t triangle);
  /// The triangle that holds a point strictly inside, on a straight way from another triangle's middle; none if
  /// the way leaves the polygon or ends on an edge.
  [[nodiscard]] std::optional<std::uint32_t> locate(const Vec2& point, std::uint32_t from) const;
  /// Moves points inside to the middles of their neighbours where the smallest angle there grows.
  void smooth();

  [[nodiscard]] const std::vector<Vec2>& points() const { return points_; }
  [[nodiscard]] const std::vector<Cell<3>>& triangles() const { return triangles_; }
  /// Triangle behind the edge from corner i to the next; kNone at the polygon.
  [[nodiscard]] std::uint32_t neighbour(std::uint32_t triangle, std::size_t side) const {
    return neighbours_[triangle][side];
  }
  /// Triangles that were made or changed since the last call; may hold some twice.
  [[nodiscard]] std::vector<std::uint32_t> take_changed() { return std::exchange(changed_, {}); }
  [[nodiscard]] const Vec2& corner(std::uint32_t triangle, std::size_t i) const {
    return points_[triangles_[triangle][i % 3]];
  }

 private:
  struct Side {
    std::uint32_t triangle;
    std::size_t side;
  };
  void cut_off_ears();
  void find_neighbours();
  void flip_from(std::vector<Side> stack);
  [[nodiscard]] bool should_flip(const Side& at) const;
  void flip(const Side& at, std::vector<Side>& stack);
  void set(std::uint32_t triangle, const Cell<3>& corners, const std::array<std::uint32_t, 3>& neighbours);
  [[nodiscard]] std::size_t side_towards(std::uint32_t triangle, std::uint32_t other) const;

  std::vector<Vec2> points_;
  std::size_t corner_count_;
  std::vector<Cell<3>> triangles_;
  std::vector<std::array<std::uint32_t, 3>> neighbours_;
  std::vector<std::uint32_t> changed_;
};

}  // namespace lumesh::surfaces
