#pragma once
// A triangulation of a polygon of the plane that can be flipped and refined.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "flippable_triangles.hpp"
#include "lumesh/geometry/predicates.hpp"

namespace lumesh::surfaces {

/// Whether closed segments share a point, exactly.
[[nodiscard]] bool do_segments_meet(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d);

/// Triangles stay anticlockwise by the exact predicate, and edges of the polygon stay.
class FlatTriangulation {
 public:
  /// Triangulates a simple polygon that runs anticlockwise, without the holes in it, which run clockwise, by
  /// cutting off ears; not Delaunay yet. Points are those of the polygon, then those of the holes in order.
  explicit FlatTriangulation(std::span<const Vec2> corners, std::span<const std::vector<Vec2>> holes = {});

  /// Flips edges until all but those of the polygon are Delaunay (Lawson 1977).
  void make_delaunay();
  /// Adds a point strictly within a triangle, and flips edges around it.
  void insert(const Vec2& point, std::uint32_t triangle);
  /// The triangle that holds a point strictly inside, on a straight way from another triangle's middle; none
  /// if the way leaves the polygon or ends on an edge.
  [[nodiscard]] std::optional<std::uint32_t> locate(const Vec2& point, std::uint32_t from) const;
  /// Moves points inside to the middles of their neighbours where the smallest angle there grows.
  void smooth();

  [[nodiscard]] const std::vector<Vec2>& points() const { return points_; }
  [[nodiscard]] const std::vector<Cell<3>>& triangles() const { return mesh_.triangles(); }
  /// Whether the edge from corner i to the next is one of the polygon.
  [[nodiscard]] bool is_border(std::uint32_t triangle, std::size_t i) const {
    return mesh_.neighbour({triangle, i}) == FlippableTriangles::kNone;
  }
  [[nodiscard]] std::vector<std::uint32_t> take_changed() { return mesh_.take_changed(); }
  [[nodiscard]] const Vec2& corner(std::uint32_t triangle, std::size_t i) const {
    return points_[triangles()[triangle][i % 3]];
  }

 private:
  using Side = FlippableTriangles::Side;
  struct Bridge {
    std::size_t from, loop, to;  // Place in the outline; which hole, and place in it.
  };
  [[nodiscard]] std::vector<std::uint32_t> outline_with_holes(std::size_t outer,
                                                              std::span<const std::vector<Vec2>> holes) const;
  [[nodiscard]] Bridge shortest_bridge(const std::vector<std::uint32_t>& outline,
                                       const std::vector<std::vector<std::uint32_t>>& loops) const;
  [[nodiscard]] bool meets_edge(const std::vector<std::uint32_t>& loop, std::uint32_t p,
                                std::uint32_t q) const;
  [[nodiscard]] std::vector<Cell<3>> cut_off_ears(std::vector<std::uint32_t> left) const;
  void flip_from(std::vector<Side> stack);
  [[nodiscard]] bool should_flip(const Side& at) const;

  std::vector<Vec2> points_;
  std::size_t corner_count_;
  FlippableTriangles mesh_;
};

}  // namespace lumesh::surfaces
