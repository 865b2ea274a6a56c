#include <algorithm>
#include <cstddef>

#include "cavity.hpp"
#include "surface_rules.hpp"

namespace lumesh::operators {
namespace {

/// True if the edges, directed, are one closed cycle through each of their vertices once.
template <class Edge>
bool is_one_cycle(const std::vector<Edge>& edges) {
  if (edges.empty()) return false;
  std::size_t steps = 0;
  std::uint32_t at = edges[0].b;
  for (; at != edges[0].a && steps < edges.size(); ++steps) {
    const auto leaves = [&](const Edge& edge) { return edge.a == at; };
    const auto next = std::ranges::find_if(edges, leaves);
    if (next == edges.end() || std::count_if(next, edges.end(), leaves) != 1) return false;
    at = next->b;
  }
  return steps + 1 == edges.size();
}

}  // namespace

bool Cavity::absorbs_disc(const NewVertex& vertex) {
  rim_.clear();
  std::size_t faces = 0;
  for (const HullFace& face : hull_) {
    if (!face.absorbed) continue;
    ++faces;
    for (int k = 0; k < 3; ++k) {
      const PatchEdge edge = {face.corners[(k + 1) % 3], face.corners[k], face.patch};
      const auto twin = std::ranges::find_if(
          rim_, [&](const PatchEdge& other) { return other.a == edge.b && other.b == edge.a; });
      if (twin == rim_.end()) {
        rim_.push_back(edge);
        continue;
      }
      const bool is_split =
          std::minmax(edge.a, edge.b) == std::minmax(vertex.edge_a.value, vertex.edge_b.value);
      if (twin->patch != edge.patch && !is_split) return false;
      rim_.erase(twin);
    }
  }
  // A triangulated disc without inner vertices has two triangles less than edges on its rim; with one cycle,
  // more triangles mean inner vertices or handles.
  return faces + 2 == rim_.size() && is_one_cycle(rim_);
}

bool Cavity::keeps_to_surface(const TetMesh& mesh, const NewVertex& vertex, const PatchShapes& shapes) const {
  const auto is_curved = [&](PatchId patch) { return shapes[patch.value].freedom == PatchFreedom::kCurved; };
  SurfaceDeviation after, before;
  for (const PatchEdge& edge : rim_) {
    if (!is_curved(edge.patch)) continue;
    const Surface& surface = *shapes[edge.patch.value].surface;
    const auto corner = [&](std::uint32_t v) {
      return surface_corner(surface, mesh.point(VertexId(v)), mesh.metric(VertexId(v)));
    };
    after.add(corner(edge.a), corner(edge.b), surface_corner(surface, vertex.point, vertex.metric.metric));
  }
  if (after.is_small()) return true;
  for (const HullFace& face : hull_)
    if (face.absorbed && is_curved(face.patch))
      before.add(*shapes[face.patch.value].surface, mesh,
                 {face.corners[0], face.corners[2], face.corners[1]});
  return after.may_follow(before);
}

}  // namespace lumesh::operators
