#include "patch_selection.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "lumesh/core/error.hpp"
#include "lumesh/mesh/patch_list.hpp"

namespace lumesh::layers {
namespace {

/// Labels beside the faces of a patch.
struct PatchSides {
  std::set<Label> labels;
  bool has_inner_faces = false;  ///< With cells on both sides.
};

std::vector<PatchSides> sides_of_patches(const TetMesh& mesh, const BoundaryFaces& faces) {
  std::vector<PatchSides> sides(mesh.info().patches.size());
  for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
    PatchSides& of_patch = sides[static_cast<std::size_t>(faces.patches[f])];
    for (const TetId t : faces.tets[f])
      if (t.valid()) of_patch.labels.insert(mesh.label(t));
    of_patch.has_inner_faces |= faces.tets[f][1].valid();
  }
  return sides;
}

[[noreturn]] void throw_bad_selection(const std::string& message) {
  throw Error(ErrorKind::kBadInput, message);
}

std::size_t wanted_patch(const std::string& name, const MeshInfo& info) {
  if (const std::size_t p = patch_called(info.patches, name); p < info.patches.size()) return p;
  throw_bad_selection(
      fmt::format("there is no patch {}; there are {}", name, fmt::join(names_of(info.patches), ", ")));
}

/// Patches named, or all walls there are on that side.
std::vector<std::uint8_t> chosen_patches(const MeshInfo& info, const std::vector<PatchSides>& sides,
                                         const LayerOptions& options) {
  std::vector<std::uint8_t> chosen(info.patches.size(), 0);
  const auto is_at_label = [&](std::size_t p) {
    return options.into == 0 || sides[p].labels.contains(options.into);
  };
  for (const std::string& name : options.patches) {
    const std::size_t p = wanted_patch(name, info);
    if (!is_at_label(p))
      throw_bad_selection(fmt::format("patch {} is not at label {}; it is at {}", name,
                                      label_list({options.into}, info.label_names),
                                      label_list(sides[p].labels, info.label_names)));
    chosen[p] = 1;
  }
  if (options.patches.empty())
    for (std::size_t p = 0; p < chosen.size(); ++p)
      chosen[p] =
          info.patches[p].kind == PatchKind::kWall && !sides[p].has_inner_faces && is_at_label(p) ? 1 : 0;
  if (std::ranges::find(chosen, 1) == chosen.end()) {
    std::vector<std::string> known;
    for (std::size_t p = 0; p < chosen.size(); ++p)
      if (is_at_label(p)) known.push_back(info.patches[p].name);
    throw_bad_selection(fmt::format(
        "there is no wall for layers{}; name patches with `patch`, of {}",
        options.into == 0 ? "" : fmt::format(" at label {}", label_list({options.into}, info.label_names)),
        fmt::join(known, ", ")));
  }
  return chosen;
}

}  // namespace

PatchSelection PatchSelection::in_part(const LabelPart& part) const {
  const std::size_t count = part.mesh.info.patches.size();
  PatchSelection selection{std::vector<std::uint8_t>(count, 0), std::vector<std::uint8_t>(count, 0), into,
                           false};
  for (std::size_t p = 0; p < count; ++p)
    if (part.patches[p] >= 0) selection.layered[p] = layered[static_cast<std::size_t>(part.patches[p])];
  for (const PatchId cut : part.cut) selection.between[cut.value] = 1;
  return selection;
}

PatchSelection select_patches(const TetMesh& mesh, const BoundaryFaces& faces, const LayerOptions& options) {
  const MeshInfo& info = mesh.info();
  const std::vector<PatchSides> sides = sides_of_patches(mesh, faces);
  PatchSelection selection{chosen_patches(info, sides, options),
                           std::vector<std::uint8_t>(info.patches.size(), 0)};
  std::set<Label> at_chosen, all(mesh.labels().begin(), mesh.labels().end());
  for (std::size_t p = 0; p < sides.size(); ++p) {
    if (selection.layered[p] == 0) continue;
    at_chosen.insert(sides[p].labels.begin(), sides[p].labels.end());
    if (!sides[p].has_inner_faces || (options.side == LayerSide::kInward && options.into != 0)) continue;
    throw_bad_selection(
        fmt::format("patch {} lies between labels {} and has no free side; layers grow into one of them with "
                    "`side` inward and `into` LABEL",
                    info.patches[p].name, label_list(sides[p].labels, info.label_names)));
  }
  if (options.side == LayerSide::kOutward) return selection;
  selection.into = options.into == 0 ? at_chosen : std::set<Label>{options.into};
  selection.is_part = all != selection.into;
  return selection;
}

}  // namespace lumesh::layers
