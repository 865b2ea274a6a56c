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
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/core/trimmed.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/face_numbers.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/mesh/patch_words.hpp"

namespace lumesh {
namespace {

bool is_name(std::string_view text) {
  return !text.empty() && std::string_view("0123456789-.").find(text.front()) == std::string_view::npos &&
         patch_word(text) == text;
}

/// Interfaces are not the users' to make, and of openings they say which.
std::optional<GivenKind> given_kind(std::string_view word) {
  if (word == "opening" || word == "interface") return std::nullopt;
  for (const PatchKindWord& known : kPatchKindWords)
    if (known.word == word) return GivenKind{known.kind, known.flow};
  return std::nullopt;
}

/// Kind that a name means, however it is spelt.
PatchKind kind_meant_by(const std::string& name) {
  return kind_of_name(lower_case(name));
}

/// Whether the name says something else.
bool contradicts(const std::string& name, const GivenKind& kind) {
  const PatchKind meant = kind_meant_by(name);
  if (meant == PatchKind::kWall) return false;
  if (meant != kind.kind) return true;
  const char first = static_cast<char>(std::tolower(static_cast<unsigned char>(name.front())));
  return (first == 'i' && kind.flow == FlowSide::kOutlet) || (first == 'o' && kind.flow == FlowSide::kInlet);
}

/// "7.1mm2".
std::optional<double> area_from(std::string_view text) {
  double area = 0;
  const auto [next, error] = std::from_chars(text.data(), text.data() + text.size(), area);
  const std::string_view unit(next, static_cast<std::size_t>(text.data() + text.size() - next));
  if (error != std::errc() || (unit != "mm2" && unit != "mm²") || !(area > 0) || !std::isfinite(area))
    return std::nullopt;
  return area;
}

double area_of(const NamedOpening& opening) {
  return std::numbers::pi * opening.radius_mm * opening.radius_mm;
}

std::string list_of(std::span<const NamedOpening> openings) {
  if (openings.empty()) return "there are no openings";
  std::vector<std::string> texts;
  for (const NamedOpening& o : openings)
    texts.push_back(fmt::format("{} at {} of {:.3g} mm2", o.name, decimals_text(o.centre_mm, 1), area_of(o)));
  return fmt::format("there are {}", fmt::join(texts, ", "));
}

const NamedOpening& opening_near(const Vec3& place, std::span<const NamedOpening> openings,
                                 std::span<const NamedOpening> beginnings) {
  constexpr double kRadii = 2;
  const auto off = [&](const NamedOpening& o) {
    return o.is_rim ? std::numeric_limits<double>::infinity() : (o.centre_mm - place).norm();
  };
  const NamedOpening* nearest = nullptr;
  for (const auto all : {openings, beginnings})
    for (const NamedOpening& o : all)
      if (nearest == nullptr || off(o) < off(*nearest)) nearest = &o;
  if (nearest == nullptr || off(*nearest) > kRadii * nearest->radius_mm)
    throw Error(ErrorKind::kBadInput, fmt::format("no opening is near ({:g}, {:g}, {:g}) mm; {}", place.x(),
                                                  place.y(), place.z(), list_of(openings)));
  return *nearest;
}

const NamedOpening& opening_of_area(double area, std::span<const NamedOpening> openings) {
  constexpr double kTolerance = 0.1;
  const NamedOpening* found = nullptr;
  int count = 0;
  for (const NamedOpening& o : openings) {
    if (o.is_rim || std::abs(area_of(o) - area) > kTolerance * area) continue;
    found = &o;
    ++count;
  }
  if (count != 1)
    throw Error(ErrorKind::kBadInput,
                fmt::format("{} within 10 % of {:g} mm2; {}",
                            count == 0 ? "no opening is" : fmt::format("{} openings are", count), area,
                            list_of(openings)));
  return *found;
}

bool takes_kind(const Patch& patch, const PatchRenaming& renaming) {
  return !renaming.kind || patch.kind != PatchKind::kInterface;
}

std::string text_of_interface(const PatchRenaming& renaming) {
  return fmt::format("{} lies between two labels and is no {}", renaming.patch, renaming.kind->word());
}

std::string text_of_missing(const MeshInfo& info, const PatchRenaming& renaming) {
  return fmt::format("the mesh has no patch {} to call {}; it has {}", renaming.patch, renaming.name,
                     fmt::join(names_of(info.patches), ", "));
}

void set_name_and_kind(const PatchRenaming& renaming, Patch& patch) {
  const PatchKind meant = kind_meant_by(renaming.name);
  if (renaming.kind) {
    patch.kind = renaming.kind->kind;
    patch.flow = renaming.kind->flow;
  } else if (patch.name != renaming.name && meant != PatchKind::kWall &&
             patch.kind != PatchKind::kInterface) {
    patch.kind = meant;
    patch.flow = FlowSide::kUnknown;
  }
  patch.name = renaming.name;
}

/// Patches keep the numbers that SimVascular knows them by.
void carry_face_numbers(std::span<const PatchRenaming> renamings, MeshInfo& info) {
  std::vector<std::int32_t> numbers;
  for (const PatchRenaming& renaming : renamings)
    numbers.push_back(face_number_of(info.patches[patch_called(info.patches, renaming.patch)], info));
  for (const PatchRenaming& renaming : renamings) info.provenance.erase(face_note(renaming.patch));
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (numbers[i] > 0 && face_number_in(renamings[i].name) == 0)
      info.provenance[face_note(renamings[i].name)] = std::to_string(numbers[i]);
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
  const std::string_view wanted =
      equals == std::string_view::npos ? std::string_view() : text.substr(equals + 1);
  const std::size_t colon = wanted.find(':');
  renaming.name = std::string(wanted.substr(0, colon));
  if (colon != std::string_view::npos) renaming.kind = given_kind(wanted.substr(colon + 1));
  renaming.near_mm = place_from(patch);
  renaming.area_mm2 = area_from(patch);
  // Whoever writes commas means a place.
  const bool is_wrong_place = !renaming.near_mm && patch.find_first_of(",;") != std::string_view::npos;
  const bool is_wrong_kind = colon != std::string_view::npos && !renaming.kind;
  if (patch.empty() || is_wrong_place || is_wrong_kind || !is_name(renaming.name))
    throw Error(
        ErrorKind::kUsage,
        fmt::format(
            "\"{}\": write PATCH=NAME, X,Y,Z=NAME (mm) or AREAmm2=NAME, with a name of letters, digits, "
            "'_', '-' and '.', and :inlet, :outlet, :wall or :symmetry behind it where wanted",
            text));
  if (renaming.kind && contradicts(renaming.name, *renaming.kind))
    throw Error(
        ErrorKind::kUsage,
        fmt::format(
            "\"{}\": the name {} would be read as another kind than {} from files that store names only; "
            "choose another name",
            text, renaming.name, renaming.kind->word()));
  if (!renaming.near_mm && !renaming.area_mm2) renaming.patch = std::string(patch);
  return renaming;
}

std::string_view GivenKind::word() const {
  return kind_word(kind, flow);
}

std::vector<PatchRenaming> renamings_from(std::span<const std::string> texts) {
  std::vector<PatchRenaming> renamings;
  for (const std::string& text : texts) renamings.push_back(renaming_from(text));
  return renamings;
}

std::vector<NamedOpening> named_openings(const MeshView& mesh) {
  const std::vector<Patch>& patches = mesh.info->patches;
  std::vector<AreaSum> sums(patches.size());
  for_each_patch_triangle(mesh, [&](const Cell<3>& t, std::int32_t patch) {
    const auto p = static_cast<std::size_t>(patch);
    if (p >= patches.size() || patches[p].kind != PatchKind::kOpening) return;
    const auto& [a, b, c] = t;
    sums[p].add(mesh.points[a], mesh.points[b], mesh.points[c]);
  });
  std::vector<NamedOpening> openings;
  for (std::size_t p = 0; p < patches.size(); ++p)
    if (sums[p].area > 0)
      openings.push_back(
          {patches[p].name, sums[p].centre(), circle_radius(sums[p].area), is_rim_name(patches[p].name)});
  return openings;
}

std::vector<PatchRenaming> with_patches(std::vector<PatchRenaming> renamings,
                                        std::span<const NamedOpening> openings,
                                        std::span<const NamedOpening> beginnings) {
  std::set<std::string> meant, names;
  for (PatchRenaming& renaming : renamings) {
    if (!names.insert(renaming.name).second)
      throw Error(ErrorKind::kBadInput, fmt::format("two patches would be called {}", renaming.name));
    if (renaming.near_mm) renaming.patch = opening_near(*renaming.near_mm, openings, beginnings).name;
    if (renaming.area_mm2) renaming.patch = opening_of_area(*renaming.area_mm2, openings).name;
    const bool is_there =
        std::ranges::any_of(openings, [&](const NamedOpening& o) { return o.name == renaming.patch; });
    if (!is_there && kind_meant_by(renaming.patch) == PatchKind::kOpening)
      throw Error(ErrorKind::kBadInput, fmt::format("there is no {} to call {}; {}", renaming.patch,
                                                    renaming.name, list_of(openings)));
    if (!meant.insert(renaming.patch).second)
      throw Error(ErrorKind::kBadInput,
                  fmt::format("{} is given two names; {}", renaming.patch, list_of(openings)));
  }
  return renamings;
}

void rename_patches(MeshInfo& info, std::span<const PatchRenaming> renamings) {
  std::vector<Patch> patches = info.patches;
  for (const PatchRenaming& renaming : renamings) {
    const std::size_t p = patch_called(info.patches, renaming.patch);
    if (p == patches.size()) throw Error(ErrorKind::kBadInput, text_of_missing(info, renaming));
    if (!takes_kind(info.patches[p], renaming))
      throw Error(ErrorKind::kBadInput, text_of_interface(renaming));
    set_name_and_kind(renaming, patches[p]);
  }
  std::set<std::string> seen;
  for (const Patch& patch : patches)
    if (!seen.insert(patch.name).second)
      throw Error(ErrorKind::kBadInput, fmt::format("two patches would be called {}", patch.name));
  carry_face_numbers(renamings, info);
  info.patches = std::move(patches);
}

std::vector<std::string> rename_found(MeshInfo& info, std::span<const PatchRenaming> renamings) {
  std::vector<PatchRenaming> found;
  std::vector<std::string> missing;
  for (const PatchRenaming& renaming : renamings) {
    const std::size_t p = patch_called(info.patches, renaming.patch);
    if (p == info.patches.size())
      missing.push_back(text_of_missing(info, renaming));
    else if (!takes_kind(info.patches[p], renaming))
      missing.push_back(text_of_interface(renaming));
    else
      found.push_back(renaming);
    // The ring that layers make of an opening is called after it.
    if (const std::string ring = renaming.patch + "_layer"; has_patch_called(info.patches, ring))
      found.push_back({.patch = ring, .name = renaming.name + "_layer", .kind = renaming.kind});
  }
  rename_patches(info, found);
  return missing;
}

}  // namespace lumesh
