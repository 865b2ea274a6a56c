#include "lumesh/stages/vessel_ends.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/domain/patched_surface.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/outer_faces.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/mesh/patch_renaming.hpp"
#include "lumesh/stages/input_cuts.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/vessels/vessel_axes.hpp"

namespace lumesh {
namespace {

/// Points of a line, one radius and two from its end on.
std::vector<Vec3> places_up(const Polylines& lines, std::span<const std::uint32_t> from_tip,
                            double radius_mm) {
  constexpr std::size_t kMax = 2;
  std::vector<Vec3> places;
  const std::vector<double> lengths_mm = lengths_along(lines, from_tip);
  for (std::size_t i = 1; i < from_tip.size() && places.size() < kMax; ++i)
    if (lengths_mm[i] >= static_cast<double>(places.size() + 1) * radius_mm)
      places.push_back(lines.points[from_tip[i]]);
  return places;
}

bool is_at_opening(const Vec3& place, double radius_mm, const Opening& opening) {
  const Vec3 off = place - opening.centre_mm;
  // Beyond it is the stump of a vessel that was cut.
  return off.dot(opening.normal) > -(radius_mm + opening.voxel_mm) &&
         off.norm() < 2 * (radius_mm + opening.radius_mm());
}

}  // namespace

std::vector<VesselEnd> vessel_ends(const Polylines& lines, double min_radius_mm,
                                   std::span<const Opening> openings) {
  std::vector<VesselEnd> ends;
  const auto look_at = [&](std::span<const std::uint32_t> from_tip) {
    const std::uint32_t tip = from_tip.front();
    const Vec3& place = lines.points[tip];
    const double radius_mm = lines.scalars.at("radius")[tip];
    const bool is_open = std::ranges::any_of(
        openings, [&](const Opening& opening) { return is_at_opening(place, radius_mm, opening); });
    if (!is_open && radius_mm >= min_radius_mm)
      ends.push_back({radius_mm, place, places_up(lines, from_tip, radius_mm)});
  };
  for (const auto& from_tip : lines_from_ends(lines)) look_at(from_tip);
  std::ranges::stable_sort(ends,
                           [](const VesselEnd& a, const VesselEnd& b) { return a.radius_mm > b.radius_mm; });
  return ends;
}

void try_cuts(const LabelImage& image, const Polylines& lines, std::span<const CutPlane> cuts,
              std::size_t enough, std::vector<VesselEnd>& ends) {
  std::size_t count = 0;
  for (VesselEnd& end : ends) {
    if (count == enough) return;
    std::vector<Vec3> places = {end.place_mm};
    places.insert(places.end(), end.farther_mm.begin(), end.farther_mm.end());
    for (const Vec3& place : places) {
      const Vec3 as_told = place_from(cut_place_text(place)).value();  // A digit may matter.
      const std::string refusal = refusal_of_cut(image, lines, cuts, as_told);
      if (end.refusal.empty()) end.refusal = refusal;
      if (!refusal.empty()) continue;
      end.cut_mm = place;
      end.refusal.clear();
      ++count;
      break;
    }
  }
}

std::vector<VesselEnd> vessel_ends(const LabelImage& image, std::span<const CutPlane> cuts,
                                   std::span<const Opening> openings, std::size_t enough, Context& context) {
  if (context.cancelled()) return {};
  const Polylines lines = axes_if_any(image, cuts);  // What that would warn of, other stages say.
  std::vector<VesselEnd> ends = vessel_ends(lines, image.frame().spacing_mm.maxCoeff(), openings);
  try_cuts(image, lines, cuts, enough, ends);
  return ends;
}

namespace {

/// @param of_what  " of the surface", or nothing.
std::string only_opening(const std::string& name, std::string_view of_what) {
  return fmt::format("\"{}\" is the only opening{}, and nothing flows through a vessel with one; ", name,
                     of_what);
}

const VesselEnd* first_to_cut(std::span<const VesselEnd> ends) {
  const auto first = std::ranges::find_if(ends, [](const VesselEnd& end) { return end.cut_mm.has_value(); });
  return first == ends.end() ? nullptr : &*first;
}

}  // namespace

std::string dead_end_warning(std::span<const VesselEnd> ends) {
  if (ends.empty()) return "";
  const bool is_one = ends.size() == 1;
  const VesselEnd* const to_cut = first_to_cut(ends);
  const std::string remedy =
      to_cut == nullptr
          ? fmt::format("it cannot be cut: {}", ends.front().refusal)
          : fmt::format("to open {}, cut it square with {} {}",
                        to_cut == ends.data()
                            ? "it"
                            : fmt::format("that of {:.3g} mm, the widest that can be cut", to_cut->radius_mm),
                        option_name("cut_at"), cut_place_text(*to_cut->cut_mm));
  return fmt::format("{} inside the image and {} closed there, {} {:.3g} mm in radius; {}",
                     is_one ? "1 vessel ends" : fmt::format("{} vessels end", ends.size()),
                     is_one ? "is" : "are", is_one ? "about" : "the widest", ends.front().radius_mm, remedy);
}

std::string cut_place_text(const Vec3& place_mm) {
  const Vec3 p = place_mm + Vec3::Zero();  // No -0.
  return fmt::format("{:.6g},{:.6g},{:.6g}", p.x(), p.y(), p.z());
}

std::string closed_vessel_warning(const LabelImage& image, std::span<const CutPlane> cuts,
                                  std::span<const Opening> openings, Context& context) {
  std::vector<std::string> names;  // Of lumens.
  for (const Opening& opening : openings)
    if (!is_rim_name(opening.name)) names.push_back(opening.name);
  if (names.size() > 1) return "";
  const std::vector<VesselEnd> ends = vessel_ends(image, cuts, openings, 1, context);
  if (ends.empty()) return "";
  const std::string begin =
      (names.empty() ? "no vessel leaves the image, so the mesh has no openings; "
                     : only_opening(names.front().empty() ? "inlet_1" : names.front(), "")) +
      counted(ends.size(), "ends", "end") + " inside: ";
  const VesselEnd* const to_cut = first_to_cut(ends);
  if (to_cut == nullptr)
    return begin + fmt::format("none can be cut with {} (lumesh info says why)", option_name("cut_at"));
  return begin + fmt::format("cut {} square with {} {} (lumesh info lists all)",
                             ends.size() == 1        ? "it"
                             : to_cut == ends.data() ? "the widest"
                                                     : "one",
                             option_name("cut_at"), cut_place_text(*to_cut->cut_mm));
}

std::string closed_surface_warning(std::span<const Patch> patches, std::span<const FlatEnd> ends) {
  std::set<std::string> names, openings;
  for (const Patch& patch : patches) {
    names.insert(patch.name);
    if (patch.kind == PatchKind::kOpening) openings.insert(patch.name);
  }
  // A patch that lies in several places is no flat end.
  const bool is_one_end = openings.size() == 1 && ends.size() == 1 && ends.front().name == *openings.begin();
  if (!openings.empty() && !is_one_end) return "";
  if (openings.size() == 1)
    return only_opening(*openings.begin(), " of the surface") +
           fmt::format(
               "an end that is rounded, or cut off obliquely, is taken as wall: cut it off with {}, or "
               "give a smaller {}",
               option_name("cut_at"), option_name("feature_angle"));
  if (names.size() > 1)
    return fmt::format(
        "none of the surface's {} patches is a flat end, so the mesh has no openings; give flat ends patches "
        "of their own, or all triangles one patch, or cut the vessels off with {}",
        names.size(), option_name("cut_at"));
  return "the surface has no flat end, so the mesh has no openings; cut the vessels off flat before, with "
         "edges around the ends that are sharper than `feature_angle`, or cut them with `cut_at`";
}

std::string closed_surface_warning(const Domain& domain) {
  constexpr Material kInside = 1;
  std::vector<Patch> patches;
  for (Material outside = 0; outside < domain.material_count(); ++outside)
    if (const auto patch = domain.patch_between(kInside, outside); patch && outside != kInside)
      patches.push_back(*patch);
  return closed_surface_warning(patches, domain.flat_ends());
}

/// The patch of a flat end, and flat ones beside it in its plane, such as the lumen's within a wall's.
std::set<std::string> patches_in_plane(const MixedMesh& surface, const FlatEnd& end) {
  constexpr double kOff = 1e-3;  // Of the end's radius.
  const double near_mm = kOff * circle_radius(end.area_mm2);
  std::vector<bool> is_flat(surface.info.patches.size(), true), is_used(surface.info.patches.size(), false);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto p = static_cast<std::size_t>(surface.triangle_patches[t]);
    is_used[p] = true;
    for (const std::uint32_t v : surface.triangles[t])
      if (std::abs(end.normal.dot(surface.points[v] - end.centre_mm)) > near_mm) is_flat[p] = false;
  }
  std::set<std::string> names = {end.name};
  for (std::size_t p = 0; p < is_flat.size(); ++p)
    if (is_used[p] && is_flat[p]) names.insert(surface.info.patches[p].name);
  return names;
}

std::string walled_ends_warning(const MixedMesh& mesh) {
  const std::vector<Patch>& patches = mesh.info.patches;
  if (std::ranges::any_of(patches, [](const Patch& patch) { return is_plane(patch.kind); })) return "";
  if (mesh.triangles.empty() && mesh.quadrilaterals.empty() && mesh.view().cell_count() > 0) {
    MixedMesh with_faces = mesh;
    extract_boundary(with_faces);
    return with_faces.triangles.empty() ? "" : walled_ends_warning(with_faces);
  }
  // Files that do not say what a patch is have walls between labels, too.
  std::optional<OuterFaces> outer;
  if (labels_of(mesh).size() > 1) outer.emplace(mesh.view());
  const MeshView faces = outer ? outer->view() : mesh.view();
  MixedMesh outside;
  outside.points = mesh.points;
  outside.info.patches = patches;
  for (std::size_t t = 0; t < faces.triangles.size(); ++t) {
    const auto p = static_cast<std::size_t>(faces.triangle_patches[t]);
    if (p >= patches.size() || patches[p].kind != PatchKind::kWall) continue;
    outside.triangles.push_back(faces.triangles[t]);
    outside.triangle_patches.push_back(faces.triangle_patches[t]);
  }
  if (outside.triangles.empty()) return "";
  try {
    const PatchedSurface surface(surface_view(outside));
    std::set<std::string> names;
    for (const FlatEnd& end : surface.flat_ends()) names.merge(patches_in_plane(outside, end));
    if (names.empty()) return "";
    const bool has_patches =
        std::ranges::all_of(names, [&](const auto& name) { return has_patch_called(patches, name); });
    if (!has_patches)
      return fmt::format("no patch is an opening: {} count as wall; take a file in which they are patches",
                         counted(names.size(), "flat end"));
    return fmt::format(
        "no patch is an opening: the flat {} {} {} as wall; say what they are by renaming them, {} "
        "{}=NAME:inlet",
        names.size() == 1 ? "patch" : "patches", fmt::join(names, ", "),
        names.size() == 1 ? "counts" : "count", option_name("name"), *names.begin());
  } catch (const Error& error) {  // It is not closed, say: nobody knows then.
    if (error.kind() != ErrorKind::kBadInput) throw;
    return "";
  }
}

void warn_of_walled_ends(const std::string& path, const MixedMesh& mesh, Context& context) {
  const std::string line = context.phase("ends", [&] { return walled_ends_warning(mesh); });
  if (!line.empty()) context.warn(path + ": " + line);
}

}  // namespace lumesh
