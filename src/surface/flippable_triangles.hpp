#pragma once
// Triangles that know their neighbours, to be split and flipped.

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "lumesh/surface/edges.hpp"

namespace lumesh::surfaces {

/// Part of a surface with a border, no edge of more than two triangles.
class FlippableTriangles {
 public:
  static constexpr std::uint32_t kNone = kOpenEdge;
  struct Side {
    std::uint32_t triangle;
    std::size_t side;  // The edge from this corner to the next.
  };

  FlippableTriangles() = default;
  explicit FlippableTriangles(std::vector<Cell<3>> triangles);

  [[nodiscard]] const std::vector<Cell<3>>& triangles() const { return triangles_; }
  /// Triangle behind a side; kNone at the border.
  [[nodiscard]] std::uint32_t neighbour(const Side& at) const { return neighbours_[at.triangle][at.side]; }
  [[nodiscard]] std::uint32_t vertex(const Side& at, std::size_t step) const {
    return triangles_[at.triangle][(at.side + step) % 3];
  }
  /// The corner of the neighbour across a side.
  [[nodiscard]] std::uint32_t vertex_across(const Side& at) const;
  /// Every side once for each of its triangles.
  [[nodiscard]] std::vector<Side> sides() const;
  /// Triangles that were made or changed since the last call; may hold some twice.
  [[nodiscard]] std::vector<std::uint32_t> take_changed() { return std::exchange(changed_, {}); }

  /// Joins the other two corners of the two triangles at a side. @return The sides around.
  std::array<Side, 4> flip(const Side& at);
  /// Joins a new vertex with the corners of a triangle. @return The sides around.
  std::array<Side, 3> split(std::uint32_t triangle, std::uint32_t vertex);

 private:
  void set(std::uint32_t triangle, const Cell<3>& corners, const std::array<std::uint32_t, 3>& neighbours);
  [[nodiscard]] std::size_t side_towards(std::uint32_t triangle, std::uint32_t other) const;

  std::vector<Cell<3>> triangles_;
  EdgeNeighbours neighbours_;
  std::vector<std::uint32_t> changed_;
};

}  // namespace lumesh::surfaces
