#include "lumesh/stages/mesh_cut.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "lumesh/core/angles.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/cut_off_cells.hpp"
#include "lumesh/mesh/edge_loops.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/mesh/patch_naming.hpp"
#include "lumesh/mesh/patches_in_use.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/input_parts.hpp"

namespace lumesh {
namespace {

/// A new opening that has no name yet.
struct Piece {
  Label label = kBackground;
  std::vector<Cell<3>> faces;
  std::set<std::uint64_t> rim;  // Edges with one face.
};

/// Names of openings that a cut has made.
class NewNames {
 public:
  NewNames(MixedMesh& mesh, std::int32_t first) : mesh_(mesh), naming_(mesh.info.label_names) {
    std::vector<Patch>& patches = mesh.info.patches;
    pieces_.resize(patches.size() - static_cast<std::size_t>(first));
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      if (const std::int32_t p = mesh.triangle_patches[t]; p >= first)
        pieces_[static_cast<std::size_t>(p - first)].faces.push_back(mesh.triangles[t]);
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      pieces_[i].label = patches[static_cast<std::size_t>(first) + i].labels[0];
      for (const Cell<3>& face : pieces_[i].faces) toggle_edges(face, pieces_[i].rim);
    }
    give(first);
  }

 private:
  /// A ring that has edges in common with what another label has within it.
  [[nodiscard]] bool is_rim(const Piece& piece) const {
    return loop_count(piece.rim) > 1 && std::ranges::any_of(pieces_, [&](const Piece& other) {
             return other.label != piece.label && std::ranges::any_of(other.rim, [&](std::uint64_t edge) {
                      return piece.rim.contains(edge);
                    });
           });
  }

  void give(std::int32_t first) {
    std::set<Label> labels, of_rims;
    for (const Piece& piece : pieces_) (is_rim(piece) ? of_rims : labels).insert(piece.label);
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      const bool rim = is_rim(pieces_[i]);
      const bool are_several = (rim ? of_rims : labels).size() > 1;
      const std::string ending = are_several ? "_" + naming_.label(pieces_[i].label) : "";
      mesh_.info.patches[static_cast<std::size_t>(first) + i].name = free_name(rim, ending);
    }
  }
  [[nodiscard]] std::string free_name(bool is_rim, const std::string& ending) const {
    for (std::size_t number = 0;; ++number) {
      std::string name = is_rim ? wall_rim_name(number) : opening_name(number);
      name += ending;
      if (!has_patch_called(mesh_.info.patches, name)) return name;
    }
  }

  MixedMesh& mesh_;
  PatchNaming naming_;
  std::vector<Piece> pieces_;
};

/// Removes patches without faces; returns them.
std::vector<Patch> drop_empty_patches(MixedMesh& mesh) {
  std::vector<Patch>& patches = mesh.info.patches;
  const std::vector<bool> in_use =
      patches_in_use(patches.size(), {mesh.triangle_patches, mesh.quadrilateral_patches});
  std::vector<std::int32_t> number(patches.size(), -1);
  std::vector<Patch> gone, kept;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (!in_use[p]) {
      gone.push_back(std::move(patches[p]));
      continue;
    }
    number[p] = static_cast<std::int32_t>(kept.size());
    kept.push_back(std::move(patches[p]));
  }
  patches = std::move(kept);
  for (std::int32_t& p : mesh.triangle_patches) p = number[static_cast<std::size_t>(p)];
  for (std::int32_t& p : mesh.quadrilateral_patches) p = number[static_cast<std::size_t>(p)];
  return gone;
}

/// Whether an opening made by a cut is the one that was cut off: of the same label, if its file knew that.
bool may_replace(const Patch& made, const Patch& lost) {
  return lost.labels[0] == kBackground || lost.labels[0] == made.labels[0];
}

/// Angle inside a mesh between two of its faces, whose normals point out of it.
double angle_inside_deg(const Vec3& one, const Vec3& other) {
  return degrees(std::acos(std::clamp(-one.dot(other), -1.0, 1.0)));
}

/// Area, centre and least wall angle of each named opening, in mm (LPS).
std::vector<CutMesh::Opening> measure(const MixedMesh& mesh, const std::set<std::string>& names) {
  const Vec3 to_mm = frame_factors(mesh.info, MeshInfo());
  const auto normal_of = [&](std::size_t t) { return triangle_normal(mesh.points, mesh.triangles[t]); };
  std::vector<CutMesh::Opening> openings;
  for (std::size_t p = 0; p < mesh.info.patches.size(); ++p) {
    if (!names.contains(mesh.info.patches[p].name)) continue;
    CutMesh::Opening& opening = openings.emplace_back();
    opening.name = mesh.info.patches[p].name;
    std::map<std::uint64_t, std::size_t> at_edge;  // Its triangle.
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      if (mesh.triangle_patches[t] == static_cast<std::int32_t>(p))
        for_each_edge_of(mesh.triangles[t],
                         [&](std::uint32_t a, std::uint32_t b) { at_edge[edge_key(a, b)] = t; });
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto patch = static_cast<std::size_t>(mesh.triangle_patches[t]);
      if (mesh.info.patches[patch].kind != PatchKind::kWall) continue;
      for_each_edge_of(mesh.triangles[t], [&](std::uint32_t a, std::uint32_t b) {
        if (const auto at = at_edge.find(edge_key(a, b)); at != at_edge.end())
          opening.min_angle_deg =
              std::min(opening.min_angle_deg, angle_inside_deg(normal_of(t), normal_of(at->second)));
      });
    }
    AreaSum sum;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (mesh.triangle_patches[t] != static_cast<std::int32_t>(p)) continue;
      std::array<Vec3, 3> corners;
      for (std::size_t i = 0; i < 3; ++i) corners[i] = mesh.points[mesh.triangles[t][i]].cwiseProduct(to_mm);
      sum.add(corners[0], corners[1], corners[2]);
    }
    opening.area_mm2 = sum.area;
    opening.centre_mm = sum.centre();
  }
  return openings;
}

}  // namespace

CutMesh cut_mesh(MixedMesh& mesh, std::span<const CutPlane> planes) {
  CutMesh made;
  std::set<std::string> added;
  const Vec3 factors = frame_factors(MeshInfo(), mesh.info);
  for (const CutPlane& plane : planes) {
    const CellsCutOff cut = cut_off_beyond(mesh, plane.point_mm.cwiseProduct(factors),
                                           plane.normal.cwiseProduct(factors.cwiseSign()).stableNormalized());
    made.removed += cut.removed;
    const auto first_new = static_cast<std::size_t>(cut.first_patch);
    const std::size_t new_count = mesh.info.patches.size() - first_new;
    std::vector<Patch> lost;
    for (Patch& patch : drop_empty_patches(mesh)) {
      if (added.erase(patch.name) == 0) made.gone.push_back(patch.name);
      if (patch.kind == PatchKind::kOpening) lost.push_back(std::move(patch));
    }
    const std::size_t first = mesh.info.patches.size() - new_count;
    if (lost.size() == 1 && new_count == 1 && may_replace(mesh.info.patches[first], lost[0]))
      mesh.info.patches[first] = std::move(lost[0]);
    else
      NewNames(mesh, static_cast<std::int32_t>(first));
    for (std::size_t p = first; p < mesh.info.patches.size(); ++p) added.insert(mesh.info.patches[p].name);
  }
  made.openings = measure(mesh, added);
  return made;
}

}  // namespace lumesh
