#include "layer_surface.hpp"

#include <algorithm>
#include <map>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/edge_key.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::layers {

namespace {

/// Takes the triangles of layered patches, with vertices numbered anew, and the others of the outside.
void take_triangles(const TetMesh& mesh, const BoundaryFaces& faces, const std::vector<std::uint8_t>& layered,
                    LayerSurface& surface) {
  constexpr std::uint32_t kNot = ~0u;
  std::vector<std::uint32_t> place(mesh.vertex_count(), kNot);
  const auto has_layers = [&](std::size_t f) {
    return layered[static_cast<std::size_t>(faces.patches[f])] != 0;
  };
  for (std::size_t f = 0; f < faces.triangles.size(); ++f)
    if (has_layers(f))
      for (const std::uint32_t v : faces.triangles[f]) place[v] = 0;
  for (std::uint32_t v = 0; v < place.size(); ++v)
    if (place[v] != kNot) {
      place[v] = static_cast<std::uint32_t>(surface.vertices.size());
      surface.vertices.push_back(v);
      surface.points.push_back(mesh.point(VertexId(v)));
    }
  for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
    const Cell<3>& t = faces.triangles[f];
    if (has_layers(f)) {
      surface.triangles.push_back({place[t[0]], place[t[1]], place[t[2]]});
      surface.patches.push_back(faces.patches[f]);
    } else if (!faces.tets[f][1].valid()) {
      surface.others.push_back(t);
    }
  }
}

void find_neighbours(LayerSurface& surface) {
  std::vector<std::uint64_t> pairs;
  for (const Cell<3>& t : surface.triangles)
    for (std::size_t k = 0; k < 3; ++k) parallel::add_both_ways(t[k], t[(k + 1) % 3], pairs);
  surface.triangles_around = parallel::cells_around(surface.triangles, surface.points.size());
  surface.neighbours = parallel::adjacency_of(pairs, surface.points.size());
}

/// Edges of one triangle only, with the patch of the other face of the outside there.
void find_rim(const BoundaryFaces& faces, const std::vector<std::uint8_t>& layered, LayerSurface& surface) {
  std::vector<std::uint64_t> edges;
  for (const Cell<3>& t : surface.triangles)
    for (std::size_t k = 0; k < 3; ++k) edges.push_back(edge_key(t[k], t[(k + 1) % 3]));
  parallel::sort(edges.begin(), edges.end());
  const auto is_single = [&](std::uint64_t edge) {
    const auto [first, last] = std::equal_range(edges.begin(), edges.end(), edge);
    return last - first == 1;
  };
  for (const Cell<3>& t : surface.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      if (is_single(edge_key(t[k], t[(k + 1) % 3]))) surface.rim.push_back({t[k], t[(k + 1) % 3], -1});
  if (surface.rim.empty()) return;
  std::map<std::uint64_t, std::int32_t> patch_at;
  for (const RimEdge& edge : surface.rim)
    patch_at[edge_key(surface.vertices[edge.a], surface.vertices[edge.b])] = -1;
  for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
    if (layered[static_cast<std::size_t>(faces.patches[f])] != 0 || faces.tets[f][1].valid()) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto found = patch_at.find(edge_key(faces.triangles[f][k], faces.triangles[f][(k + 1) % 3]));
      if (found != patch_at.end()) found->second = faces.patches[f];
    }
  }
  for (RimEdge& edge : surface.rim)
    edge.patch = patch_at[edge_key(surface.vertices[edge.a], surface.vertices[edge.b])];
}

/// Planes of patches that are flat, and of those that nearly are, such as openings a little crooked at their
/// rim. The rest is frozen, and so is what layers grow on.
operators::PatchShapes shapes_around(const TetMesh& mesh, const BoundaryFaces& faces,
                                     const PatchSelection& selection) {
  constexpr double kFlat = 0.02;  // Of the patch's size.
  operators::PatchShapes shapes = operators::planes_where_flat(mesh);
  const std::size_t patches = shapes.size();
  std::vector<AreaSum> sums(patches);
  std::vector<Vec3> normals(patches), middles(patches);
  std::vector<double> off(patches, 0), size(patches, 0);
  const auto patch_of = [&](std::size_t f) { return static_cast<std::size_t>(faces.patches[f]); };
  const auto point = [&](std::size_t f, std::size_t k) {
    return mesh.point(VertexId(faces.triangles[f][k]));
  };
  for (std::size_t f = 0; f < faces.triangles.size(); ++f)
    sums[patch_of(f)].add(point(f, 0), point(f, 1), point(f, 2));
  for (std::size_t p = 0; p < patches; ++p)
    normals[p] = sums[p].normal.normalized(), middles[p] = sums[p].centre();
  for (std::size_t f = 0; f < faces.triangles.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t p = patch_of(f);
      const Vec3 from = point(f, k) - middles[p];
      off[p] = std::max(off[p], std::abs(from.dot(normals[p])));
      size[p] = std::max(size[p], from.norm());
    }
  for (std::size_t p = 0; p < patches; ++p) {
    if (selection.layered[p] != 0 || selection.between[p] != 0)
      shapes[p] = {};
    else if (shapes[p].freedom == operators::PatchFreedom::kFrozen && off[p] <= kFlat * size[p])
      shapes[p] = {operators::PatchFreedom::kPlane, normals[p], normals[p].dot(middles[p])};
  }
  return shapes;
}

}  // namespace

Vec3 RimPlanes::project(const Vec3& x) const {
  if (forbids()) return Vec3::Zero();
  Vec3 in = x;
  for (int i = 0; i < count; ++i)
    in -= normals[static_cast<std::size_t>(i)].dot(x) * normals[static_cast<std::size_t>(i)];
  return in;
}

void RimPlanes::add(const Vec3& normal) {
  constexpr double kSame = 1e-6;
  if (forbids()) return;
  const Vec3 rest = project(normal);
  if (rest.norm() < kSame) return;
  if (count < 2) normals[static_cast<std::size_t>(count)] = rest.normalized();
  ++count;
}

LayerSurface surface_of(const TetMesh& mesh, const BoundaryFaces& faces, const PatchSelection& selection,
                        bool is_inward) {
  LayerSurface surface;
  take_triangles(mesh, faces, selection.layered, surface);
  if (is_inward)
    for (Cell<3>& t : surface.triangles) std::swap(t[1], t[2]);
  find_neighbours(surface);
  find_rim(faces, selection.layered, surface);
  surface.planes.resize(surface.points.size());
  surface.shapes = shapes_around(mesh, faces, selection);
  for (const RimEdge& edge : surface.rim) {
    const operators::PatchShape shape =
        edge.patch >= 0 ? surface.shapes[static_cast<std::size_t>(edge.patch)] : operators::PatchShape{};
    for (const std::uint32_t v : {edge.a, edge.b}) {
      if (shape.freedom == operators::PatchFreedom::kPlane)
        surface.planes[v].add(shape.normal);
      else if (is_inward)
        surface.planes[v].forbid();  // What bends there would be cut off.
    }
  }
  return surface;
}

}  // namespace lumesh::layers
