#include "layer_surface.hpp"

#include <algorithm>
#include <map>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/edge_key.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::layers {

Lists lists_of(std::vector<std::uint64_t> pairs, std::size_t items) {
  parallel::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  Lists lists;
  lists.starts.assign(items + 1, 0);
  for (const std::uint64_t pair : pairs) {
    ++lists.starts[(pair >> 32) + 1];
    lists.items.push_back(static_cast<std::uint32_t>(pair));
  }
  for (std::size_t i = 0; i < items; ++i) lists.starts[i + 1] += lists.starts[i];
  return lists;
}

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
  std::vector<std::uint64_t> of_triangles, of_vertices;
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = surface.triangles[t][k], b = surface.triangles[t][(k + 1) % 3];
      of_triangles.push_back(a << 32 | t);
      of_vertices.push_back(a << 32 | b);
      of_vertices.push_back(b << 32 | a);
    }
  surface.triangles_around = lists_of(std::move(of_triangles), surface.points.size());
  surface.neighbours = lists_of(std::move(of_vertices), surface.points.size());
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

/// Normals of the patches that are flat, to rounding; zero for others.
std::vector<Vec3> plane_normals(const TetMesh& mesh, const BoundaryFaces& faces) {
  constexpr double kFlat = 1e-9;
  const std::size_t patches = mesh.info().patches.size();
  std::vector<Vec3> normals(patches, Vec3::Zero()), corners(patches, Vec3::Zero());
  std::vector<double> off(patches, 0), size(patches, 0);
  const auto point = [&](std::size_t f, std::size_t k) {
    return mesh.point(VertexId(faces.triangles[f][k]));
  };
  for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
    const auto patch = static_cast<std::size_t>(faces.patches[f]);
    normals[patch] += triangle_area_normal(point(f, 0), point(f, 1), point(f, 2));
    corners[patch] = point(f, 0);
  }
  for (Vec3& normal : normals) normal.normalize();
  for (std::size_t f = 0; f < faces.triangles.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto patch = static_cast<std::size_t>(faces.patches[f]);
      const Vec3 from = point(f, k) - corners[patch];
      off[patch] = std::max(off[patch], std::abs(from.dot(normals[patch])));
      size[patch] = std::max(size[patch], from.norm());
    }
  for (std::size_t p = 0; p < patches; ++p)
    if (!(off[p] <= kFlat * size[p])) normals[p] = Vec3::Zero();
  return normals;
}

}  // namespace

Vec3 RimPlanes::project(const Vec3& x) const {
  if (count > 2) return Vec3::Zero();
  Vec3 in = x;
  for (int i = 0; i < count; ++i)
    in -= normals[static_cast<std::size_t>(i)].dot(x) * normals[static_cast<std::size_t>(i)];
  return in;
}

void RimPlanes::add(const Vec3& normal) {
  constexpr double kSame = 1e-6;
  if (count > 2) return;
  const Vec3 rest = project(normal);
  if (rest.norm() < kSame) return;
  if (count < 2) normals[static_cast<std::size_t>(count)] = rest.normalized();
  ++count;
}

LayerSurface surface_of(const TetMesh& mesh, const BoundaryFaces& faces,
                        const std::vector<std::uint8_t>& layered, bool is_inward) {
  LayerSurface surface;
  take_triangles(mesh, faces, layered, surface);
  if (is_inward)
    for (Cell<3>& t : surface.triangles) std::swap(t[1], t[2]);
  find_neighbours(surface);
  find_rim(faces, layered, surface);
  surface.planes.resize(surface.points.size());
  const std::vector<Vec3> normals = plane_normals(mesh, faces);
  for (const RimEdge& edge : surface.rim) {
    const bool is_flat = edge.patch >= 0 && normals[static_cast<std::size_t>(edge.patch)] != Vec3::Zero();
    for (const std::uint32_t v : {edge.a, edge.b}) {
      if (is_flat)
        surface.planes[v].add(normals[static_cast<std::size_t>(edge.patch)]);
      else if (is_inward)
        surface.planes[v].forbid();  // What bends there would be cut off.
    }
  }
  return surface;
}

}  // namespace lumesh::layers
