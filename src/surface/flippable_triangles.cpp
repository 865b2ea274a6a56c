#include "flippable_triangles.hpp"

namespace lumesh::surfaces {

FlippableTriangles::FlippableTriangles(std::vector<Cell<3>> triangles)
    : triangles_(std::move(triangles)), neighbours_(edge_neighbours(triangles_)) {
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) changed_.push_back(t);
}

std::size_t FlippableTriangles::side_towards(std::uint32_t triangle, std::uint32_t other) const {
  for (std::size_t s = 0; s < 2; ++s)
    if (neighbours_[triangle][s] == other) return s;
  return 2;
}

std::uint32_t FlippableTriangles::vertex_across(const Side& at) const {
  const std::uint32_t other = neighbour(at);
  return triangles_[other][(side_towards(other, at.triangle) + 2) % 3];
}

std::vector<FlippableTriangles::Side> FlippableTriangles::sides() const {
  std::vector<Side> all;
  for (std::uint32_t t = 0; t < triangles_.size(); ++t)
    for (const std::size_t s : {0U, 1U, 2U}) all.push_back({t, s});
  return all;
}

void FlippableTriangles::set(std::uint32_t triangle, const Cell<3>& corners,
                             const std::array<std::uint32_t, 3>& neighbours) {
  triangles_[triangle] = corners;
  neighbours_[triangle] = neighbours;
  changed_.push_back(triangle);
}

/// (a, b, c) and (b, a, d) become (c, a, d) and (d, b, c).
std::array<FlippableTriangles::Side, 4> FlippableTriangles::flip(const Side& at) {
  const std::uint32_t t = at.triangle, o = neighbour(at);
  const std::size_t s = at.side, r = side_towards(o, t);
  const std::uint32_t a = vertex(at, 0), b = vertex(at, 1), c = vertex(at, 2), d = vertex_across(at);
  const std::uint32_t over_bc = neighbours_[t][(s + 1) % 3], over_ca = neighbours_[t][(s + 2) % 3];
  const std::uint32_t over_ad = neighbours_[o][(r + 1) % 3], over_db = neighbours_[o][(r + 2) % 3];
  if (over_bc != kNone) neighbours_[over_bc][side_towards(over_bc, t)] = o;
  if (over_ad != kNone) neighbours_[over_ad][side_towards(over_ad, o)] = t;
  set(t, {c, a, d}, {over_ca, over_ad, o});
  set(o, {d, b, c}, {over_db, over_bc, t});
  return {Side{t, 0}, Side{t, 1}, Side{o, 0}, Side{o, 1}};
}

std::array<FlippableTriangles::Side, 3> FlippableTriangles::split(std::uint32_t triangle,
                                                                  std::uint32_t vertex) {
  const auto second = static_cast<std::uint32_t>(triangles_.size()), third = second + 1;
  const auto [a, b, c] = triangles_[triangle];
  const auto [over_ab, over_bc, over_ca] = neighbours_[triangle];
  triangles_.resize(third + 1);
  neighbours_.resize(third + 1);
  if (over_bc != kNone) neighbours_[over_bc][side_towards(over_bc, triangle)] = second;
  if (over_ca != kNone) neighbours_[over_ca][side_towards(over_ca, triangle)] = third;
  set(triangle, {a, b, vertex}, {over_ab, second, third});
  set(second, {b, c, vertex}, {over_bc, third, triangle});
  set(third, {c, a, vertex}, {over_ca, triangle, second});
  return {Side{triangle, 0}, Side{second, 0}, Side{third, 0}};
}

}  // namespace lumesh::surfaces
