#include "lumesh/mesh/patch_renaming.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "lumesh/core/error.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/mesh/patch_words.hpp"

namespace lumesh {
namespace {

bool is_name(std::string_view text) {
  return !text.empty() && std::string_view("0123456789-.").find(text.front()) == std::string_view::npos &&
         patch_word(text) == text;
}

std::string list_of(std::span<const NamedOpening> openings) {
  if (openings.empty()) return "there are no openings";
  std::vector<std::string> texts;
  for (const NamedOpening& o : openings)
    texts.push_back(fmt::format("{} at ({:.1f}, {:.1f}, {:.1f})", o.name, o.centre_mm.x(), o.centre_mm.y(),
                                o.centre_mm.z()));
  return fmt::format("there are {}", fmt::join(texts, ", "));
}

const NamedOpening& opening_near(const Vec3& place, std::span<const NamedOpening> openings) {
  constexpr double kRadii = 2;
  const auto off = [&](const NamedOpening& o) {
    return o.is_rim ? std::numeric_limits<double>::infinity() : (o.centre_mm - place).norm();
  };
  const auto nearest = std::min_element(openings.begin(), openings.end(),
                                        [&](const auto& a, const auto& b) { return off(a) < off(b); });
  if (nearest == openings.end() || off(*nearest) > kRadii * nearest->radius_mm)
    throw Error(ErrorKind::kBadInput, fmt::format("no opening is near ({:g}, {:g}, {:g}) mm; {}", place.x(),
                                                  place.y(), place.z(), list_of(openings)));
  return *nearest;
}

/// However it is spelt.
bool is_name_for_opening(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return is_opening_name(name);
}

std::vector<std::string> names_of(const MeshInfo& info) {
  std::vector<std::string> names;
  for (const Patch& patch : info.patches) names.push_back(patch.name);
  return names;
}

bool has_patch(const MeshInfo& info, const std::string& name) {
  return std::any_of(info.patches.begin(), info.patches.end(),
                     [&](const Patch& patch) { return patch.name == name; });
}

std::string text_of_missing(const MeshInfo& info, const PatchRenaming& renaming) {
  return fmt::format("the mesh has no patch {} to call {}; it has {}", renaming.patch, renaming.name,
                     fmt::join(names_of(info), ", "));
}

}  // namespace

std::optional<Vec3> place_from(std::string_view text) {
  Vec3 place;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (int axis = 0; axis < 3; ++axis) {
    while (at != end && *at == ' ') ++at;
    const auto [next, error] = std::from_chars(at, end, place[axis]);
    const bool is_last = axis == 2;
    if (error != std::errc() || (is_last ? next != end : next == end || *next != ',')) return std::nullopt;
    at = next + 1;
  }
  if (!place.allFinite()) return std::nullopt;
  return place;
}

PatchRenaming renaming_from(std::string_view text) {
  const std::size_t equals = text.rfind('=');
  const std::string_view patch = text.substr(0, equals);
  PatchRenaming renaming;
  if (equals != std::string_view::npos) renaming.name = std::string(text.substr(equals + 1));
  renaming.near_mm = place_from(patch);
  // Whoever writes commas means a place.
  const bool is_wrong_place = !renaming.near_mm && patch.find_first_of(",;") != std::string_view::npos;
  if (patch.empty() || is_wrong_place || !is_name(renaming.name))
    throw Error(
        ErrorKind::kUsage,
        fmt::format("\"{}\": write PATCH=NAME or X,Y,Z=NAME (a place in mm near an opening), with a name of "
                    "letters, digits, '_', '-' and '.'",
                    text));
  if (!renaming.near_mm) renaming.patch = std::string(patch);
  return renaming;
}

std::vector<PatchRenaming> renamings_from(std::span<const std::string> texts) {
  std::vector<PatchRenaming> renamings;
  for (const std::string& text : texts) renamings.push_back(renaming_from(text));
  return renamings;
}

std::vector<NamedOpening> named_openings(const MeshView& mesh) {
  const std::vector<Patch>& patches = mesh.info->patches;
  std::vector<double> area(patches.size(), 0);
  std::vector<Vec3> moment(patches.size(), Vec3::Zero());
  for_each_patch_triangle(mesh, [&](const Cell<3>& t, std::int32_t patch) {
    const auto p = static_cast<std::size_t>(patch);
    if (p >= patches.size() || patches[p].kind != PatchKind::kOpening) return;
    const auto& [a, b, c] = t;
    const double size = triangle_area(mesh.points[a], mesh.points[b], mesh.points[c]);
    area[p] += size;
    moment[p] += size / 3 * (mesh.points[a] + mesh.points[b] + mesh.points[c]);
  });
  std::vector<NamedOpening> openings;
  for (std::size_t p = 0; p < patches.size(); ++p)
    if (area[p] > 0)
      openings.push_back({patches[p].name, moment[p] / area[p], std::sqrt(area[p] / std::numbers::pi),
                          is_rim_name(patches[p].name)});
  return openings;
}

std::vector<PatchRenaming> with_patches(std::vector<PatchRenaming> renamings,
                                        std::span<const NamedOpening> openings) {
  std::set<std::string> meant, names;
  for (PatchRenaming& renaming : renamings) {
    if (!names.insert(renaming.name).second)
      throw Error(ErrorKind::kBadInput, fmt::format("two patches would be called {}", renaming.name));
    if (renaming.near_mm) renaming.patch = opening_near(*renaming.near_mm, openings).name;
    const bool is_there = std::any_of(openings.begin(), openings.end(),
                                      [&](const NamedOpening& o) { return o.name == renaming.patch; });
    if (!is_there && is_name_for_opening(renaming.patch))
      throw Error(ErrorKind::kBadInput, fmt::format("there is no {} to call {}; {}", renaming.patch,
                                                    renaming.name, list_of(openings)));
    if (!meant.insert(renaming.patch).second)
      throw Error(ErrorKind::kBadInput,
                  fmt::format("{} is given two names; {}", renaming.patch, list_of(openings)));
  }
  return renamings;
}

void rename_patches(MeshInfo& info, std::span<const PatchRenaming> renamings) {
  std::vector<std::string> names = names_of(info);
  for (const PatchRenaming& renaming : renamings) {
    const auto at = std::find_if(info.patches.begin(), info.patches.end(),
                                 [&](const Patch& patch) { return patch.name == renaming.patch; });
    if (at == info.patches.end()) throw Error(ErrorKind::kBadInput, text_of_missing(info, renaming));
    names[static_cast<std::size_t>(at - info.patches.begin())] = renaming.name;
  }
  std::set<std::string> seen;
  for (const std::string& name : names)
    if (!seen.insert(name).second)
      throw Error(ErrorKind::kBadInput, fmt::format("two patches would be called {}", name));
  for (std::size_t p = 0; p < names.size(); ++p) {
    Patch& patch = info.patches[p];
    const bool is_new_opening = patch.name != names[p] && is_name_for_opening(names[p]);
    if (patch.kind == PatchKind::kWall && is_new_opening) patch.kind = PatchKind::kOpening;
    patch.name = names[p];
  }
}

std::vector<std::string> rename_found(MeshInfo& info, std::span<const PatchRenaming> renamings) {
  std::vector<PatchRenaming> found;
  std::vector<std::string> missing;
  for (const PatchRenaming& renaming : renamings) {
    if (has_patch(info, renaming.patch))
      found.push_back(renaming);
    else
      missing.push_back(text_of_missing(info, renaming));
    // The ring that layers make of an opening is called after it.
    if (const std::string ring = renaming.patch + "_layer"; has_patch(info, ring))
      found.push_back({ring, {}, renaming.name + "_layer"});
  }
  rename_patches(info, found);
  return missing;
}

}  // namespace lumesh
