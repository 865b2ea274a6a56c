#include "named_regions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/domain/patched_surface.hpp"
#include "lumesh/domain/usual_edge.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "missed_ends.hpp"
#include "room_behind.hpp"
#include "whole_ends.hpp"

namespace lumesh {

void SurfaceDomainOptions::describe(OptionList& list) {
  list.number("feature_angle", feature_angle_deg, {.min = 0, .max = 180, .excludes_min = true},
              "Of a surface: edges where it turns by more are kept")
      .in("degrees");
  list.flag(
      "keep_vertices", keep_vertices,
      "Of a surface: its vertices are vertices of the mesh, exactly, but for those nearer to others than "
      "about 0.7 edge lengths");
}

void SurfaceDomainOptions::validate() const {
  require_ranges_of(*this);
}

namespace surfaces {
NamedRegions::NamedRegions(const SurfaceView& view, const SurfaceDomainOptions& options)
    : surface(closed_surface(view)),
      regions(with_whole_ends(surface, find_regions(surface, options.feature_angle_deg))),
      box(bounding_box(surface.points)),
      mean_edge_mm(lumesh::mean_edge_mm(surface.points, surface.triangles)),
      resolution_mm(view.resolution_mm > 0 ? view.resolution_mm
                                           : usual_resolution_mm(surface.points, surface.triangles)),
      patches_(view.patch_info.begin(), view.patch_info.end()) {
  std::set<std::int32_t> used(surface.patches.begin(), surface.patches.end());
  std::erase_if(used, [&](std::int32_t number) { return is_cap_of_file(number); });
  // One is left where cuts took the others: its name stays.
  const auto known = std::ranges::count_if(patches_, [](const Patch& p) { return !is_cap(p); });
  has_named_patches = used.size() > 1 || (used.size() == 1 && known > 1);
  name_regions();
}

/// The patch of each region, and the ends among them.
void NamedRegions::name_regions() {
  std::vector<RegionShape> shapes = region_shapes(surface, regions, FlatSides::kAsWall);
  if (!has_named_patches) {
    leave_out_steps(shapes);
    leave_out_sides(shapes);
  }
  // A patch of the file is an end if all of it is.
  std::map<std::int32_t, bool> is_flat_patch;
  std::map<std::int32_t, int> region_counts;
  for (std::uint32_t r = 0; r < regions.count(); ++r) {
    const auto [at, is_new] = is_flat_patch.try_emplace(regions.patches[r], true);
    at->second = at->second && shapes[r].is_flat_end;
    ++region_counts[regions.patches[r]];
  }
  for (std::uint32_t r = 0; r < regions.count(); ++r) {  // By falling area.
    Patch patch{"", PatchKind::kWall, {1, kBackground}};
    const Patch* const known = patch_of_file(regions.patches[r]);
    const bool is_cap_there = is_cap_of_file(regions.patches[r]);
    const bool is_end = is_end_of_vessel(r, shapes[r]);
    if (is_cap_there || (!has_named_patches && is_end)) {
      patch = {free_opening_name(), PatchKind::kOpening, {1, kBackground}};
    } else if (has_named_patches) {
      patch.name = name_of_file(r);
      const bool is_flat = is_flat_patch.at(regions.patches[r]) && !is_wall_name(patch.name);
      if (is_flat || (known != nullptr && known->kind == PatchKind::kOpening))
        patch.kind = PatchKind::kOpening;
      keep_kind_of_file(r, patch);
    } else {
      patch.name = kWallName;
    }
    const bool is_one_region = !has_named_patches || region_counts.at(regions.patches[r]) == 1;
    if (patch.kind == PatchKind::kOpening && is_end && is_one_region)
      ends.push_back({patch.name, shapes[r].area_mm2, shapes[r].centre_mm, shapes[r].normal, shapes[r].box_mm,
                      triangles_of(r)});
    of_region.push_back(std::move(patch));
  }
  if (has_named_patches) {
    note_doubts(shapes);
    note_bent_ends();
  } else {
    if (!ends.empty()) {
      note_pieces(shapes);
      note_missed_ends();
    }
    note_bent_ends();
  }
}

/// A flat region that is known to be an opening is one whatever is beside it, as the flat sides of a channel.
bool NamedRegions::is_end_of_vessel(std::uint32_t region, const RegionShape& shape) const {
  const Patch* const known = patch_of_file(regions.patches[region]);
  const bool is_known = known != nullptr && known->kind == PatchKind::kOpening;
  return shape.is_flat_end || is_cap_of_file(regions.patches[region]) || (is_known && shape.is_flat);
}

/// Openings that touch each other and face alike: an end too far from flat to be one.
void NamedRegions::note_pieces(std::span<const RegionShape> shapes) {
  constexpr double kMinCosine = 0.866;                       // 30 degrees.
  std::map<std::uint32_t, std::set<std::uint32_t>> ends_at;  // Of vertices.
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    if (const std::uint32_t r = regions.of_triangle[t];
        of_region[r].kind == PatchKind::kOpening && !is_cap_of_file(regions.patches[r]))
      for (const std::uint32_t v : surface.triangles[t]) ends_at[v].insert(r);
  std::set<std::uint32_t> pieces;
  const Vec3* place = nullptr;
  for (const auto& [v, there] : ends_at)
    for (const std::uint32_t a : there)
      for (const std::uint32_t b : there) {
        if (a == b || shapes[a].normal.dot(shapes[b].normal) < kMinCosine) continue;
        if (place == nullptr) place = &surface.points[v];
        pieces.insert(a);
      }
  if (pieces.empty()) return;
  std::vector<std::string> names;
  for (const std::uint32_t r : pieces) names.push_back(of_region[r].name);
  notes.push_back(fmt::format(
      "{} touch each other, such as at {}, and face alike: they look like pieces of one end that is not "
      "flat; cut it off ({}), or open it, so that it is capped",
      fmt::join(names, ", "), place_text(*place), option_name("clip_ends")));
}

void NamedRegions::note_missed_ends() {
  for (const MissedEnd& end : missed_ends(surface, regions)) {
    if (of_region[end.region].kind == PatchKind::kOpening) continue;
    notes.push_back(fmt::format(
        "the flat piece at {}, of radius {:.3g} mm, is taken as wall, though a vessel may end there, cut off "
        "obliquely: on one side the surface turns by {:.0f} degrees only; a smaller {} makes it an opening, "
        "and so does a cut before it ({})",
        place_text(end.centre_mm), end.radius_mm, end.least_turn_deg, option_name("feature_angle"),
        option_name("cut_at")));
  }
}

void NamedRegions::note_bent_ends() {
  for (const BentEnd& end : bent_ends(surface, regions)) {
    const Patch& patch = of_region[end.region];
    if (patch.kind != PatchKind::kWall || (has_named_patches && is_wall_name(patch.name))) continue;
    notes.push_back(
        fmt::format("what closes the vessel at {}, of radius {:.3g} mm, is taken as wall, as it is {:.2g} mm "
                    "off a plane; "
                    "a cut before it makes an opening ({})",
                    place_text(end.centre_mm), end.radius_mm, end.bent_mm, option_name("cut_at")));
  }
}

/// Voxels leave flat steps all over a wall that is oblique to them, square or parallel to each other, which
/// are no ends.
void NamedRegions::leave_out_steps(std::vector<RegionShape>& shapes) {
  const std::vector<std::uint32_t> steps =
      steps_of_voxels(shapes, [&](std::uint32_t r) { return is_cap_of_file(regions.patches[r]); });
  if (steps.empty()) return;
  for (const std::uint32_t r : steps) shapes[r].is_flat_end = false;
  notes.push_back(fmt::format(
      "{} flat steps, such as at {}, are taken as wall: they look like the stairs of voxels "
      "that the surface is drawn around, and the mesh will have these, too; mesh the image itself, "
      "or smooth the surface before",
      steps.size(), place_text(shapes[steps.front()].centre_mm)));
}

/// Behind a flat side of a sac the object ends soon; a facet of the wall lies beside the vessel.
void NamedRegions::leave_out_sides(std::vector<RegionShape>& shapes) {
  std::optional<RoomBehind> room;
  std::vector<std::vector<std::uint32_t>> triangles(shapes.size());
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    if (const std::uint32_t r = regions.of_triangle[t]; shapes[r].is_flat_end) triangles[r].push_back(t);
  std::vector<std::uint32_t> sides, facets;
  double largest_mm2 = 0;
  for (std::uint32_t r = 0; r < shapes.size(); ++r) {  // By falling area.
    if (triangles[r].empty()) continue;
    if (!room) room.emplace(surface);
    if (is_cap_of_file(regions.patches[r]) || room->has_room(triangles[r], kMaxBent)) {
      largest_mm2 = std::max(largest_mm2, shapes[r].area_mm2);
      if (!is_cap_of_file(regions.patches[r]) && is_facet(shapes[r], largest_mm2, *room, triangles[r]))
        facets.push_back(r);
    } else {
      sides.push_back(r);
    }
  }
  note_left_out(
      shapes, sides,
      "as at the side of a sac, the object ends behind within 0.6 of the radius; where a vessel ends "
      "there, a cut further inside makes an opening");
  note_left_out(
      shapes, facets,
      "as on a facet of the wall, the vessel goes past behind; where one ends there, a cut before it "
      "makes an opening");
}

/// Whether a flat piece lies on the wall of a vessel, not where one ends.
/// @param largest_mm2  Of what may be ends.
bool NamedRegions::is_facet(const RegionShape& shape, double largest_mm2, const RoomBehind& room,
                            std::span<const std::uint32_t> triangles) {
  constexpr std::size_t kMinAround = 8;  // Edges, as coarse ends of vessels have.
  constexpr double kMinCosine = 0.45, kMinWidening = 4, kSpeck = 1e-3;
  const bool turns_little = shape.rim_cosine >= kMinCosine;
  const bool is_speck = shape.area_mm2 < kSpeck * largest_mm2;
  if (turns_little && shape.rim_edges < kMinAround) return true;
  return (turns_little || is_speck) && room.widening_behind(triangles) >= kMinWidening;
}

void NamedRegions::note_left_out(std::vector<RegionShape>& shapes, std::span<const std::uint32_t> pieces,
                                 const char* why) {
  if (pieces.empty()) return;
  for (const std::uint32_t r : pieces) shapes[r].is_flat_end = false;
  const RegionShape& largest = shapes[pieces.front()];
  notes.push_back(fmt::format("{}, such as at {} with {:.3g} mm2, {} taken as wall: {} ({})",
                              counted(pieces.size(), "flat piece", "flat pieces"),
                              place_text(largest.centre_mm), largest.area_mm2,
                              pieces.size() == 1 ? "is" : "are", why, option_name("cut_at")));
}

/// Ends that are taken for wall because a few bent triangles belong to their patch, walls that are taken for
/// ends by their name, and ends of one name.
void NamedRegions::note_doubts(std::span<const RegionShape> shapes) {
  constexpr double kMinFlat = 0.5, kMinBent = 0.3;  // Of the patch's area.
  constexpr double kBentEvenness = 0.7;             // Half a tube has 0.64, a bulging end more.
  struct Flat {
    std::uint32_t first_region = 0;
    double area_mm2 = 0, flat_mm2 = 0, bent_mm2 = 0;
    std::vector<std::string> places = {};
  };
  std::map<std::int32_t, Flat> patches;
  for (std::uint32_t r = 0; r < shapes.size(); ++r) {
    Flat& flat = patches.try_emplace(regions.patches[r], Flat{r}).first->second;
    flat.area_mm2 += shapes[r].area_mm2;
    if (shapes[r].evenness < kBentEvenness) flat.bent_mm2 += shapes[r].area_mm2;
    if (!shapes[r].is_flat_end) continue;
    flat.flat_mm2 += shapes[r].area_mm2;
    flat.places.push_back(place_text(shapes[r].centre_mm));
  }
  for (const auto& [number, flat] : patches) {
    const Patch& patch = of_region[flat.first_region];
    if (patch.kind == PatchKind::kWall && !is_wall_name(patch.name) &&
        flat.flat_mm2 >= kMinFlat * flat.area_mm2)
      notes.push_back(fmt::format(
          "patch \"{}\" is flat in {:.0f} % of its area, at {}, but is taken as wall, as other "
          "triangles of it are not in that plane; leave these to the wall's patch to make it an opening",
          patch.name, 100 * flat.flat_mm2 / flat.area_mm2, fmt::join(flat.places, " and ")));
    const RegionShape& shape = shapes[flat.first_region];
    if (patch.kind == PatchKind::kWall && !is_wall_name(patch.name) && shape.is_like_end &&
        !shape.is_flat_end && lies_along_wall(shape))
      notes.push_back(fmt::format(
          "patch \"{}\" at {} is flat, but taken as wall, as the wall around goes on almost in its plane; "
          "where a vessel ends there, a cut before it makes an opening ({})",
          patch.name, place_text(shape.centre_mm), option_name("cut_at")));
    if (patch.kind == PatchKind::kOpening && flat.bent_mm2 >= kMinBent * flat.area_mm2)
      notes.push_back(
          fmt::format("patch \"{}\" is taken as an opening, all of it, though {:.0f} % of its area are bent "
                      "as a wall is; give these triangles to a patch of the wall",
                      patch.name, 100 * flat.bent_mm2 / flat.area_mm2));
    if (patch.kind == PatchKind::kOpening && flat.places.size() > 1)
      notes.push_back(
          fmt::format("patch \"{}\" lies in {} separate places, at {}: openings of one name are one patch; "
                      "give them names of their own",
                      patch.name, flat.places.size(), fmt::join(flat.places, " and ")));
  }
}

const Patch* NamedRegions::patch_of_file(std::int32_t number) const {
  const bool is_known = number >= 0 && static_cast<std::size_t>(number) < patches_.size();
  return is_known ? &patches_[static_cast<std::size_t>(number)] : nullptr;
}

bool NamedRegions::is_cap_of_file(std::int32_t number) const {
  const Patch* const known = patch_of_file(number);
  return known != nullptr && is_cap(*known);
}

std::string NamedRegions::name_of_file(std::uint32_t region) const {
  const Patch* const known = patch_of_file(regions.patches[region]);
  return known != nullptr && !known->name.empty() ? known->name
                                                  : "patch_" + std::to_string(regions.patches[region]);
}

std::vector<std::array<Vec3, 3>> NamedRegions::triangles_of(std::uint32_t region) const {
  std::vector<std::array<Vec3, 3>> triangles_mm;
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    if (regions.of_triangle[t] == region)
      triangles_mm.push_back({surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2)});
  return triangles_mm;
}

/// The next one that the file has not.
std::string NamedRegions::free_opening_name() {
  for (;;) {
    std::string name = opening_name(named_openings_++);
    if (!has_named_patches || !has_patch_called(patches_, name)) return name;
  }
}

/// What only users say.
void NamedRegions::keep_kind_of_file(std::uint32_t region, Patch& patch) const {
  const Patch* const known = patch_of_file(regions.patches[region]);
  if (known == nullptr) return;
  if (known->kind == PatchKind::kSymmetry) patch.kind = PatchKind::kSymmetry;
  patch.flow = known->flow;
}

}  // namespace surfaces

PatchedSurface::PatchedSurface(const SurfaceView& surface, const SurfaceDomainOptions& options) {
  options.validate();
  regions_ = std::make_shared<const surfaces::NamedRegions>(surface, options);
}

std::span<const FlatEnd> PatchedSurface::flat_ends() const {
  return regions_->ends;
}

std::span<const std::string> PatchedSurface::patch_notes() const {
  return regions_->notes;
}

std::span<const Patch> PatchedSurface::patches() const {
  return regions_->of_region;
}

double PatchedSurface::resolution_mm() const {
  return regions_->resolution_mm;
}

MixedMesh PatchedSurface::mesh() const {
  MixedMesh mesh;
  mesh.points = regions_->surface.points;
  mesh.triangles = regions_->surface.triangles;
  std::vector<Patch>& patches = mesh.info.patches;
  std::vector<std::int32_t> number;
  for (const Patch& patch : regions_->of_region) {
    const std::size_t at = patch_called(patches, patch.name);
    number.push_back(static_cast<std::int32_t>(at));
    if (at == patches.size()) patches.push_back(patch);
  }
  for (const std::uint32_t region : regions_->regions.of_triangle)
    mesh.triangle_patches.push_back(number[region]);
  return mesh;
}

}  // namespace lumesh
