#pragma once
/// @file Lists of patches in which a name stands once, and what names and words say of patches.

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// Number of the first patch of a name, or how many patches there are.
[[nodiscard]] inline std::size_t patch_called(std::span<const Patch> patches, std::string_view name) {
  const auto at = std::ranges::find_if(patches, [&](const Patch& patch) { return patch.name == name; });
  return static_cast<std::size_t>(at - patches.begin());
}
[[nodiscard]] inline bool has_patch_called(std::span<const Patch> patches, std::string_view name) {
  return patch_called(patches, name) < patches.size();
}

[[nodiscard]] inline std::vector<std::string> names_of(std::span<const Patch> patches) {
  std::vector<std::string> names;
  for (const Patch& patch : patches) names.push_back(patch.name);
  return names;
}

/// A name that no patch has: the wanted one, or with a number behind it.
[[nodiscard]] inline std::string free_patch_name(const std::vector<Patch>& patches,
                                                 const std::string& wanted) {
  const auto is_taken = [&](const std::string& name) { return has_patch_called(patches, name); };
  if (!is_taken(wanted)) return wanted;
  int next = 2;
  while (is_taken(wanted + "_" + std::to_string(next))) ++next;
  return wanted + "_" + std::to_string(next);
}

/// Name of a boundary that has no other.
inline constexpr const char* kWallName = "wall";
/// Whether files that say no more of a flat patch than its name mean a wall by it, such as "main_wall".
[[nodiscard]] inline bool is_wall_name(std::string_view name) {
  return name.find(kWallName) != std::string_view::npos;
}

/// What openings without another name are called: "inlet_1", "outlet_1", "outlet_2", …
[[nodiscard]] inline std::string opening_name(std::size_t number) {
  return number == 0 ? "inlet_1" : "outlet_" + std::to_string(number);
}
/// And those of a wall around a lumen: "wall_rim_1", …
[[nodiscard]] inline std::string wall_rim_name(std::size_t number) {
  return "wall_rim_" + std::to_string(number + 1);
}

/// Whether a patch is where a wall, no lumen, is cut.
[[nodiscard]] inline bool is_rim_name(std::string_view name) {
  constexpr std::string_view kRim = "wall_rim_";
  return name.starts_with(kRim) && name.size() > kRim.size() && name[kRim.size()] >= '0' &&
         name[kRim.size()] <= '9';
}

/// Whether files that say no more of a patch than its name mean an opening by it; see kind_of_name().
[[nodiscard]] inline bool is_opening_name(std::string_view name) {
  return name.starts_with("inlet") || name.starts_with("outlet") || is_rim_name(name);
}

/// Kind of patch that a name means in such files.
[[nodiscard]] inline PatchKind kind_of_name(std::string_view name) {
  if (is_opening_name(name)) return PatchKind::kOpening;
  return name.starts_with("symmetry") ? PatchKind::kSymmetry : PatchKind::kWall;
}

/// Whether patches of a kind are planes that end the object, no surface of it.
[[nodiscard]] constexpr bool is_plane(PatchKind kind) {
  return kind == PatchKind::kOpening || kind == PatchKind::kSymmetry;
}

/// What files and users call a kind of patch, and which way the flow goes through it.
struct PatchKindWord {
  std::string_view word;
  PatchKind kind;
  FlowSide flow = FlowSide::kUnknown;
};
inline constexpr std::array<PatchKindWord, 6> kPatchKindWords = {{
    {"wall", PatchKind::kWall},
    {"opening", PatchKind::kOpening},
    {"interface", PatchKind::kInterface},
    {"symmetry", PatchKind::kSymmetry},
    {"inlet", PatchKind::kOpening, FlowSide::kInlet},
    {"outlet", PatchKind::kOpening, FlowSide::kOutlet},
}};

/// The word for a kind; the flow counts for openings only.
[[nodiscard]] constexpr std::string_view kind_word(PatchKind kind, FlowSide flow) {
  for (const PatchKindWord& known : kPatchKindWords)
    if (known.kind == kind && (kind != PatchKind::kOpening || known.flow == flow)) return known.word;
  return {};
}

/// Name of the patch between two labels, the lower one first.
[[nodiscard]] inline std::string name_between(Label a, Label b) {
  return "interface_" + std::to_string(std::min(a, b)) + "_" + std::to_string(std::max(a, b));
}

}  // namespace lumesh
