#include "bcc.hpp"

#include <bit>

namespace lumesh::bcc {

namespace {

constexpr unsigned kFaceMasks[4] = {0b111000, 0b100110, 0b010101, 0b001011};

Key edge_midpoint(const Corners& t, std::size_t e) {
  return midpoint(t[kTetEdges[e][0]], t[kTetEdges[e][1]]);
}

/// Replaces one corner, which keeps the orientation while the new one lies on an edge of the old.
Corners with(Corners t, std::size_t corner, Key key) {
  t[corner] = key;
  return t;
}

}  // namespace

Closure closure_of(unsigned split_edges) {
  const int count = std::popcount(split_edges);
  if (count == 0) return Closure::kWhole;
  if (count == 1) return Closure::kGreen;
  if (count == 2) {
    const bool opposite = split_edges == 0b100001 || split_edges == 0b010010 || split_edges == 0b001100;
    return opposite ? Closure::kGreen : Closure::kSplitThird;
  }
  for (const unsigned face : kFaceMasks) {
    if (split_edges == face) return Closure::kGreen;
  }
  return Closure::kRed;
}

std::size_t third_edge(unsigned split_edges) {
  for (const unsigned face : kFaceMasks) {
    if ((split_edges & face) == split_edges)
      return static_cast<std::size_t>(std::countr_zero(face & ~split_edges));
  }
  return 6;
}

std::array<Corners, 8> red_children(const Corners& t) {
  const Key m01 = edge_midpoint(t, 0), m02 = edge_midpoint(t, 1), m03 = edge_midpoint(t, 2);
  const Key m12 = edge_midpoint(t, 3), m13 = edge_midpoint(t, 4), m23 = edge_midpoint(t, 5);
  return {{{t[0], m01, m02, m03},
           {m01, t[1], m12, m13},
           {m02, m12, t[2], m23},
           {m03, m13, m23, t[3]},
           {m01, m23, m12, m02},
           {m01, m23, m13, m12},
           {m01, m23, m03, m13},
           {m01, m23, m02, m03}}};
}

GreenChildren green_children(const Corners& t, unsigned split_edges) {
  GreenChildren out;
  const auto add = [&](const Corners& c) { out.items[out.count++] = c; };
  const int count = std::popcount(split_edges);
  if (count <= 2) {
    const auto e = static_cast<std::size_t>(std::countr_zero(split_edges));
    const Key m = edge_midpoint(t, e);
    for (const int corner : kTetEdges[e]) {
      const Corners half = with(t, corner, m);
      if (count == 1) {
        add(half);
        continue;
      }
      const Key n = edge_midpoint(t, 5 - e);
      for (const int other : kTetEdges[5 - e]) add(with(half, other, n));
    }
    return out;
  }
  int apex = 0;
  while (kFaceMasks[apex] != split_edges) ++apex;
  Corners middle = t;  // corner i of the face becomes the midpoint of the edge opposite to it
  for (int corner = 0; corner < 4; ++corner) {
    if (corner == apex) continue;
    Corners child = t;
    for (const std::size_t e : kFaceEdges[apex]) {
      const auto [a, b] = kTetEdges[e];
      if (a == corner) child[b] = edge_midpoint(t, e);
      if (b == corner) child[a] = edge_midpoint(t, e);
      if (a != corner && b != corner) middle[corner] = edge_midpoint(t, e);
    }
    add(child);
  }
  add(middle);
  return out;
}

}  // namespace lumesh::bcc
