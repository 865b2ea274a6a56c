#include "topology.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "labelled_mesh.hpp"
#include "lumesh/domain/manifold_labels.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::delaunay {
namespace {

/// A face of the boundary of a material seen from one of its corners.
struct FanFace {
  std::uint32_t vertex;
  Material material;
  std::array<std::uint32_t, 2> others;
};

Material part_of(const Domain& domain, const TetMesh& mesh, TetId t) {
  const auto m = static_cast<Material>(mesh.label(t));
  return domain.is_meshed(m) ? m : 0;
}

/// The faces around each vertex on the boundary of each material, one after another; of one label and the
/// outside one is enough.
std::vector<FanFace> boundary_fans(const TetMesh& mesh, const Domain& domain) {
  const bool has_labels = domain.label_count() > 2;
  auto fans = collect_from_tets<FanFace>(mesh, [&](TetId t, std::vector<FanFace>& out) {
    const Material mine = part_of(domain, mesh, t);
    if (mine == 0) return;
    for (int f = 0; f < 4; ++f) {
      const FaceLink behind = mesh.link(t, f);
      if (behind.is_boundary() || part_of(domain, mesh, behind.tet()) == mine) continue;
      const Cell<3> v = mesh.face_corners(t, f);
      const bool ends_object = has_labels && part_of(domain, mesh, behind.tet()) == 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t next = v[(c + 1) % 3], last = v[(c + 2) % 3];
        out.push_back({v[c], mine, {next, last}});
        if (ends_object) out.push_back({v[c], 0, {last, next}});
      }
    }
  });
  parallel::sort(fans.begin(), fans.end(), [](const FanFace& a, const FanFace& b) {
    return a.vertex != b.vertex ? a.vertex < b.vertex : a.material < b.material;
  });
  return fans;
}

/// True if the faces follow one another around their vertex and come back to the first: where they do, the
/// material and all the rest are each connected around the vertex.
bool is_one_fan(std::span<const FanFace> faces) {
  // Each edge from the vertex is entered by one face and left by one.
  const std::uint32_t first = faces.front().others[0];
  std::uint32_t at = first;
  for (std::size_t passed = 1;; ++passed) {
    const auto leaves = [&](const FanFace& f) { return f.others[0] == at; };
    const auto next = std::find_if(faces.begin(), faces.end(), leaves);
    if (next == faces.end() || std::any_of(next + 1, faces.end(), leaves)) return false;
    at = next->others[1];
    if (at == first || passed == faces.size()) return at == first && passed == faces.size();
  }
}

void sort_by_place(const TetMesh& mesh, std::vector<VertexId>& vertices) {
  parallel::sort(vertices.begin(), vertices.end(),
                 [&](VertexId a, VertexId b) { return precedes(mesh.point(a), mesh.point(b)); });
}

}  // namespace

std::vector<VertexId> pinched_vertices(const TetMesh& mesh, const Domain& domain) {
  std::vector<FanFace> fans = boundary_fans(mesh, domain);
  const auto is_new = [&](std::size_t i) {
    return i == 0 || fans[i].vertex != fans[i - 1].vertex || fans[i].material != fans[i - 1].material;
  };
  const auto starts =
      parallel::collect<std::size_t>(fans.size(), [&](std::size_t i, std::vector<std::size_t>& out) {
        if (is_new(i)) out.push_back(i);
      });
  auto found = parallel::collect<VertexId>(starts.size(), [&](std::size_t i, std::vector<VertexId>& out) {
    const std::size_t begin = starts[i], end = i + 1 < starts.size() ? starts[i + 1] : fans.size();
    if (!is_one_fan(std::span<const FanFace>(fans).subspan(begin, end - begin)))
      out.emplace_back(fans[begin].vertex);
  });
  found.erase(std::unique(found.begin(), found.end()), found.end());
  sort_by_place(mesh, found);
  return found;
}

std::vector<VertexId> pinched_among(const TetMesh& mesh, const Domain& domain,
                                    std::span<const VertexId> suspects) {
  const auto found = non_manifold_among(LabelledMesh(mesh, domain), suspects.size(),
                                        [&](std::size_t i) { return suspects[i].value; });
  std::vector<VertexId> pinched;
  for (const std::uint32_t v : found) pinched.emplace_back(v);
  sort_by_place(mesh, pinched);
  return pinched;
}

std::size_t relabel_pinched(TetMesh& mesh, const Domain& domain, const std::vector<VertexId>& suspects,
                            PinchRepair way) {
  RelabelledMesh tets(mesh, domain);
  ManifoldRepair repair(tets);
  std::vector<std::uint32_t> bad;
  for (const VertexId v : suspects) bad.push_back(v.value);
  repair.run(std::move(bad), way == PinchRepair::kToOutside ? repair.kClear : repair.kFit,
             [] { return std::span<const std::uint32_t>(); });
  return suspects.size();
}

}  // namespace lumesh::delaunay
