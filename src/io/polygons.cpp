#include "polygons.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "cell_blocks.hpp"
#include "file_fault.hpp"

namespace lumesh::io {

namespace {

/// Number of the patch of each cell, none if all are of the first, and what patches without a name are
/// called.
struct PatchNumbers {
  std::optional<std::vector<std::int64_t>> of_cell;
  std::string unnamed = "patch_";
  std::string array = {};  // Its name.
};

constexpr const char* kNoPatchNumbers =
    "holds numbers that are negative or above 65000, which patches cannot have";

/// A number that is none of a patch.
std::optional<std::int64_t> bad_number_of(const std::vector<std::int64_t>& numbers) {
  constexpr std::int64_t kLargest = 65'000;
  const auto bad = std::ranges::find_if(numbers, [](std::int64_t id) { return id < 0 || id > kLargest; });
  return bad == numbers.end() ? std::nullopt : std::optional(*bad);
}

/// One number for all tells no patches apart.
bool is_one_number(const std::vector<std::int64_t>& numbers) {
  return std::ranges::all_of(numbers, [&](std::int64_t id) { return id == numbers.front(); });
}

/// @param has_names  Of patches, of ours.
PatchNumbers known_patches(const std::filesystem::path& path, const CellArrays& arrays, bool has_names,
                           const Context& context) {
  for (const auto& [name, unnamed] :
       {std::pair{"patch", "patch_"}, {"ModelFaceID", "face_"}, {"CellEntityIds", "face_"}}) {
    std::optional<std::vector<std::int64_t>> found = arrays.find(name);
    if (!found) continue;
    PatchNumbers numbers{std::move(found), unnamed, name};
    const bool is_ours = name == std::string_view("patch");
    if (is_ours && has_names) return numbers;
    if (is_one_number(*numbers.of_cell)) continue;
    if (is_ours || !bad_number_of(*numbers.of_cell)) return numbers;
    context.warn(
        fmt::format("{}: its array {} is not taken for patches, for it {}; number its faces from 0, or name "
                    "another array by `patch_array`",
                    path.string(), name, kNoPatchNumbers));
  }
  return {};
}

PatchNumbers patches_by(const std::filesystem::path& path, const CellArrays& arrays,
                        const std::string& name) {
  std::optional<std::vector<std::int64_t>> found = arrays.find(name);
  if (!found)
    fail(path, fmt::format("has no array \"{}\" of cells; it has {}", name,
                           arrays.names.empty() ? "none" : fmt::format("{}", fmt::join(arrays.names, ", "))));
  PatchNumbers numbers{std::move(found), name == "patch" ? "patch_" : "face_", name};
  if (const auto bad = bad_number_of(*numbers.of_cell))
    fail(path,
         fmt::format("array \"{}\" {}, such as {}; number its faces from 0", name, kNoPatchNumbers, *bad));
  if (is_one_number(*numbers.of_cell)) numbers.of_cell.reset();
  return numbers;
}

}  // namespace

void complete_patches(const std::filesystem::path& path, MixedMesh& mesh, const std::string& array,
                      const std::string& unnamed) {
  const auto known = static_cast<std::int32_t>(mesh.info.patches.size());
  std::map<std::int32_t, std::int32_t> added;  // Numbers in the file, and here.
  for (const auto* patches : {&mesh.triangle_patches, &mesh.quadrilateral_patches})
    for (const std::int32_t p : *patches) {
      if (p < 0 || p >= kPatchEnd) fail_at_patch(path, array, p, kPatchEnd);
      if (p >= known) added.emplace(p, 0);
    }
  if (added.empty()) return;
  for (auto& [number, patch] : added) {
    patch = static_cast<std::int32_t>(mesh.info.patches.size());
    mesh.info.patches.push_back({unnamed + std::to_string(number), PatchKind::kWall, {}});
  }
  for (auto* patches : {&mesh.triangle_patches, &mesh.quadrilateral_patches})
    for (std::int32_t& p : *patches)
      if (p >= known) p = added.at(p);
}

void add_polygons(const std::filesystem::path& path, const Polygons& polygons, const CellArrays& arrays,
                  const std::string& patch_array, const Context& context, MixedMesh& mesh) {
  if (!patch_array.empty() && patch_array != "patch") mesh.info.patches.clear();
  if (polygons.polygons.ends.empty() && polygons.strips.ends.empty()) fail(path, "holds no polygon");
  const std::size_t cells =
      polygons.cells_before + polygons.polygons.ends.size() + polygons.strips.ends.size();
  const PatchNumbers patches = patch_array.empty()
                                   ? known_patches(path, arrays, !mesh.info.patches.empty(), context)
                                   : patches_by(path, arrays, patch_array);
  const std::optional<std::vector<std::int64_t>>& numbers = patches.of_cell;
  if (numbers && numbers->size() < cells) fail(path, "does not hold as many patches as polygons");
  std::size_t cell = polygons.cells_before;
  const auto next_patch = [&] {
    const std::int64_t patch = numbers ? (*numbers)[cell++] : 0;
    if (patch < 0 || patch >= kPatchEnd) fail_at_patch(path, patches.array, patch, kPatchEnd);
    return static_cast<std::int32_t>(patch);
  };
  constexpr std::int64_t kVtkTriangle = 5, kVtkQuadrilateral = 9;
  for_each_cell(path, polygons.polygons, [&](std::span<const std::int64_t> corners) {
    if (corners.size() != 3 && corners.size() != 4)
      fail(path, "holds polygons that are neither triangles nor quadrilaterals");
    add_vtk_cell(path, corners.size() == 3 ? kVtkTriangle : kVtkQuadrilateral, corners, next_patch(), mesh);
  });
  for_each_cell(path, polygons.strips, [&](std::span<const std::int64_t> strip) {
    const std::int32_t patch = next_patch();
    for (std::size_t i = 0; i + 2 < strip.size(); ++i) {
      const std::array<std::int64_t, 3> corners = {strip[i], strip[i + 1 + i % 2], strip[i + 2 - i % 2]};
      add_vtk_cell<std::int64_t>(path, kVtkTriangle, corners, patch, mesh);
    }
  });
  complete_patches(path, mesh, patches.array, patches.unnamed);
}

}  // namespace lumesh::io
