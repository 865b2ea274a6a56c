#include "lumesh/report/stage_text.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <span>

#include "lumesh/core/place_text.hpp"
#include "lumesh/io/file_formats.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/stages/surface_input.hpp"

namespace lumesh::report {
namespace {

/// A line for each patch, with its area and the input's where it is an opening.
std::string patch_lines(const MeshInfo& info, std::span<const std::int32_t> patches,
                        const OpeningsCompared& openings) {
  std::string lines;
  for (std::size_t p = 0; p < info.patches.size(); ++p) {
    const std::string& name = info.patches[p].name;
    lines += fmt::format("  patch {:<20} {:>8} triangles", name,
                         std::ranges::count(patches, static_cast<std::int32_t>(p)));
    for (const OpeningInMesh& o : openings.openings)
      if (o.patches == name) {
        lines += fmt::format("  {:.4g} mm² (input {:.4g})", o.mesh_area_mm2, o.opening.area_mm2);
        break;
      }
    lines += '\n';
  }
  return lines;
}

/// A line on the time that each step took, but for single passes.
std::string time_line(const Context& context, double seconds) {
  std::string times = "  time";
  for (const PhaseTime& phase : context.phases())
    if (phase.name != "pass") times += fmt::format("  {} {:.2f}", phase.name, phase.seconds);
  return fmt::format("{}  total {:.2f} s\n", times, seconds);
}

std::string lines_of_closed(std::span<const surfaces::ClosedRim> closed) {
  std::string text;
  for (const std::string& line : closing_lines(closed)) text += fmt::format("  {}\n", line);
  return text;
}

std::string text_of_cut(const CutMesh& cut) {
  if (cut.openings.empty()) return "cut: openings beside the plane moved into it\n";
  std::string text;
  for (const CutMesh::Opening& opening : cut.openings)
    text += fmt::format("cut: {} of {:.4g} mm² at {}\n", opening.name, opening.area_mm2,
                        place_text(opening.centre_mm));
  return text;
}

/// What was done to a surface, a line for each kind of change.
std::string text_of_repairs(const RepairOutcome& outcome) {
  const surfaces::RepairReport& r = outcome.report;
  std::string text;
  const auto line = [&](std::uint64_t count, const std::string& what) {
    if (count > 0) text += fmt::format("{:>8}  {}\n", count, what);
  };
  line(r.stray_pieces, fmt::format("flat pieces by themselves left out, {:.3g} mm² in all, the largest at {}",
                                   r.stray_area_mm2, place_text(r.stray_mm)));
  if (outcome.was_rebuilt) {
    if (!outcome.local_failure.empty())
      text += fmt::format("local repair is not enough: {}\n", outcome.local_failure);
    line(r.new_triangles, fmt::format("triangles, all new: rebuilt from winding numbers, {:.3g} mm apart",
                                      outcome.spacing_mm));
    return text;
  }
  line(r.seam_vertices, "vertices at seams joined with the other side");
  line(r.shared_triangles, "triangles of faces between two pieces left out, both copies of each");
  line(r.duplicate_triangles, "triangles that were there twice left out");
  line(r.loose_triangles, "triangles that hung at corners or one edge left out");
  line(r.dropped_parts,
       fmt::format("components of {} triangles dropped: specks, or on others", r.dropped_triangles));
  line(r.singular_edges, "edges of three triangles or more cut");
  line(r.singular_points, "points where the surface touched itself divided");
  line(r.turned_triangles, "triangles turned");
  line(r.flipped_edges, "edges beside triangles without area swapped");
  line(r.holes, fmt::format("holes filled, the widest with a radius of {:.3g} mm", r.widest_hole_mm));
  line(r.moved_vertices, "vertices pulled past their neighbours put back");
  line(r.far_vertices,
       fmt::format("of them farther than asked, to where the wall around was: up to {:.3g} mm, at {}",
                   r.put_back.distance_mm, place_text(r.put_back.place_mm)));
  line(r.removed_triangles, fmt::format("triangles at crossings replaced, in {} rounds", r.rounds));
  line(r.cut_triangles, "triangles cut along the lines where they crossed");
  line(r.inner_triangles, "triangles, or pieces of them, inside left out");
  line(r.inner_openings, "openings inside left out with them");
  line(r.new_triangles, "new triangles in all");
  line(r.openings, "openings left open");
  return text;
}

std::string text_of_lines(const std::string& path, const Polylines& lines) {
  if (path.empty()) return "";
  return fmt::format("{}: {} lines, {} points\n", path, lines.lines.size(), lines.points.size());
}

std::string text_of_finding(const Finding& finding) {
  std::string text =
      fmt::format("{:<7} {:>8}  {}\n", finding.severity == Severity::kFault ? "fault" : "remark",
                  finding.count, finding.text);
  std::string places, voxels;
  for (const Vec3& p : finding.places_mm) places += " " + coordinates_text(p, 4);
  for (const Index3& v : finding.voxels) voxels += fmt::format(" ({}, {}, {})", v.x(), v.y(), v.z());
  if (!places.empty()) text += fmt::format("{:18}at{} mm\n", "", places);
  if (!voxels.empty()) text += fmt::format("{:18}voxels{}\n", "", voxels);
  if (!finding.remedy.empty()) text += fmt::format("{:18}remedy: {}\n", "", finding.remedy);
  return text;
}

}  // namespace

std::string lattice_text(const std::string& path, const LatticeMesh& made, const OpeningsCompared& openings,
                         const Context& context, double seconds) {
  const MixedMesh& mesh = made.made.mesh;
  const std::string others =
      made.is_mixed ? fmt::format("{} hexahedra, {} pyramids, ", mesh.hexahedra.size(), mesh.pyramids.size())
                    : "";
  return fmt::format("{}: {} tetrahedra, {}{} vertices, {} boundary triangles\n", path,
                     mesh.tetrahedra.size(), others, mesh.points.size(), mesh.triangles.size()) +
         patch_lines(mesh.info, mesh.triangle_patches, openings) + time_line(context, seconds);
}

std::string delaunay_text(const std::string& path, DelaunayFileMesh& made, const OpeningsCompared& openings,
                          const Context& context, double seconds) {
  const TetMesh& mesh = made.made.mesh;
  std::string text = fmt::format("{}: {} tetrahedra, {} vertices, {} boundary triangles\n", path,
                                 mesh.tet_count(), mesh.vertex_count(), made.faces.triangles.size()) +
                     lines_of_closed(made.input.given.closed()) +
                     patch_lines(mesh.info(), made.faces.patches, openings);
  const std::size_t fixed_points = made.input.given.domain().fixed_points().size();
  if (fixed_points > 0)
    text += fmt::format("  {} of the surface's {} vertices are vertices of the mesh\n",
                        made.made.report.fixed_points_kept, fixed_points);
  if (const std::optional<ImproveReport>& improved = made.made.improved)
    text += fmt::format("  dihedral angles {:.2f} to {:.2f} degrees (before improvement: {:.2f} to {:.2f})\n",
                        improved->after.min_deg, improved->after.max_deg, improved->before.min_deg,
                        improved->before.max_deg);
  return text + time_line(context, seconds);
}

std::string adapt_text(const std::string& path, const AdaptedMesh& made, double seconds) {
  const TetMesh& mesh = made.mesh.changing();
  return fmt::format("{}: {} tetrahedra, {} vertices, {} boundary triangles, complexity {:.0f}; {:.2f} s\n",
                     path, mesh.tet_count(), mesh.vertex_count(), made.mesh.faces().triangles.size(),
                     made.result.report.complexity, seconds) +
         (made.mesh.has_kept() ? fmt::format("with {} cells as they were\n", made.mesh.kept_count()) : "");
}

std::string improve_text(const std::string& path, const ImprovedMesh& made, const ImproveRequest& request,
                         double seconds) {
  const ImproveReport& report = made.report;
  return (request.cut_planes.empty() ? "" : text_of_cut(made.cut)) +
         fmt::format(
             "{}: {} tetrahedra, dihedral angles {:.2f} to {:.2f} degrees (before: {:.2f} to {:.2f}), "
             "{} tetrahedra outside the targets (before: {}); {:.2f} s\n",
             path, made.mesh.changing().tet_count(), report.after.min_deg, report.after.max_deg,
             report.before.min_deg, report.before.max_deg, report.after.tets_outside,
             report.before.tets_outside, seconds);
}

std::string centerline_text(const std::string& path, const CenterlineMade& made, double seconds) {
  const Polylines& lines = made.lines;
  const auto [least, most] = std::ranges::minmax(lines.scalars.at("radius"));
  return fmt::format("{}: {} lines, {} points, length {:.5g} mm, radius {:.3g} to {:.3g} mm, {:.2f} s\n",
                     path, lines.lines.size(), lines.points.size(), length_mm(lines), least, most, seconds) +
         (made.labels.size() < 2
              ? ""
              : fmt::format("labels {} count together as one vessel, unless some are chosen\n",
                            fmt::join(made.labels, ", "))) +
         lines_of_closed(made.closed);
}

std::string phantom_text(const PhantomRequest& request, const PhantomMade& made) {
  const PhantomSpec& spec = made.phantom.spec();
  std::string text = fmt::format("{}: {} x {} x {} voxels of {:g} x {:g} x {:g} mm\n", request.image,
                                 spec.size.x(), spec.size.y(), spec.size.z(), spec.spacing_mm.x(),
                                 spec.spacing_mm.y(), spec.spacing_mm.z());
  for (std::size_t i = 0; i < made.labels.size(); ++i) {
    const LabelTopology& label = made.labels[i];
    text += fmt::format("  label {}: {} voxels, {:.6g} mm3 (truth {:.6g}), components {}, Euler number {}\n",
                        label.label, label.voxel_count, label.volume_mm3, made.volumes_mm3[i],
                        label.component_count, label.euler_number);
  }
  return text + fmt::format("{}: parameters, for lumesh evaluate --reference\n", request.parameters_path()) +
         text_of_lines(request.centerline, made.centerline) + text_of_lines(request.velocity, made.velocity);
}

std::string conversion_text(const MeshOutput& output, const MixedMesh& mesh) {
  std::size_t faces = 0, between = 0;
  for_each_patch_face(mesh, [&](std::span<const std::uint32_t> /*face*/, std::int32_t patch) {
    ++(mesh.info.patches.at(static_cast<std::size_t>(patch)).kind == PatchKind::kInterface ? between : faces);
  });
  std::string boundary = fmt::format("{} boundary faces", faces);
  if (between > 0) boundary += fmt::format(", {} between labels", between);
  boundary += fmt::format(", {} patches\n", mesh.info.patches.size());
  std::string text = output.mesh + ": ";
  if (!is_for(output.mesh, FileUse::kWriteSurface))
    text += fmt::format("{} cells, {} points, ", mesh.view().cell_count(), mesh.points.size());
  text += boundary;
  return output.surface.empty() ? text : text + output.surface + ": " + boundary;
}

std::string renaming_text(const std::string& path, const RenamedMesh& made) {
  std::string text;
  for (const PatchRenaming& renaming : made.renamings)
    text += fmt::format("{}: {} is {}{} now\n", path, renaming.patch, renaming.name,
                        renaming.kind ? fmt::format(", kind {},", renaming.kind->word()) : "");
  return text;
}

std::string repair_text(const std::string& path, const RepairOutcome& outcome) {
  return text_of_repairs(outcome) + fmt::format(
                                        "{}: {} triangles, {} components ({} before); nothing{} moved "
                                        "farther than {:.3g} mm of {:.3g} mm\n",
                                        path, outcome.surface.triangles.size(), outcome.report.components,
                                        outcome.given_components,
                                        outcome.report.far_vertices > 0 ? " else" : "",
                                        outcome.report.moved.distance_mm, outcome.max_distance_mm);
}

std::string merge_text(const std::string& path, const MergeResult& merged,
                       const std::vector<std::string>& inputs) {
  const MergeReport& report = merged.report;
  std::string text;
  for (const MergeReport::Renumbered& label : report.renumbered)
    text += fmt::format("{}: label {}{} is label {} now\n", inputs[label.part], label.from,
                        label.name.empty() ? "" : " (" + label.name + ")", label.to);
  return text +
         fmt::format(
             "{}: {} cells, {} points; {} faces ({:.6g} {}2) and {} points shared, up to {:.2g} apart\n",
             path, merged.mesh.view().cell_count(), merged.mesh.points.size(), report.shared_faces,
             report.shared_area, merged.mesh.info.unit, report.shared_points, report.farthest);
}

std::string check_text(const std::string& path, const CheckReport& report) {
  std::string text = fmt::format("{}: {}, {}\n", path, report.what, report.size);
  for (const Finding& finding : report.findings) text += text_of_finding(finding);
  return report.findings.empty() ? text + "nothing found\n" : text;
}

}  // namespace lumesh::report
