#include "lumesh/stages/check_stage.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "check_image.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/unit_doubt.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/quality/faults.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/surface_input.hpp"
#include "lumesh/surface/findings.hpp"
#include "lumesh/surface/reports.hpp"

namespace lumesh {
namespace {

constexpr std::size_t kMaxProblems = 20;  // Of a mesh.

void check_unit(const MixedMesh& mesh, std::span<const Opening> openings, CheckReport& report) {
  const std::string doubt = unit_doubt(mesh, openings);
  if (!doubt.empty()) report.findings.push_back({"unit", Severity::kRemark, 1, doubt, "", {}});
}

/// Rims are openings or holes as they are when meshed, not by what they look like alone.
void count_rims_as_meshing(const ClosedForMeshing& closed, std::vector<Finding>& findings) {
  const auto count_as = [&](const char* kind, Finding finding, bool is_opening) {
    for (const surfaces::ClosedRim& rim : closed.rims)
      if (rim.is_opening == is_opening && !rim.was_capped) finding.add(rim.given.centre_mm);
    const auto at = std::ranges::find(findings, kind, &Finding::kind);
    if (at == findings.end() && finding.count > 0)
      findings.push_back(std::move(finding));
    else if (at != findings.end() && finding.count == 0)
      findings.erase(at);
    else if (at != findings.end())
      *at = std::move(finding);
  };
  double widest_mm = 0;
  for (const surfaces::ClosedRim& rim : closed.rims)
    if (!rim.is_opening) widest_mm = std::max(widest_mm, rim.given.radius_mm);
  count_as("openings", surfaces::openings_finding(), true);
  count_as("holes", surfaces::holes_finding(widest_mm), false);
}

/// Faults are what meshing refuses: those that it repairs itself, as holes, are remarks.
void judge_as_meshing(const ClosedForMeshing& closed, CheckReport& report) {
  if (closed.refusal.empty()) {
    for (Finding& finding : report.findings) {
      if (finding.severity != Severity::kFault) continue;
      finding.severity = Severity::kRemark;
      finding.text +=
          finding.kind == "holes" ? "; they are filled when meshed" : "; closing the holes repairs them";
    }
  } else if (report.is_fit()) {
    report.findings.push_back({"refused", Severity::kFault, 1, closed.refusal, "", {}});
  }
}

CheckReport check_surface(const MixedMesh& surface, const std::filesystem::path& path) {
  CheckReport report = {
      "surface", fmt::format("{} triangles, {} points", surface.triangles.size(), surface.points.size()), {}};
  report.findings =
      naming(path.string(), [&] { return surfaces::findings_of(surface.points, surface.triangles); });
  const ClosedForMeshing closed = closed_for_meshing(surface);
  if (closed.refusal.empty()) count_rims_as_meshing(closed, report.findings);
  judge_as_meshing(closed, report);
  check_unit(surface, closed.openings, report);
  return report;
}

/// Findings of a mesh: first what no simulation survives, with places, then all that validate() asks for
/// besides.
CheckReport check_mesh(const MixedMesh& mesh) {
  constexpr const char* kRemedy = "mesh its image or surface anew";
  CheckReport report = {
      "mesh", fmt::format("{} cells, {} points", mesh.view().cell_count(), mesh.points.size()), {}};
  for (const quality::MeshFault& fault : quality::find_placed_faults(mesh.view())) {
    report.findings.push_back({"invalid", Severity::kFault, 1, fault.text, kRemedy, {}});
    if (fault.place) report.findings.back().places_mm.push_back(*fault.place);
  }
  if (mesh.view().cell_count() == mesh.tetrahedra.size()) {
    const ValidationReport validity = validate(mesh.view());
    for (const std::string& problem : validity.problems) {
      if (report.findings.size() == kMaxProblems) break;
      report.findings.push_back({"invalid", Severity::kFault, 1, problem, kRemedy, {}});
    }
  }
  check_unit(mesh, {}, report);
  return report;
}

}  // namespace

bool CheckReport::is_fit() const {
  return std::ranges::none_of(findings,
                              [](const Finding& finding) { return finding.severity == Severity::kFault; });
}

CheckReport check_file(const std::filesystem::path& path, const ImageSelection& selection, Context& context) {
  if (!is_mesh_file(path)) {
    LabelImage image = context.phase("read", [&] { return read_selected_image(path, selection, context); });
    CheckReport report = context.phase("check", [&] { return check_image(image); });
    report.checked = std::move(image);
    return report;
  }
  MixedMesh mesh = context.phase("read", [&] { return read_mesh_in(path, selection.unit, context); });
  CheckReport report = context.phase("check", [&] {
    if (mesh.view().cell_count() == 0) {
      mesh = as_surface(std::move(mesh), path, context);
      return check_surface(mesh, path);
    }
    bring_to_lps_mm(mesh);
    return check_mesh(mesh);
  });
  report.checked = std::move(mesh);
  std::stable_partition(report.findings.begin(), report.findings.end(),
                        [](const Finding& finding) { return finding.severity == Severity::kFault; });
  return report;
}

}  // namespace lumesh
