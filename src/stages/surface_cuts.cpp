#include "surface_cuts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/domain/patched_surface.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/layers/extrusion.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/mesh/patches_in_use.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/plane_cut.hpp"
#include "lumesh/vessels/axis_sections.hpp"
#include "lumesh/vessels/vessel_axes.hpp"

namespace lumesh {
namespace {

using surfaces::SectionPlane;

/// A patch for each flat end, and the rest: cuts keep off the ends, and axes end there. Names that the
/// surface does not have are left to what the cuts leave.
std::vector<FlatEnd> find_ends(const PatchedSurface& patched, MixedMesh& mesh) {
  const std::vector<Patch> given = mesh.info.patches;
  take_patches_of(patched, mesh);
  for (Patch& patch : mesh.info.patches) {
    if (patch.kind == PatchKind::kOpening && !has_patch_called(given, patch.name)) patch.name.clear();
  }
  return {patched.flat_ends().begin(), patched.flat_ends().end()};
}

/// Whether a centerline ends there, rather than in a sac.
bool is_at_end(const Vec3& tip, std::span<const FlatEnd> ends) {
  return std::ranges::any_of(
      ends, [&](const FlatEnd& end) { return (tip - end.centre_mm).norm() < circle_radius(end.area_mm2); });
}

class SurfaceCutter {
 public:
  SurfaceCutter(MixedMesh& mesh, const Context& context) : mesh_(mesh), context_(context) {}

  void cut_off_beyond(const CutPlane& plane) {
    TriangleMesh surface = triangles();
    const auto is_before = [&](const Cell<3>& t) {
      return std::ranges::all_of(t, [&](std::uint32_t v) { return plane.height(surface.points[v]) < 0; });
    };
    if (std::ranges::all_of(surface.triangles, is_before)) {
      context_.warn(line_on_plane_beyond(plane));
      return;
    }
    const std::int32_t caps =
        surfaces::cut_off_beyond(surface, {plane.point_mm, plane.normal.normalized()}, patch_count());
    replace_by(std::move(surface), caps);
  }

  void cut_at(const std::vector<Vec3>& places) {
    Context quiet;
    const Polylines lines = axes_of_vessels(mesh_, {}, quiet);
    for (const Vec3& place : places)
      cut_off_end(square_axis_at(lines, place, {}, axes_by_triangles()), kMaxWideningAtPlaces,
                  CutPart::kSmaller);
  }

  /// Cuts off the ends of vessels that end in an opening.
  void clip_ends(const LocalLength& length, std::span<const FlatEnd> ends) {
    Context quiet;
    const Polylines lines = axes_of_vessels(mesh_, {}, quiet);
    std::vector<Vec3> closed_ends;
    const auto is_end = [&](std::uint32_t tip) {
      if (is_at_end(lines.points[tip], ends)) return true;
      closed_ends.push_back(lines.points[tip]);
      return false;
    };
    const auto shape_of = [&](const Vec3& tip, const Vec3& outward, double /*radius_mm*/) {
      const auto end = std::ranges::min_element(
          ends, {}, [&](const FlatEnd& e) { return (tip - e.centre_mm).norm() / circle_radius(e.area_mm2); });
      return EndShape{0, end == ends.end() ? 0 : end->area_mm2 * std::abs(end->normal.dot(outward))};
    };
    const auto cut = [&](const AxisPlace& at) { cut_off_end(at, kMaxWideningAtEnds, CutPart::kAbove); };
    const std::vector<Vec3> tried =
        cut_ends(lines, {length, is_end, shape_of, axes_by_triangles(), cut}, {}, context_);
    if (ends.empty()) warn_of_closed_ends(closed_ends);
    for (const FlatEnd& end : ends)
      if (std::ranges::none_of(tried, [&](const Vec3& tip) { return is_at_end(tip, std::span(&end, 1)); }))
        context_.warn(
            fmt::format("{}: {} at {} stays: no axis of a vessel ends there; cut it with `cut_plane`",
                        option_name("clip_ends"), end.name, place_text(end.centre_mm)));
  }

 private:
  /// The direction of axes by sections of the surface as it is then.
  [[nodiscard]] AxisAtPlace axes_by_triangles() const {
    return [this](const AxisPlace& at) {
      const SectionOf section_of = [this](const CutPlane& plane, double reach_mm) {
        return section_of_surface(mesh_, plane, reach_mm);
      };
      return axis_by_sections(section_of, at.across, at.radius_mm, 0, 0);
    };
  }

  void warn_of_closed_ends(const std::vector<Vec3>& ends) const {
    std::string places;
    for (const Vec3& end : ends) places += (places.empty() ? " at " : ", ") + place_text(end);
    context_.warn(
        fmt::format("{}: the surface has no flat end to cut off; vessels end rounded{}: `cut_at` with a "
                    "place on the vessel before one opens it",
                    option_name("clip_ends"), places));
  }

  [[nodiscard]] std::int32_t patch_count() const {
    return static_cast<std::int32_t>(mesh_.info.patches.size());
  }

  [[nodiscard]] TriangleMesh triangles() const {
    return {mesh_.points, mesh_.triangles, mesh_.triangle_patches};
  }

  void cut_off_end(const AxisPlace& place, double max_widening, CutPart goes) {
    std::vector<std::int32_t> ends;
    for (std::int32_t p = 0; p < patch_count(); ++p)
      if (mesh_.info.patches[static_cast<std::size_t>(p)].kind == PatchKind::kOpening) ends.push_back(p);
    TriangleMesh surface = triangles();
    const SectionPlane plane{place.across.point_mm, place.across.normal.normalized()};
    const double section_mm2 = surfaces::cut_off_end(surface, plane, place.section_radius_mm, max_widening,
                                                     patch_count(), ends, goes)
                                   .section_mm2;
    const std::string doubt = doubt_about_cut(place, section_mm2);
    if (!doubt.empty()) context_.warn(doubt);
    Patch cap = lost_end(surface);
    replace_by(std::move(surface), 1);
    mesh_.info.patches.back() = std::move(cap);
  }

  /// The only opening that a cut has left nothing of, which the new one stands for; else one without a name.
  [[nodiscard]] Patch lost_end(const TriangleMesh& left) const {
    const std::size_t count = mesh_.info.patches.size();
    const std::vector<bool> was_there = patches_in_use(count, {mesh_.triangle_patches}),
                            is_there = patches_in_use(count + 1, {left.patches});
    const Patch* lost = nullptr;
    for (std::size_t p = 0; p < count; ++p) {
      if (!was_there[p] || is_there[p] || mesh_.info.patches[p].kind != PatchKind::kOpening) continue;
      if (lost != nullptr) return {"", PatchKind::kOpening, {1, kBackground}};
      lost = &mesh_.info.patches[p];
    }
    return lost == nullptr ? Patch{"", PatchKind::kOpening, {1, kBackground}} : *lost;
  }

  void replace_by(TriangleMesh surface, std::int32_t caps) {
    for (std::int32_t i = 0; i < caps; ++i)
      mesh_.info.patches.push_back({"", PatchKind::kOpening, {1, kBackground}});
    mesh_.points = std::move(surface.points);
    mesh_.triangles = std::move(surface.triangles);
    mesh_.triangle_patches = std::move(surface.patches);
  }

  MixedMesh& mesh_;
  const Context& context_;
};

/// Drops closed openings without an end near their centre: they were cut away.
void drop_what_was_cut_away(std::span<const FlatEnd> ends, std::vector<surfaces::ClosedRim>& closed) {
  std::erase_if(closed, [&](const surfaces::ClosedRim& rim) {
    constexpr double kNear = 0.01;  // Of the radius.
    return rim.is_opening && std::ranges::none_of(ends, [&](const FlatEnd& end) {
             return (end.centre_mm - rim.centre_mm).norm() < kNear * rim.given.radius_mm;
           });
  });
}

void cut(const PatchedSurface& given, const InputCuts& cuts, const SurfaceDomainOptions& options,
         MixedMesh& mesh, const Context& context) {
  std::vector<FlatEnd> ends = find_ends(given, mesh);
  SurfaceCutter cutter(mesh, context);
  for (const CutPlane& plane : cuts.planes) cutter.cut_off_beyond(plane);
  if (!cuts.places_mm.empty()) cutter.cut_at(cuts.places_mm);
  if (!cuts.ends) return;
  if (!cuts.planes.empty() || !cuts.places_mm.empty())
    ends = find_ends(PatchedSurface(surface_view(mesh), options), mesh);
  cutter.clip_ends(*cuts.ends, ends);
}

void extend_ends(const PatchedSurface& patched, const ExtensionOptions& extension, SurfaceInput& surface,
                 const Context& context) {
  if (patched.flat_ends().empty())
    throw Error(ErrorKind::kBadInput, option_name("extend") +
                                          ": the surface has no flat end; cut vessels with `cut_at`, "
                                          "which makes openings");
  surface.beginnings = openings_of(patched.flat_ends(), surface.resolution_mm);
  take_patches_of(patched, surface.mesh);
  ExtrudedMesh made =
      extrude_openings(surface.mesh, extension.lengths, LayerCells::kTetrahedra, extension.transition,
                       [&](const Vec3& centre_mm, const Vec3& normal, double radius_mm) {
                         return axis_before_end(surface.mesh, centre_mm, normal, radius_mm);
                       });
  for (const std::span<const std::string> notes :
       {patched.patch_notes(), std::span(std::as_const(made.notes))})
    for (const std::string& note : notes) context.warn(note);
  surface.mesh = std::move(made.mesh);
}

}  // namespace

void take_patches_of(const PatchedSurface& surface, MixedMesh& mesh) {
  MixedMesh patched = surface.mesh();
  std::swap(patched.info.patches, mesh.info.patches);
  patched.info = std::move(mesh.info);
  mesh = std::move(patched);
}

void cut_and_extend(SurfaceInput& surface, const InputCuts& cuts, const SurfaceDomainOptions& options,
                    const Context& context) {
  surface.mesh.metric.clear();
  surface.mesh.sizes_mm.clear();
  const bool is_cut = !cuts.planes.empty() || !cuts.places_mm.empty() || cuts.ends.has_value();
  PatchedSurface patched(surface_view(surface.mesh, surface.resolution_mm), options);
  surface.resolution_mm = patched.resolution_mm();
  if (is_cut) {
    cut(patched, cuts, options, surface.mesh, context);
    patched = PatchedSurface(surface_view(surface.mesh), options);
  }
  drop_what_was_cut_away(patched.flat_ends(), surface.closed);
  name_closed(surface.closed, patched.flat_ends());
  if (cuts.extension.is_wanted()) extend_ends(patched, cuts.extension, surface, context);
}

}  // namespace lumesh
