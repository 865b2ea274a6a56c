#include "lumesh/fitting/work_mesh.hpp"

#include <algorithm>

#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh::fitting {

double longest_edge_mm(const WorkMesh& mesh) {
  return parallel::max_of(mesh.tets.size(), 4096, 0.0,
                          [&](std::size_t t) { return mesh.longest_edge_mm(static_cast<std::uint32_t>(t)); });
}

std::vector<double> material_volumes_mm3(const WorkMesh& mesh, std::size_t materials) {
  return parallel::reduce(
      mesh.tets.size(), 65536, std::vector<double>(materials, 0.0),
      [&](std::vector<double>& sum, std::size_t t) {
        const Corner4& c = mesh.tets[t];
        sum[mesh.materials[t]] += tetrahedron_volume(mesh.positions[c[0]], mesh.positions[c[1]],
                                                     mesh.positions[c[2]], mesh.positions[c[3]]);
      },
      parallel::AddEach());
}

void build_stars(WorkMesh& mesh, std::span<const std::uint32_t> gone) {
  mesh.stars = parallel::group_by_owner(mesh.tets.size(), mesh.positions.size(), [&](std::size_t t) {
    const bool is_gone = std::ranges::binary_search(gone, static_cast<std::uint32_t>(t));
    return std::span(mesh.tets[t].data(), is_gone ? 0 : 4);
  });
}

namespace {

/// A face of a tetrahedron, listed at its lowest vertex.
struct ListedFace {
  std::uint64_t others;  // the two other vertices
  std::uint32_t tet, corner;
};

/// The faces of which the vertex is the lowest; both sides of one come one after the other.
void list_faces(const WorkMesh& mesh, std::uint32_t v, std::vector<ListedFace>& faces) {
  faces.clear();
  for (const std::uint32_t t : mesh.star(v)) {
    const Corner4& corners = mesh.tets[t];
    for (std::uint32_t opposite = 0; opposite < 4; ++opposite) {
      if (corners[opposite] == v) continue;
      std::uint32_t low = 0, high = 0;
      bool lowest = true;
      for (std::uint32_t c = 0; c < 4; ++c) {
        if (c == opposite || corners[c] == v) continue;
        lowest &= corners[c] > v;
        low = high;
        high = corners[c];
      }
      if (low > high) std::swap(low, high);
      if (lowest) faces.push_back({std::uint64_t{high} << 32 | low, t, opposite});
    }
  }
  std::ranges::sort(faces, [](const ListedFace& a, const ListedFace& b) { return a.others < b.others; });
}

}  // namespace

void build_neighbours(WorkMesh& mesh) {
  mesh.neighbours.resize(mesh.tets.size());
  parallel::for_each_block(mesh.positions.size(), 1024, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<ListedFace> faces;
    for (std::size_t v = begin; v < end; ++v) {
      list_faces(mesh, static_cast<std::uint32_t>(v), faces);
      for (std::size_t i = 0; i < faces.size(); ++i) {
        const ListedFace& face = faces[i];
        const bool before = i > 0 && faces[i - 1].others == face.others;
        const bool after = i + 1 < faces.size() && faces[i + 1].others == face.others;
        mesh.neighbours[face.tet][face.corner] = before  ? faces[i - 1].tet
                                                 : after ? faces[i + 1].tet
                                                         : kNoTet;
      }
    }
  });
}

std::vector<std::uint32_t> keep_tetrahedra(WorkMesh& mesh, const std::vector<std::uint8_t>& keep) {
  const auto kept_tets = parallel::collect<std::uint32_t>(mesh.tets.size(), [&](std::size_t t, auto& out) {
    if (keep[t] != 0) out.push_back(static_cast<std::uint32_t>(t));
  });
  const auto kept_vertices =
      parallel::collect<std::uint32_t>(mesh.positions.size(), [&](std::size_t v, auto& out) {
        for (const std::uint32_t t : mesh.star(static_cast<std::uint32_t>(v))) {
          if (keep[t] == 0) continue;
          out.push_back(static_cast<std::uint32_t>(v));
          return;
        }
      });
  std::vector<std::uint32_t> number(mesh.positions.size(), kNoTet);
  std::vector<std::uint32_t> tet_number(mesh.tets.size(), kNoTet);
  parallel::for_each_index(kept_tets.size(),
                           [&](std::size_t t) { tet_number[kept_tets[t]] = static_cast<std::uint32_t>(t); });
  WorkMesh small;
  small.positions.resize(kept_vertices.size());
  parallel::for_each_index(kept_vertices.size(), [&](std::size_t v) {
    number[kept_vertices[v]] = static_cast<std::uint32_t>(v);
    small.positions[v] = mesh.positions[kept_vertices[v]];
  });
  small.tets.resize(kept_tets.size());
  small.materials.resize(kept_tets.size());
  small.neighbours.resize(kept_tets.size());
  parallel::for_each_index(kept_tets.size(), [&](std::size_t t) {
    const std::uint32_t from = kept_tets[t];
    for (std::size_t c = 0; c < 4; ++c) {
      small.tets[t][c] = number[mesh.tets[from][c]];
      const std::uint32_t n = mesh.neighbours[from][c];
      small.neighbours[t][c] = n == kNoTet ? kNoTet : tet_number[n];
    }
    small.materials[t] = mesh.materials[from];
  });
  mesh = std::move(small);
  build_stars(mesh);
  return kept_vertices;
}

}  // namespace lumesh::fitting
