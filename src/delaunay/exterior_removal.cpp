#include "exterior_removal.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "lumesh/domain/patch_names.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/mesh/small_pieces.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::delaunay {
namespace {

Material material_of(const TetMesh& mesh, TetId t) {
  return static_cast<Material>(mesh.label(t));
}

/// Flag per vertex: it belongs to a piece that refinement has broken off.
std::vector<std::uint8_t> broken_off(const TetMesh& mesh, const Domain& domain) {
  const double voxel_mm = domain.resolution_mm();
  return vertices_of_small_pieces(
      mesh.vertex_slots(), kSmallPiece * voxel_mm * voxel_mm * voxel_mm,
      [&](const auto& visit) {
        for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
          if (const TetId t(i); mesh.alive(t) && domain.is_meshed(material_of(mesh, t))) visit(mesh.tet(t));
      },
      [&](std::uint32_t v) -> const Vec3& { return mesh.point(VertexId(v)); });
}

/// Drops what is not meshed, and what has been broken off. Where it was, links say which material.
void drop_outside(TetMesh& mesh, const Domain& domain) {
  const std::vector<std::uint8_t> is_broken_off = broken_off(mesh, domain);
  std::vector<std::uint8_t> kept(mesh.tet_slots(), 0);
  for_each_tet(mesh, [&](TetId t) {
    if (!domain.is_meshed(material_of(mesh, t))) return;
    if (!is_broken_off.empty() && is_broken_off[mesh.tet(t)[0]] != 0) return;
    kept[t.value] = 1;
    for (int f = 0; f < 4; ++f) {
      const Material behind = material_of(mesh, mesh.link(t, f).tet());
      if (!domain.is_meshed(behind)) mesh.set_link(t, f, FaceLink::boundary(PatchId(behind)));
    }
  });
  mesh.keep_only(kept);
}

struct BoundaryFace {
  TetId tet;  ///< Of the material that the face points out of.
  int face;
  Material outside;
};

/// Each face between materials, once.
std::vector<BoundaryFace> boundary_faces(const TetMesh& mesh) {
  return collect_from_tets<BoundaryFace>(mesh, [&](TetId t, std::vector<BoundaryFace>& out) {
    for (int f = 0; f < 4; ++f) {
      const FaceLink behind = mesh.link(t, f);
      if (behind.is_boundary())
        out.push_back({t, f, behind.patch().value});
      else if (material_of(mesh, t) < material_of(mesh, behind.tet()))
        out.push_back({t, f, material_of(mesh, behind.tet())});
    }
  });
}

/// The part of the outside behind a face of the boundary: an opening if all its corners touch one,
/// which so stays flat, else what is not cut off. The tetrahedron behind may lie in another near the rim.
Material outside_of(const TetMesh& mesh, const Domain& domain, const Cell<3>& corners, Material behind) {
  const double touch_mm = 1e-2 * domain.resolution_mm();
  std::array<MaterialSet, 3> at;
  for (std::size_t k = 0; k < 3; ++k)
    at[k] = domain.materials_near(mesh.point(VertexId(corners[k])), touch_mm);
  std::optional<Material> opening;
  for (const Material m : at[0])
    if (domain.is_cut(m) && at[1].contains(m) && at[2].contains(m) && (!opening || m == behind)) opening = m;
  return opening.value_or(domain.is_cut(behind) ? 0 : behind);
}

void set_patches(TetMesh& mesh, const Domain& domain) {
  const std::vector<BoundaryFace> faces = boundary_faces(mesh);
  std::vector<BoundaryTriangle> triangles(faces.size());
  std::vector<Cell<3>> corners(faces.size());
  bool has_interfaces = false;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const auto& [t, f, outside] = faces[i];
    corners[i] = mesh.face_corners(t, f);
    triangles[i] = {corners[i], material_of(mesh, t), outside};
    has_interfaces = has_interfaces || domain.is_meshed(outside);
  }
  if (domain.material_count() > domain.label_count())
    parallel::for_each_index(triangles.size(), [&](std::size_t i) {
      Material& outside = triangles[i].outside;
      if (!domain.is_meshed(outside)) outside = outside_of(mesh, domain, corners[i], outside);
    });
  PatchAssignment named = name_patches(triangles, mesh.points(), domain);
  mesh.info().patches = std::move(named.patches);
  mesh.info().label_names = std::move(named.label_names);
  if (has_interfaces) mesh.enable_interfaces();
  parallel::for_each_index(faces.size(), [&](std::size_t i) {
    const auto& [t, f, outside] = faces[i];
    const PatchId patch(static_cast<std::uint32_t>(named.of_triangle[i]));
    const FaceLink behind = mesh.link(t, f);
    if (behind.is_boundary()) {
      mesh.set_link(t, f, FaceLink::boundary(patch));
    } else {
      mesh.set_interface_patch(t, f, patch);
      mesh.set_interface_patch(behind.tet(), behind.face(), patch);
    }
  });
  mesh.classify_vertices({corners, named.of_triangle});
}

}  // namespace

void remove_exterior(TetMesh& mesh, const Domain& domain) {
  drop_outside(mesh, domain);
  mesh.reorder_along_curve();
  mesh.normalise();
  set_patches(mesh, domain);
  for_each_tet(mesh, [&](TetId t) { mesh.set_label(t, domain.label_of(material_of(mesh, t))); });
}

}  // namespace lumesh::delaunay
