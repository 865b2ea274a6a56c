#include "lumesh/stages/repair_stage.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/parse_number.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/io/surface_file.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/surface_input.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/far_vertices.hpp"
#include "lumesh/surface/findings.hpp"
#include "lumesh/surface/loose_triangles.hpp"
#include "lumesh/surface/repair.hpp"
#include "lumesh/surface/rims.hpp"
#include "lumesh/surface/shells.hpp"
#include "surface_rebuild.hpp"

namespace lumesh {
namespace {

ShareOrLength length_from(std::string_view text) {
  ShareOrLength length;
  length.is_percent = text.ends_with('%');
  if (length.is_percent) text.remove_suffix(1);
  length.number = parse_number<double>(text).value_or(0);
  length.validate();
  return length;
}

std::uint64_t count_components(const TriangleMesh& surface) {
  TriangleMesh copy = surface;
  return surfaces::turn_alike(copy).count;
}

/// The surface without specks and copies, turned outwards, whichever way its triangles are turned: what is
/// inside of it is what the whole is about. Where it is closed, parts within others enclose cavities.
TriangleMesh turned_outwards(TriangleMesh mesh, RepairOutcome& outcome) {
  const std::vector<std::uint32_t> shared = surfaces::shared_triangles(mesh.triangles);
  outcome.report.shared_triangles = shared.size();
  surfaces::without_triangles(mesh, shared);
  surfaces::without_triangles(mesh, surfaces::duplicate_triangles(mesh.triangles));
  outcome.report.dropped_parts = surfaces::drop_specks_and_copies(mesh, outcome.max_distance_mm);
  std::vector<surfaces::Rim> rims = surfaces::find_rims(mesh);
  if (rims.empty())
    surfaces::turn_by_nesting(mesh, find_self_crossings(mesh.points, mesh.triangles));
  else
    surfaces::turn_outwards(mesh, rims);
  return mesh;
}

/// A place of an opening, which rebuilding would close; none if there is none.
const Vec3* place_of_opening(const std::vector<surfaces::Rim>& rims, const TriangleMesh& mesh) {
  const std::vector<std::uint8_t> is_opening = surfaces::rims_are_openings(mesh, rims);
  const auto first = std::ranges::find(is_opening, 1);
  return first == is_opening.end() ? nullptr
                                   : &rims[static_cast<std::size_t>(first - is_opening.begin())].centre_mm;
}

[[noreturn]] void throw_unrepairable(const std::string& why, const Vec3& place) {
  throw Error(ErrorKind::kNotReached,
              fmt::format("cannot be repaired: {} at {}; repair it by hand or allow more: {}", why,
                          place_text(place), option_name("max_distance")));
}

double diagonal_mm(const MixedMesh& surface) {
  Box3 box;
  for (const Cell<3>& t : surface.triangles)
    for (const std::uint32_t v : t) box.extend(surface.points[v]);
  return box.diagonal().norm();
}

/// The surface repaired where its faults are; without triangles if it has to be rebuilt.
TriangleMesh repaired_locally(const TriangleMesh& given, const RepairRequest& request,
                              RepairOutcome& outcome) {
  surfaces::RepairedSurface repaired = surfaces::repair_locally(given, outcome.max_distance_mm);
  const surfaces::RepairReport before = outcome.report;
  outcome.report = repaired.report;
  outcome.report.stray_pieces = before.stray_pieces;
  outcome.report.stray_area_mm2 = before.stray_area_mm2;
  outcome.report.stray_mm = before.stray_mm;
  if (!repaired.ok() && request.method == RepairMethod::kLocal)
    throw_unrepairable(repaired.failure, repaired.failure_mm);
  outcome.local_failure = repaired.failure;
  return std::move(repaired.surface);
}

/// The checker's last word, and whether each piece encloses anything.
void require_no_faults(const TriangleMesh& result, const std::string& consequence) {
  for (const Finding& finding : surfaces::findings_of(result.points, result.triangles))
    if (finding.severity == Severity::kFault)
      throw_unrepairable(consequence + finding.text,
                         finding.places_mm.empty() ? result.points[0] : finding.places_mm[0]);
  TriangleMesh turned = result;
  const surfaces::Parts parts = surfaces::turn_alike(turned);
  for (const surfaces::Shell& shell : surfaces::shells_of(turned.points, turned.triangles, parts))
    if (shell.volume_mm3 == 0) throw_unrepairable("it encloses nothing", shell.place_mm);
  std::vector<surfaces::Rim> rims = surfaces::find_rims(turned);
  if (rims.empty()) return;
  surfaces::turn_outwards(turned, rims);
  const std::vector<std::uint8_t> is_opening = surfaces::rims_are_openings(turned, rims);
  if (const std::optional<Vec3> place = surfaces::place_of_seam(
          rims.size(), [&](std::size_t r) { return is_opening[r] != 0 ? &rims[r] : nullptr; }))
    throw_unrepairable("two pieces of the wall end at one place, too far apart to be joined", *place);
}

/// @throws Error{kNotReached} where hardly any triangle has a neighbour: a heap of triangles is no surface.
void require_neighbours(const TriangleMesh& given) {
  constexpr double kMostOpen = 0.5;  // Of the sides of all triangles.
  std::size_t open = 0;
  for (const auto& neighbours : surfaces::edge_neighbours(given.triangles))
    open += static_cast<std::size_t>(std::ranges::count(neighbours, surfaces::kOpenEdge));
  constexpr std::size_t kFew = 8;
  if (given.triangles.size() > kFew &&
      static_cast<double>(open) > kMostOpen * 3 * static_cast<double>(given.triangles.size()))
    throw Error(
        ErrorKind::kNotReached,
        "cannot be repaired: most triangles have no neighbours, as their corners lie apart from those of "
        "others; join these in the program that wrote them");
}

/// Leaves stray pieces out, which would be filled and enclose nothing.
void drop_stray_pieces(TriangleMesh& surface, surfaces::RepairReport& report) {
  double largest_mm2 = 0;
  std::vector<std::uint32_t> triangles;
  for (const surfaces::StrayPiece& piece : surfaces::stray_pieces(surface)) {
    triangles.insert(triangles.end(), piece.triangles.begin(), piece.triangles.end());
    ++report.stray_pieces;
    report.stray_area_mm2 += piece.area_mm2;
    if (piece.area_mm2 > largest_mm2) report.stray_mm = piece.place_mm;
    largest_mm2 = std::max(largest_mm2, piece.area_mm2);
  }
  std::ranges::sort(triangles);
  surfaces::without_triangles(surface, triangles);
}

void rebuild(const TriangleMesh& given, RepairOutcome& outcome, TriangleMesh& result) {
  const TriangleMesh mesh = turned_outwards(given, outcome);
  const std::vector<surfaces::Rim> rims = surfaces::find_rims(mesh);
  const std::string before = outcome.local_failure.empty() ? "" : outcome.local_failure + "; ";
  if (const Vec3* const opening = place_of_opening(rims, mesh))
    throw_unrepairable(before + "rebuilding would close the opening", *opening);
  RebuiltSurface made = rebuild_surface(mesh, outcome.max_distance_mm);
  if (!made.failure.empty()) throw_unrepairable(before + made.failure, made.failure_mm);
  outcome.was_rebuilt = true;
  outcome.spacing_mm = made.spacing_mm;
  outcome.report.moved = made.moved;
  outcome.report.new_triangles = made.surface.triangles.size();
  outcome.report.components = count_components(made.surface);
  result = std::move(made.surface);
}

/// Warns where components were joined. @param given  Components that there were.
void warn_of_joined_components(const RepairOutcome& outcome, std::uint64_t given, const Context& context) {
  const surfaces::RepairReport& report = outcome.report;
  if (report.shared_triangles > 0)
    context.warn("pieces that share faces are joined: these faces are left out");
  else if ((outcome.was_rebuilt || report.cut_triangles > 0) &&
           report.components + report.dropped_parts < given)
    context.warn(fmt::format("{} components have become {}: those that cross or touch are joined",
                             given - report.dropped_parts, report.components));
  if (report.inner_openings > 0)
    context.warn(
        fmt::format("{} openings lay inside of other components and are gone", report.inner_openings));
}

}  // namespace

void ShareOrLength::validate() const {
  if (!(number > 0) || !std::isfinite(number))
    throw Error(ErrorKind::kUsage,
                "must be a length in mm or a percentage, greater than 0, such as 0.2 or 1%");
}

void RepairRequest::describe(OptionList& list) {
  list.parsed(
      "max_distance",
      {[this] { return fmt::format("{}{}", max_distance.number, max_distance.is_percent ? "%" : ""); },
       [this](const std::string& text) { max_distance = length_from(text); }},
      "How far anything may move, vertices put back three times that: a length in mm, or with % a share of "
      "the surface's diagonal");
  list.choice<RepairMethod>(
      "method", method,
      {{"auto", RepairMethod::kAuto}, {"local", RepairMethod::kLocal}, {"rebuild", RepairMethod::kRebuild}},
      "local: what is sound stays to the last bit; rebuild: made anew of what is inside; auto: rebuilt where "
      "local repair fails");
}

void RepairRequest::validate() const {
  naming(option_name("max_distance"), [&] { max_distance.validate(); });
}

double RepairRequest::max_distance_mm(double diagonal_mm) const {
  return max_distance.is_percent ? max_distance.number / 100 * diagonal_mm : max_distance.number;
}

RepairOutcome repair_surface(const MixedMesh& surface, const RepairRequest& request, Context& context) {
  request.validate();
  surfaces::require_triangles(surface.triangles);
  RepairOutcome outcome;
  outcome.max_distance_mm = request.max_distance_mm(diagonal_mm(surface));
  TriangleMesh given = surfaces::weld(surface.points, surface.triangles, surface.triangle_patches);
  surfaces::require_triangles(given.triangles);
  require_neighbours(given);
  outcome.given_components = count_components(given);
  drop_stray_pieces(given, outcome.report);
  const std::uint64_t components = count_components(given);
  TriangleMesh result;
  if (request.method != RepairMethod::kRebuild) result = repaired_locally(given, request, outcome);
  if (result.triangles.empty()) rebuild(given, outcome, result);
  warn_of_joined_components(outcome, components, context);
  constexpr std::uint64_t kScrap = 20;  // Triangles that cutting may leave at an end.
  if (!outcome.was_rebuilt && outcome.report.hanging_triangles > kScrap)
    context.warn(
        fmt::format("a part of {} triangles that hung at a point only, at {}, is left out; if it is a "
                    "vessel, join it to the rest first",
                    outcome.report.hanging_triangles, place_text(outcome.report.hanging_mm)));
  if (request.in_single_precision)
    for (Vec3& p : result.points) p = p.cast<float>().cast<double>();
  require_no_faults(
      result, request.in_single_precision ? "rounded as in .stl (write .vtp) it has " : "it still has ");
  outcome.surface.points = std::move(result.points);
  outcome.surface.triangles = std::move(result.triangles);
  outcome.surface.triangle_patches = std::move(result.patches);
  outcome.surface.info = surface.info;
  return outcome;
}

RepairOutcome repair_file(const std::string& path, const RepairRequest& request, Context& context) {
  MixedMesh read = context.phase("read", [&] { return read_surface_file(path, "", context); });
  warn_of_unknown_words(read.info, path, kConvertSaysUnit, context);
  const MixedMesh surface = as_surface(std::move(read), path, context);
  naming(path, [&] { surfaces::require_no_far_vertices(surface.points, surface.triangles); });
  if (const std::string doubt = unit_doubt(surface); !doubt.empty()) context.warn(path + ": " + doubt);
  RepairOutcome outcome = naming(path, [&] {
    return context.phase("repair", [&] { return repair_surface(surface, request, context); });
  });
  outcome.surface.info.provenance = surface.info.provenance;
  if (const std::string refusal = closed_for_meshing(outcome.surface).refusal; !refusal.empty())
    context.warn("the repaired surface is still refused when it is meshed, its open ends closed: " + refusal);
  return outcome;
}

}  // namespace lumesh
