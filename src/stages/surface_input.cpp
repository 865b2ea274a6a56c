#include "lumesh/stages/surface_input.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/domain/patched_surface.hpp"
#include "lumesh/domain/usual_edge.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/io/surface_file.hpp"
#include "lumesh/mesh/points_in_use.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/surface/closing.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/far_vertices.hpp"
#include "lumesh/surface/findings.hpp"
#include "lumesh/surface/rims.hpp"
#include "lumesh/surface/shells.hpp"
#include "surface_cuts.hpp"

namespace lumesh {
namespace {

using surfaces::ClosedRim;

/// Two triangles for each quadrilateral.
void split_quadrilaterals(MixedMesh& mesh) {
  for (std::size_t q = 0; q < mesh.quadrilaterals.size(); ++q) {
    const Cell<4>& c = mesh.quadrilaterals[q];
    mesh.triangles.push_back({c[0], c[1], c[2]});
    mesh.triangles.push_back({c[0], c[2], c[3]});
    mesh.triangle_patches.insert(mesh.triangle_patches.end(), 2, mesh.quadrilateral_patches[q]);
  }
  mesh.quadrilaterals.clear();
  mesh.quadrilateral_patches.clear();
}

/// Equal points become one, and triangles without three corners go; other surfaces stay as they are.
void weld_points(MixedMesh& surface) {
  TriangleMesh welded = surfaces::weld(surface.points, surface.triangles, surface.triangle_patches);
  const std::vector<std::uint8_t> is_used = points_in_use(surface.points.size(), surface.triangles);
  const auto used = static_cast<std::size_t>(std::ranges::count(is_used, 1));
  if (welded.triangles.size() == surface.triangles.size() && welded.points.size() == used) return;
  surface.points = std::move(welded.points);
  surface.triangles = std::move(welded.triangles);
  surface.triangle_patches = std::move(welded.patches);
  surface.metric.clear();
  surface.sizes_mm.clear();
}

/// Text of what was done to an opening's rim.
std::string preparation(const ClosedRim& rim) {
  if (rim.cut_off_mm > 0) return fmt::format(", cut back by {:.2g} mm to be planar", rim.cut_off_mm);
  constexpr double kTold = 1e-3;  // Of the radius.
  if (rim.moved_mm > kTold * rim.given.radius_mm)
    return fmt::format(", rim moved by up to {:.2g} mm to be planar", rim.moved_mm);
  return "";
}

std::string line_of(const ClosedRim& rim) {
  const std::string where = fmt::format("radius {:.3g} mm at {}, {} edges", rim.given.radius_mm,
                                        place_text(rim.centre_mm), rim.given.vertices.size());
  if (!rim.is_opening) return fmt::format("filled a hole of the wall: {}", where);
  return fmt::format("capped {}{}: {}{}", rim.name.empty() ? "an opening" : rim.name,
                     rim.is_ring      ? " by a ring"
                     : rim.was_capped ? " anew, as its end was not flat"
                                      : "",
                     where, preparation(rim));
}

/// As wide as a vessel's end, or at the end of a wall.
bool may_be_opening(const ClosedRim& rim) {
  constexpr double kEdges = 2 * surfaces::Rim::kMinEdges;
  return !rim.is_opening && (rim.ends_wall || rim.given.radius_mm >= kEdges * rim.given.mean_edge_mm);
}

/// Warns of caps on a nested part: they enclose a cavity, not an opening.
void warn_of_caps_within(const MixedMesh& surface, std::span<const ClosedRim> rims, const Context& context) {
  TriangleMesh turned{surface.points, surface.triangles, surface.triangle_patches};
  const surfaces::Parts parts = surfaces::turn_alike(turned);
  if (parts.count < 2) return;
  const std::vector<surfaces::Shell> shells = surfaces::shells_of(turned.points, turned.triangles, parts);
  std::map<std::int32_t, std::uint32_t> part_of_patch;
  for (std::size_t t = 0; t < turned.triangles.size(); ++t)
    part_of_patch[turned.patches[t]] = parts.of_triangle[t];
  for (const ClosedRim& rim : rims) {
    const auto part = part_of_patch.find(rim.patch);
    if (!rim.is_opening || part == part_of_patch.end() || shells[part->second].depth % 2 == 0) continue;
    context.warn(fmt::format(
        "the open end at {} lies within another part of the surface, and closing it leaves a cavity "
        "there; an inner skin makes rings with the outer one only where both end within its radius of each "
        "other; cut off the longer one before",
        place_text(rim.centre_mm)));
  }
}

/// @throws Error{kBadInput} where two openings lie on each other, back to back: no vessel has them.
void require_no_seams(std::span<const ClosedRim> closed) {
  if (const std::optional<Vec3> place = surfaces::place_of_seam(
          closed.size(), [&](std::size_t r) { return closed[r].is_opening ? &closed[r].given : nullptr; }))
    throw Error(ErrorKind::kBadInput,
                fmt::format("two pieces of the wall end at one place, {}, where their vertices do not match; "
                            "lumesh repair joins those that lie near enough to each other",
                            place_text(*place)));
}

/// Number of the divided end that a rim was around; ends.size() if none.
std::size_t end_at(const ClosedRim& rim, std::span<const AreaSum> ends) {
  std::size_t best = ends.size();
  for (std::size_t e = 0; e < ends.size(); ++e) {
    const double off_mm = (ends[e].centre() - rim.given.centre_mm).norm();
    if (off_mm < rim.given.radius_mm &&
        (best == ends.size() || off_mm < (ends[best].centre() - rim.given.centre_mm).norm()))
      best = e;
  }
  return best;
}

void take_closed(surfaces::ClosedSurfaceMade& made, MixedMesh& surface) {
  surface.points = std::move(made.surface.points);
  surface.triangles = std::move(made.surface.triangles);
  surface.triangle_patches = std::move(made.surface.patches);
  surface.metric.clear();
  surface.sizes_mm.clear();
}

/// Ends that the file closed by something that is not flat, in pieces by sharp edges, are opened and capped
/// as open ones are. The surface stays as it is unless that succeeds for all of them.
void cap_divided_ends(MixedMesh& surface, const SurfaceInputOptions& options,
                      std::vector<ClosedRim>& closed) {
  std::vector<std::vector<std::uint32_t>> ends;
  try {
    ends = triangles_of_divided_ends(surface_view(surface), options.domain);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kBadInput) throw;  // Whoever meshes it says what is wrong.
  }
  if (ends.empty()) return;
  std::vector<AreaSum> shapes(ends.size());
  std::vector<std::int32_t> patches;
  std::vector<std::uint32_t> all;
  for (std::size_t e = 0; e < ends.size(); ++e) {
    for (const std::uint32_t t : ends[e]) {
      const auto& [a, b, c] = surface.triangles[t];
      shapes[e].add(surface.points[a], surface.points[b], surface.points[c]);
    }
    patches.push_back(surface.triangle_patches[ends[e].front()]);
    all.insert(all.end(), ends[e].begin(), ends[e].end());
  }
  std::ranges::sort(all);
  TriangleMesh open{surface.points, surface.triangles, surface.triangle_patches};
  surfaces::without_triangles(open, all);
  const auto patch_count = static_cast<std::int32_t>(surface.info.patches.size());
  surfaces::ClosedSurfaceMade made =
      surfaces::close_surface(open.points, open.triangles, open.patches, patch_count);
  std::vector<std::int32_t> patch_of_cap;
  for (ClosedRim& rim : made.rims) {
    const std::size_t end = end_at(rim, shapes);
    if (!rim.is_opening || end == ends.size()) return;
    patch_of_cap.push_back(patches[end]);
    rim.was_capped = true;
  }
  if (made.rims.size() != ends.size()) return;
  // A cap is the end's patch, where the file has several.
  const std::set<std::int32_t> used(surface.triangle_patches.begin(), surface.triangle_patches.end());
  const bool has_patches = std::ranges::count_if(used, [&](std::int32_t p) {
                             const auto at = static_cast<std::size_t>(p);
                             return at >= surface.info.patches.size() ||
                                    surface.info.patches[at].kind != PatchKind::kOpening ||
                                    !surface.info.patches[at].name.empty();
                           }) > 1;
  if (has_patches)
    for (std::int32_t& p : made.surface.patches)
      if (p >= patch_count) p = patch_of_cap[static_cast<std::size_t>(p - patch_count)];
  take_closed(made, surface);
  for (ClosedRim& rim : made.rims) {
    if (!has_patches) surface.info.patches.push_back({"", PatchKind::kOpening, {1, kBackground}});
    closed.push_back(std::move(rim));
  }
}

}  // namespace

void SurfaceInputOptions::describe(OptionList& list) {
  domain.describe(list);
  list.text(
      "patch_array", patch_array,
      "Of a .vtp surface: array of whole numbers of its cells that are patches; none: patch, ModelFaceID or "
      "CellEntityIds");
  list.flag("keep_open", keeps_open, "Refuse open surfaces instead of capping openings and filling holes");
}

void SurfaceInputOptions::validate() const {
  domain.validate();
}

std::unique_ptr<SurfaceDomain> SurfaceInput::domain(const SurfaceDomainOptions& options) const {
  return std::make_unique<SurfaceDomain>(surface_view(mesh, resolution_mm), options);
}

MixedMesh as_surface(MixedMesh mesh, const std::filesystem::path& path, const Context& context) {
  if (mesh.view().cell_count() > 0)
    throw Error(ErrorKind::kBadInput,
                path.string() + ": is a mesh of a volume; give its surface alone, such as a .stl or .vtp");
  warn_of_ras(mesh.info, path, context);
  bring_to_lps_mm(mesh);
  split_quadrilaterals(mesh);
  if (const double apart = surfaces::join_torn_corners(mesh.points, mesh.triangles); apart > 0)
    context.warn(fmt::format("{}: each triangle has corners of its own; those up to {:.2g} mm apart are one",
                             path.string(), apart));
  return mesh;
}

SurfaceInput read_surface(const std::filesystem::path& path, const std::string& unit,
                          const SurfaceInputOptions& options, const InputCuts& cuts, const Context& context) {
  MixedMesh read = read_surface_file(path, options.patch_array, context);
  if (!unit.empty()) read.info.unit = unit;
  warn_of_unknown_words(read.info, path, option_name("unit"), context);
  SurfaceInput input{as_surface(std::move(read), path, context), {}, 0};
  input.given_box_mm = bounding_box(input.mesh.points);
  weld_points(input.mesh);
  const double given_mm =
      input.mesh.triangles.empty() ? 0 : usual_resolution_mm(input.mesh.points, input.mesh.triangles);
  input.closed = naming(path.string(), [&] { return close_open_ends(input.mesh, options, context); });
  if (!input.closed.empty()) input.resolution_mm = given_mm;
  if (cuts.none()) return input;
  naming(path.string(), [&] { cut_and_extend(input, cuts, options.domain, context); });
  return input;
}

std::vector<ClosedRim> close_open_ends(MixedMesh& surface, const SurfaceInputOptions& options,
                                       const Context& context) {
  split_quadrilaterals(surface);
  weld_points(surface);
  surfaces::require_no_far_vertices(surface.points, surface.triangles);
  if (options.keeps_open) return {};
  const auto patch_count = static_cast<std::int32_t>(surface.info.patches.size());
  surfaces::ClosedSurfaceMade made =
      surfaces::close_surface(surface.points, surface.triangles, surface.triangle_patches, patch_count);
  if (made.loose.count > 0)
    context.warn(fmt::format("{} at corners only and {} left out, such as at {}",
                             counted(made.loose.count, "triangle hangs", "triangles hang"),
                             made.loose.count == 1 ? "is" : "are", place_text(made.loose.place_mm)));
  if (made.rims.empty() && made.loose.count == 0) {
    cap_divided_ends(surface, options, made.rims);
    return std::move(made.rims);
  }
  require_no_seams(made.rims);
  take_closed(made, surface);
  warn_of_caps_within(surface, made.rims, context);
  for (const ClosedRim& rim : made.rims) {
    if (rim.is_opening) surface.info.patches.push_back({"", PatchKind::kOpening, {1, kBackground}});
    constexpr double kFarApart = 0.3;  // In radii.
    if (rim.is_ring && rim.cut_off_mm > kFarApart * rim.given.radius_mm)
      context.warn(
          fmt::format("the end at {} was cut back by {:.2g} mm, to where both skins of its wall are; if what "
                      "lies within it is no skin of its wall, mesh it without",
                      place_text(rim.centre_mm), rim.cut_off_mm));
  }
  cap_divided_ends(surface, options, made.rims);
  return std::move(made.rims);
}

ClosedForMeshing closed_for_meshing(MixedMesh surface) {
  try {
    std::vector<surfaces::ClosedRim> rims = close_open_ends(surface, {}, Context());
    const PatchedSurface patched(surface_view(surface));
    name_closed(rims, patched.flat_ends());
    return {openings_of(patched.flat_ends(), patched.resolution_mm()), std::move(rims), ""};
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kBadInput) throw;
    return {{}, {}, error.what()};
  }
}

void warn_of_filled_ends(std::span<const ClosedRim> closed, const Context& context) {
  for (const ClosedRim& rim : closed)
    if (may_be_opening(rim))
      context.warn(fmt::format(
          "the surface ends at {} in a rim of radius {:.3g} mm with {} edges that is bent by {:.2g} "
          "mm; it is filled as wall, as a hole is; if a vessel ends there, cut it off flat before, "
          "with eight edges around at least",
          place_text(rim.centre_mm), rim.given.radius_mm, rim.given.vertices.size(), rim.given.deviation_mm));
}

void name_closed(std::vector<ClosedRim>& closed, std::span<const FlatEnd> ends) {
  constexpr double kNear = 0.1, kParallel = 0.95;  // Of the radius; cosine.
  for (ClosedRim& rim : closed) {
    const auto end = std::ranges::find_if(ends, [&](const FlatEnd& e) {
      return (e.centre_mm - rim.centre_mm).norm() < kNear * rim.given.radius_mm &&
             std::abs(e.normal.dot(rim.normal)) > kParallel;
    });
    if (!rim.is_opening && end != ends.end()) {
      rim.is_opening = true;
      rim.name = end->name;
    }
    if (!rim.is_opening || ends.empty() || !rim.name.empty()) continue;
    const auto distance = [&](const FlatEnd& end) { return (end.centre_mm - rim.centre_mm).squaredNorm(); };
    rim.name = std::ranges::min_element(ends, [&](const FlatEnd& a, const FlatEnd& b) {
                 return distance(a) < distance(b);
               })->name;
  }
}

std::vector<std::string> closing_lines(std::span<const ClosedRim> closed) {
  constexpr std::size_t kMaxHoles = 10;
  std::vector<std::string> lines;
  std::size_t holes = 0;
  for (const ClosedRim& rim : closed)
    if (rim.is_opening || ++holes <= kMaxHoles) lines.push_back(line_of(rim));
  if (holes > kMaxHoles)
    lines.push_back(fmt::format("filled {} smaller holes of the wall", holes - kMaxHoles));
  return lines;
}

}  // namespace lumesh
