#include "crossed_rims.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/parallel/loops.hpp"
#include "relabelling.hpp"

namespace lumesh::delaunay {
namespace {

/// Flag per vertex: corner of a tetrahedron that has one in a cut plane.
std::vector<std::uint8_t> vertices_at_cuts(const TetMesh& mesh, const Domain& domain) {
  const double touch_mm = 1e-2 * domain.resolution_mm();
  std::vector<std::uint8_t> is_on(mesh.vertex_slots(), 0), is_at(mesh.vertex_slots(), 0);
  parallel::for_each_index(is_on.size(), [&](std::size_t i) {
    const VertexId v(static_cast<std::uint32_t>(i));
    if (i < 4 || !mesh.alive(v) || mesh.dimension(v) == VertexDimension::kVolume) return;
    for (const CutPlane& cut : domain.cut_planes())
      if (std::abs(cut.height(mesh.point(v))) <= touch_mm) is_on[i] = 1;
  });
  parallel::for_each_index(mesh.tet_slots(), [&](std::size_t i) {
    const TetId t(static_cast<std::uint32_t>(i));
    if (!mesh.alive(t)) return;
    const Cell<4>& corners = mesh.tet(t);
    if (std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) { return is_on[v] != 0; }))
      for (const std::uint32_t v : corners) parallel::raise(is_at[v]);
  });
  return is_at;
}

/// What each vertex of a boundary touches.
class TouchedMaterials {
 public:
  /// @param is_wanted  Flag per vertex; the others touch nothing. Empty: all are.
  TouchedMaterials(const TetMesh& mesh, const Domain& domain, const std::vector<std::uint8_t>& is_wanted = {})
      : mesh_(mesh) {
    const double touch_mm = 1e-2 * domain.resolution_mm();
    of_vertex_.resize(mesh.vertex_slots());
    parallel::for_each_index(of_vertex_.size(), [&](std::size_t i) {
      const VertexId v(static_cast<std::uint32_t>(i));
      if (!is_wanted.empty() && is_wanted[i] == 0) return;
      if (i < 4 || !mesh.alive(v) || mesh.dimension(v) == VertexDimension::kVolume) return;
      of_vertex_[i] = domain.materials_near(mesh.point(v), touch_mm);
    });
  }
  /// Those that all of the vertices touch.
  template <std::size_t N>
  [[nodiscard]] MaterialSet common_to(const Cell<N>& vertices) const {
    MaterialSet common;
    for (const Material m : of_vertex_[vertices[0]])
      if (std::all_of(vertices.begin(), vertices.end(), [&](auto v) { return of_vertex_[v].contains(m); }))
        common.insert(m);
    return common;
  }
  [[nodiscard]] const MaterialSet& of(std::uint32_t vertex) const { return of_vertex_[vertex]; }
  [[nodiscard]] MaterialSet common_to_corners(TetId t) const { return common_to(mesh_.tet(t)); }

 private:
  const TetMesh& mesh_;
  std::vector<MaterialSet> of_vertex_;
};

Vec3 centre_of(const TetMesh& mesh, TetId t) {
  return 0.25 * (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2) + mesh.corner(t, 3));
}

/// True if a tetrahedron has no corner beyond a cut plane, and does not lie flat on one.
bool is_within_cuts(const TetMesh& mesh, const Domain& domain, TetId t) {
  const double touch_mm = 1e-2 * domain.resolution_mm();
  for (const CutPlane& cut : domain.cut_planes()) {
    int on_it = 0;
    for (int k = 0; k < 4; ++k) {
      const double beyond_mm = cut.beyond_mm(mesh.corner(t, k));
      if (beyond_mm > touch_mm || mesh.vertex(t, k).value < 4) return false;
      on_it += beyond_mm >= -touch_mm ? 1 : 0;
    }
    if (on_it == 4) return false;
  }
  return true;
}

/// What a tetrahedron is to be that lies on the kept side of all cuts, though the centre of its circumsphere
/// does not; none if it stays.
std::optional<Material> material_within_cuts(const TetMesh& mesh, const Domain& domain, TetId t) {
  if (!domain.is_cut(static_cast<Material>(mesh.label(t))) || !is_within_cuts(mesh, domain, t))
    return std::nullopt;
  const Material there = domain.material_at(centre_of(mesh, t));
  if (!domain.is_meshed(there)) return std::nullopt;
  return there;
}

Material outside_or(const Domain& domain, Material m) {
  return domain.is_meshed(m) ? m : 0;
}

bool is_outside(const TetMesh& mesh, const Domain& domain, TetId t) {
  return !domain.is_meshed(static_cast<Material>(mesh.label(t)));
}

/// True if a face of a tetrahedron lies between the object and the outside, and on no boundary of it.
bool crosses(const TetMesh& mesh, const Domain& domain, const TouchedMaterials& touched, TetId t, int face) {
  const FaceLink behind = mesh.link(t, face);
  if (behind.is_boundary() || is_outside(mesh, domain, t) == is_outside(mesh, domain, behind.tet()))
    return false;
  const MaterialSet common = touched.common_to(mesh.face_corners(t, face));
  return std::all_of(common.begin(), common.end(), [&](Material m) { return domain.is_meshed(m); });
}

/// What a tetrahedron at such a face is to be, if not what it is.
std::optional<Material> material_of(const TetMesh& mesh, const Domain& domain,
                                    const TouchedMaterials& touched, TetId t) {
  bool is_at_one = false;
  for (int f = 0; f < 4; ++f) is_at_one = is_at_one || crosses(mesh, domain, touched, t, f);
  if (!is_at_one) return std::nullopt;
  const Material there = domain.material_at(centre_of(mesh, t));
  const bool is_same = outside_or(domain, there) == outside_or(domain, static_cast<Material>(mesh.label(t)));
  if (is_same || !touched.common_to_corners(t).contains(there)) return std::nullopt;
  return there;
}

/// What tetrahedra are to be whose face lies in a cut plane: what the plane's section is there.
class OpeningFaces {
 public:
  OpeningFaces(const TetMesh& mesh, const Domain& domain, const TouchedMaterials& touched)
      : mesh_(mesh), domain_(domain), touched_(touched) {}

  /// The same for what is not meshed and has a corner in a cut plane, but not all of them: the material at
  /// its own centre.
  [[nodiscard]] std::optional<Material> material_near_cut(TetId t) const {
    if (domain_.is_meshed(static_cast<Material>(mesh_.label(t))) || !has_corner_on_cut(t) ||
        !is_within_cuts(mesh_, domain_, t))
      return std::nullopt;
    const Material there = domain_.material_at(centre_of(mesh_, t));
    if (!domain_.is_meshed(there) || !all_touch(t, there)) return std::nullopt;
    return there;
  }
  /// None if the tetrahedron stays.
  [[nodiscard]] std::optional<Material> material_of(TetId t) const {
    for (int f = 0; f < 4; ++f)
      for (const Material cut : touched_.common_to(mesh_.face_corners(t, f))) {
        if (!domain_.is_cut(cut)) continue;
        const CutPlane& plane = domain_.cut_plane(cut);
        if (plane.height(mesh_.corner(t, f)) > -1e-2 * domain_.resolution_mm()) continue;
        const Material there = material_below(plane, mesh_.face_corners(t, f));
        const auto mine = static_cast<Material>(mesh_.label(t));
        if (there == outside_or(domain_, mine) || !all_touch(t, there)) return std::nullopt;
        return there;
      }
    return std::nullopt;
  }

 private:
  [[nodiscard]] bool has_corner_on_cut(TetId t) const {
    const Cell<4>& corners = mesh_.tet(t);
    return std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) {
      const MaterialSet& there = touched_.of(v);
      return std::any_of(there.begin(), there.end(), [&](Material m) { return domain_.is_cut(m); });
    });
  }
  /// What meets the plane in the middle of a face; 0 where nothing is that is meshed.
  [[nodiscard]] Material material_below(const CutPlane& cut, const Cell<3>& corners) const {
    Vec3 middle = Vec3::Zero();
    for (const std::uint32_t v : corners) middle += mesh_.point(VertexId(v)) / 3;
    middle -= (cut.height(middle) + 1e-3 * domain_.resolution_mm()) * cut.normal;
    return outside_or(domain_, domain_.material_at(middle));
  }
  [[nodiscard]] bool all_touch(TetId t, Material m) const {
    const Cell<4>& corners = mesh_.tet(t);
    return std::all_of(corners.begin(), corners.end(), [&](std::uint32_t v) {
      if (v < 4) return false;
      if (mesh_.dimension(VertexId(v)) == VertexDimension::kVolume)
        return domain_.material_at(mesh_.point(VertexId(v))) == m;
      return touched_.of(v).contains(m);
    });
  }

  const TetMesh& mesh_;
  const Domain& domain_;
  const TouchedMaterials& touched_;
};

/// Sweeps until nothing takes another material.
template <class MaterialOf>
std::size_t relabel_in_sweeps(TetMesh& mesh, const Domain& domain, const MaterialOf& material_of) {
  constexpr int kSweeps = 4;  // What is filled may have one more behind it.
  std::size_t count = 0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    const std::size_t more = relabel_unless_pinching(mesh, domain, material_of);
    count += more;
    if (more == 0) break;
  }
  return count;
}

/// Tetrahedra with a material to take, in the order of their places, by groups that hang together over faces.
struct Takers {
  std::vector<TetId> tets;
  std::vector<Material> wanted;
  std::vector<std::vector<std::size_t>> groups;
};

Takers takers_of(const TetMesh& mesh, const OpeningFaces& faces) {
  Takers takers;
  takers.tets = parallel::collect<TetId>(mesh.tet_slots(), [&](std::size_t i, std::vector<TetId>& out) {
    const TetId t(static_cast<std::uint32_t>(i));
    if (mesh.alive(t) && faces.material_near_cut(t)) out.push_back(t);
  });
  std::sort(takers.tets.begin(), takers.tets.end(),
            [&](TetId a, TetId b) { return is_earlier(corner_places(mesh, a), corner_places(mesh, b)); });
  std::unordered_map<std::uint32_t, std::uint32_t> number;
  for (const TetId t : takers.tets) {
    number.emplace(t.value, static_cast<std::uint32_t>(takers.wanted.size()));
    takers.wanted.push_back(*faces.material_near_cut(t));
  }
  DisjointSets sets(takers.tets.size());
  for (std::uint32_t i = 0; i < takers.tets.size(); ++i)
    for (int f = 0; f < 4; ++f) {
      const FaceLink behind = mesh.link(takers.tets[i], f);
      const auto other = behind.is_boundary() ? number.end() : number.find(behind.tet().value);
      if (other != number.end() && takers.wanted[other->second] == takers.wanted[i])
        sets.merge(i, other->second);
    }
  std::map<std::uint32_t, std::size_t> group_of;
  for (std::uint32_t i = 0; i < takers.tets.size(); ++i) {
    const auto [at, is_new] = group_of.try_emplace(sets.find(i), takers.groups.size());
    if (is_new) takers.groups.emplace_back();
    takers.groups[at->second].push_back(i);
  }
  return takers;
}

/// What may not take its material one by one, for each would touch the rest in a point or an edge only, such
/// as all that is around a point of a wall near the plane: a group takes it together, if part of the opening
/// is in it.
std::size_t relabel_in_groups(TetMesh& mesh, const Domain& domain, const OpeningFaces& faces) {
  const Takers takers = takers_of(mesh, faces);
  std::size_t count = 0;
  for (const std::vector<std::size_t>& group : takers.groups) {
    if (std::none_of(group.begin(), group.end(),
                     [&](std::size_t i) { return faces.material_of(takers.tets[i]).has_value(); }))
      continue;
    std::vector<Label> before;
    std::vector<VertexId> around;
    for (const std::size_t i : group) {
      const TetId t = takers.tets[i];
      before.push_back(mesh.label(t));
      for (const std::uint32_t v : mesh.tet(t)) around.emplace_back(v);
      mesh.set_label(t, static_cast<Label>(takers.wanted[i]));
    }
    sort_unique(around);
    if (pinched_among(mesh, domain, around).empty()) {
      count += group.size();
      continue;
    }
    for (std::size_t g = 0; g < group.size(); ++g) mesh.set_label(takers.tets[group[g]], before[g]);
  }
  return count;
}

}  // namespace

std::size_t relabel_at_cuts(TetMesh& mesh, const Domain& domain) {
  if (domain.cut_planes().empty()) return 0;
  return relabel_in_sweeps(mesh, domain, [&](TetId t) { return material_within_cuts(mesh, domain, t); });
}

std::size_t relabel_crossed_rims(TetMesh& mesh, const Domain& domain) {
  if (domain.material_count() == domain.label_count()) return 0;
  const TouchedMaterials touched(mesh, domain);
  return relabel_in_sweeps(mesh, domain, [&](TetId t) { return material_of(mesh, domain, touched, t); });
}

std::size_t relabel_at_openings(TetMesh& mesh, const Domain& domain) {
  if (domain.cut_planes().empty()) return 0;
  const TouchedMaterials touched(mesh, domain, vertices_at_cuts(mesh, domain));
  const OpeningFaces faces(mesh, domain, touched);
  const std::size_t count = relabel_in_sweeps(mesh, domain, [&](TetId t) { return faces.material_of(t); });
  return count + relabel_in_groups(mesh, domain, faces);
}

}  // namespace lumesh::delaunay
