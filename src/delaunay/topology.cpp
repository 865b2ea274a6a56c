#include "topology.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <span>
#include <utility>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/parallel/loops.hpp"
#include "places.hpp"

namespace lumesh::delaunay {
namespace {

/// The tetrahedra around a vertex in parts: of one material, or of all but it, connected through faces.
class StarParts {
 public:
  explicit StarParts(const TetMesh& mesh, const Domain& domain) : mesh_(mesh), domain_(domain) {}

  /// False if all is of one material.
  bool gather(VertexId v) {
    const auto found = star_.gather(mesh_, v);
    tets_.assign(found.begin(), found.end());
    materials_.clear();
    for (const TetId t : tets_) {
      const Material m = material_of(t);
      if (std::find(materials_.begin(), materials_.end(), m) == materials_.end()) materials_.push_back(m);
    }
    std::sort(materials_.begin(), materials_.end());
    return materials_.size() > 1;
  }
  [[nodiscard]] const std::vector<Material>& materials() const { return materials_; }

  [[nodiscard]] const std::vector<TetId>& tets() const { return tets_; }
  /// The material of most tetrahedra, of several the first.
  [[nodiscard]] Material most_frequent() const {
    const auto count = [&](Material m) {
      return std::count_if(tets_.begin(), tets_.end(), [&](TetId t) { return material_of(t) == m; });
    };
    return *std::max_element(materials_.begin(), materials_.end(),
                             [&](Material a, Material b) { return count(a) < count(b); });
  }

  enum class Side : std::uint8_t { kOf, kOther };
  /// Parts on one side of the boundary of a material, the largest first.
  [[nodiscard]] std::vector<std::vector<TetId>> parts(Material m, Side side) {
    std::vector<std::vector<TetId>> parts;
    std::vector<TetId> left;
    for (const TetId t : tets_)
      if (is_on(t, m, side)) left.push_back(t);
    while (!left.empty()) {
      std::vector<TetId> part = {left.back()};
      left.pop_back();
      for (std::size_t next = 0; next < part.size(); ++next) {
        for (int f = 0; f < 4; ++f) {
          const FaceLink behind = mesh_.link(part[next], f);
          if (behind.is_boundary()) continue;
          const auto at = std::find(left.begin(), left.end(), behind.tet());
          if (at == left.end()) continue;
          part.push_back(*at);
          *at = left.back();
          left.pop_back();
        }
      }
      parts.push_back(std::move(part));
    }
    std::sort(parts.begin(), parts.end(), [&](const auto& a, const auto& b) {
      return a.size() != b.size() ? a.size() > b.size() : is_earlier(first_of(a), first_of(b));
    });
    return parts;
  }

  [[nodiscard]] bool is_pinched(VertexId v) {
    if (!gather(v)) return false;
    return std::any_of(materials_.begin(), materials_.end(), [&](Material m) {
      return !is_connected(m, Side::kOf) || !is_connected(m, Side::kOther);
    });
  }

  /// The material behind most faces of a part, other than m.
  [[nodiscard]] Material neighbour_of(const std::vector<TetId>& part, Material m) const {
    std::map<Material, int> faces;
    for (const TetId t : part)
      for (int f = 0; f < 4; ++f)
        if (const FaceLink behind = mesh_.link(t, f); !behind.is_boundary() && material_of(behind.tet()) != m)
          ++faces[material_of(behind.tet())];
    const auto max_faces = std::max_element(faces.begin(), faces.end(),
                                            [](const auto& a, const auto& b) { return a.second < b.second; });
    return max_faces == faces.end() ? 0 : max_faces->first;
  }

 private:
  [[nodiscard]] Material material_of(TetId t) const {
    const auto m = static_cast<Material>(mesh_.label(t));
    return domain_.is_meshed(m) ? m : 0;
  }
  [[nodiscard]] bool is_on(TetId t, Material m, Side side) const {
    return (material_of(t) == m) == (side == Side::kOf);
  }
  /// The tetrahedron of a part that comes first: parts may share vertices, but no tetrahedra.
  [[nodiscard]] CornerPlaces first_of(const std::vector<TetId>& part) const {
    CornerPlaces first = corner_places(mesh_, part.front());
    for (const TetId t : part)
      if (const CornerPlaces here = corner_places(mesh_, t); is_earlier(here, first)) first = here;
    return first;
  }

  /// True if there is one part; allocates nothing.
  [[nodiscard]] bool is_connected(Material m, Side side) {
    left_.clear();
    for (const TetId t : tets_)
      if (is_on(t, m, side)) left_.push_back(t);
    std::size_t reached = 1;  // The first ones of left_.
    for (std::size_t next = 0; next < reached; ++next)
      for (int f = 0; f < 4; ++f) {
        const FaceLink behind = mesh_.link(left_[next], f);
        if (behind.is_boundary()) continue;
        const auto rest = left_.begin() + static_cast<std::ptrdiff_t>(reached);
        const auto at = std::find(rest, left_.end(), behind.tet());
        if (at == left_.end()) continue;
        std::iter_swap(rest, at);
        ++reached;
      }
    return reached >= left_.size();
  }

  const TetMesh& mesh_;
  const Domain& domain_;
  std::vector<TetId> left_;
  VertexStar star_;
  std::vector<TetId> tets_;
  std::vector<Material> materials_;
};

/// Gives tetrahedra around pinched vertices other materials, and knows the vertices whose stars that changed.
class ManifoldRepair {
 public:
  ManifoldRepair(TetMesh& mesh, const Domain& domain) : mesh_(mesh), star_(mesh, domain) {}

  [[nodiscard]] bool is_pinched(VertexId v) { return star_.is_pinched(v); }

  /// Small parts go to their neighbours.
  void repair(VertexId v) {
    if (!star_.gather(v)) return;
    for (const Material m : std::vector<Material>(star_.materials())) {
      const auto own = star_.parts(m, StarParts::Side::kOf);
      const auto others = star_.parts(m, StarParts::Side::kOther);
      for (std::size_t i = 1; i < own.size(); ++i) relabel(own[i], star_.neighbour_of(own[i], m));
      for (std::size_t i = 1; i < others.size(); ++i) relabel(others[i], m);
    }
  }
  /// The whole star gets one material: the most frequent one, or that of the outside.
  void level(VertexId v, bool takes_outside) {
    if (star_.gather(v)) relabel(star_.tets(), takes_outside ? 0 : star_.most_frequent());
  }

  /// Vertices around which something has changed since the last call, in the order of their places.
  [[nodiscard]] std::vector<VertexId> changed() {
    const auto comes_before = [&](VertexId a, VertexId b) {
      return precedes(mesh_.point(a), mesh_.point(b));
    };
    sort_unique(changed_, comes_before);
    return std::exchange(changed_, {});
  }

 private:
  void relabel(const std::vector<TetId>& part, Material m) {
    for (const TetId t : part) {
      mesh_.set_label(t, static_cast<Label>(m));
      for (const std::uint32_t v : mesh_.tet(t)) changed_.emplace_back(v);
    }
  }

  TetMesh& mesh_;
  StarParts star_;
  std::vector<VertexId> changed_;
};

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
  parallel::sort(found.begin(), found.end(),
                 [&](VertexId a, VertexId b) { return precedes(mesh.point(a), mesh.point(b)); });
  return found;
}

std::vector<VertexId> pinched_among(const TetMesh& mesh, const Domain& domain,
                                    std::span<const VertexId> suspects) {
  auto found = parallel::collect_blocks<VertexId>(
      suspects.size(), 128, [&](std::size_t begin, std::size_t end, std::vector<VertexId>& out) {
        StarParts star(mesh, domain);
        for (std::size_t i = begin; i < end; ++i)
          if (star.is_pinched(suspects[i])) out.push_back(suspects[i]);
      });
  parallel::sort(found.begin(), found.end(),
                 [&](VertexId a, VertexId b) { return precedes(mesh.point(a), mesh.point(b)); });
  return found;
}

std::size_t relabel_pinched(TetMesh& mesh, const Domain& domain, std::vector<VertexId> suspects,
                            PinchRepair way) {
  // The repair of one vertex may pinch another one; giving tetrahedra to the outside comes to an end.
  constexpr int kRepairSweeps = 8, kLevellingSweeps = 16;
  ManifoldRepair repair(mesh, domain);
  const std::size_t pinched = suspects.size();
  for (int sweep = way == PinchRepair::kToOutside ? kLevellingSweeps : 0; !suspects.empty(); ++sweep) {
    for (const VertexId v : suspects) {
      if (v.value < 4 || !repair.is_pinched(v)) continue;
      if (sweep < kRepairSweeps)
        repair.repair(v);
      else
        repair.level(v, sweep >= kLevellingSweeps);
    }
    suspects = repair.changed();
  }
  return pinched;
}

}  // namespace lumesh::delaunay
