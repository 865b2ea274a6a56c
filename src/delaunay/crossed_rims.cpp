#include "crossed_rims.hpp"

#include <algorithm>
#include <optional>
#include <vector>

#include "lumesh/parallel/loops.hpp"
#include "relabelling.hpp"

namespace lumesh::delaunay {
namespace {

/// Materials that each vertex of a boundary touches.
class TouchedMaterials {
 public:
  TouchedMaterials(const TetMesh& mesh, const Domain& domain) : mesh_(mesh) {
    const double touch_mm = 1e-2 * domain.resolution_mm();
    of_vertex_.resize(mesh.vertex_slots());
    parallel::for_each_index(of_vertex_.size(), [&](std::size_t i) {
      const VertexId v(static_cast<std::uint32_t>(i));
      if (i < 4 || !mesh.alive(v) || mesh.dimension(v) == VertexDimension::kVolume) return;
      of_vertex_[i] = domain.materials_near(mesh.point(v), touch_mm);
    });
  }
  /// Materials that all of the vertices touch.
  template <std::size_t N>
  [[nodiscard]] MaterialSet common_to(const Cell<N>& vertices) const {
    MaterialSet common;
    for (const Material m : of_vertex_[vertices[0]])
      if (std::ranges::all_of(vertices, [&](auto v) { return of_vertex_[v].contains(m); })) common.insert(m);
    return common;
  }
  [[nodiscard]] MaterialSet common_to_corners(TetId t) const { return common_to(mesh_.tet(t)); }

 private:
  const TetMesh& mesh_;
  std::vector<MaterialSet> of_vertex_;
};

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

/// Material of a tetrahedron that lies on the kept side of all cuts, though the centre of its circumsphere
/// does not; none if it stays.
std::optional<Material> material_within_cuts(const TetMesh& mesh, const Domain& domain, TetId t) {
  if (!domain.is_cut(static_cast<Material>(mesh.label(t))) || !is_within_cuts(mesh, domain, t))
    return std::nullopt;
  const Material there = domain.material_at(mesh.centroid(t));
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
  return std::ranges::all_of(common, [&](Material m) { return domain.is_meshed(m); });
}

/// Material that a tetrahedron at such a face is to have, if not its own.
std::optional<Material> material_of(const TetMesh& mesh, const Domain& domain,
                                    const TouchedMaterials& touched, TetId t) {
  bool is_at_one = false;
  for (int f = 0; f < 4; ++f) is_at_one = is_at_one || crosses(mesh, domain, touched, t, f);
  if (!is_at_one) return std::nullopt;
  const Material there = domain.material_at(mesh.centroid(t));
  const bool is_same = outside_or(domain, there) == outside_or(domain, static_cast<Material>(mesh.label(t)));
  if (is_same || !touched.common_to_corners(t).contains(there)) return std::nullopt;
  return there;
}

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

}  // namespace lumesh::delaunay
