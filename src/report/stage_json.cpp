#include "lumesh/report/stage_json.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "closed_json.hpp"
#include "command_notes_json.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/report/summary.hpp"

namespace lumesh::report {
namespace {

using Json = nlohmann::ordered_json;

Json place(const Vec3& p) {
  return Json::array({p.x(), p.y(), p.z()});
}

/// Dihedral angles.
Json angles_json(const DihedralRange& angles) {
  return {{"min", angles.min_deg}, {"max", angles.max_deg}, {"tetrahedra_outside", angles.tets_outside}};
}

Json migrations_json(const parallel::TaskMigrations& migrations) {
  return {{"local", migrations.local}, {"remote", migrations.remote}};
}

parallel::TaskMigrations sum_of(const std::vector<parallel::TaskMigrations>& all) {
  parallel::TaskMigrations sum;
  for (const parallel::TaskMigrations& one : all) sum += one;
  return sum;
}

/// Applied, rejected and contended of every operator.
Json counts_json(const operators::OperatorCounts& counts) {
  Json json;
  for (const auto& [id, name] : operators::kOperatorNames) {
    const operators::OperatorCount& count = counts[id];
    json[name] = {{"applied", count.applied}, {"rejected", count.rejected}, {"contended", count.contended}};
  }
  return json;
}

/// Adds the sum over all threads, and what each thread did and got.
void add_counts_json(Json& report, const operators::ExecutionCounts& counts) {
  report["operators"] = counts_json(counts.of_all_threads());
  report["hand_overs"] = migrations_json(sum_of(counts.migrations));
  report["threads"] = Json::array();
  for (std::size_t thread = 0; thread < counts.by_thread.size(); ++thread)
    report["threads"].push_back({{"operators", counts_json(counts.by_thread[thread])},
                                 {"hand_overs", migrations_json(counts.migrations[thread])}});
}

/// Patches with their numbers of faces. @param of_faces  The patches of each kind of face.
Json faces_by_patch_json(const MeshInfo& info,
                         std::initializer_list<std::span<const std::int32_t>> of_faces) {
  Json json = Json::array();
  for (std::size_t p = 0; p < info.patches.size(); ++p) {
    const Patch& patch = info.patches[p];
    std::ptrdiff_t faces = 0;
    for (const std::span<const std::int32_t> patches : of_faces)
      faces += std::ranges::count(patches, static_cast<std::int32_t>(p));
    json.push_back({{"name", patch.name}, {"kind", kind_word(patch.kind, patch.flow)}, {"faces", faces}});
  }
  return json;
}

Json lines_json(const Polylines& lines) {
  return {{"lines", lines.lines.size()}, {"points", lines.points.size()}, {"length_mm", length_mm(lines)}};
}

Json cut_json(const CutMesh& cut) {
  Json json = {{"tetrahedra_removed", cut.removed},
               {"patches_removed", cut.gone},
               {"openings", nlohmann::json::array()}};
  for (const CutMesh::Opening& opening : cut.openings) {
    const auto& [x, y, z] = std::tie(opening.centre_mm[0], opening.centre_mm[1], opening.centre_mm[2]);
    json["openings"].push_back({{"name", opening.name},
                                {"area_mm2", opening.area_mm2},
                                {"centre_mm", {x, y, z}},
                                {"least_angle_to_wall_deg", opening.min_angle_deg}});
  }
  return json;
}

void add_comparison(Json& json, const FirstMeshInput& input, const FirstMeshComparison& compared) {
  json["differences_from_image"] = compared.differences;
  json["openings"] = Json::parse(openings_json(compared.openings));
  if (!input.given.closed().empty()) json["closed"] = closed_json(input.given.closed());
}

}  // namespace

nlohmann::ordered_json closed_json(std::span<const surfaces::ClosedRim> closed) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const surfaces::ClosedRim& rim : closed) {
    nlohmann::ordered_json one = {{"kind", rim.is_opening ? "opening" : "hole"}};
    if (!rim.name.empty()) one["name"] = rim.name;
    one["centre_mm"] = place(rim.centre_mm);
    one["normal"] = place(rim.normal);
    one["area_mm2"] = rim.area_mm2;
    one["rim_radius_mm"] = rim.given.radius_mm;
    one["rim_edges"] = rim.given.vertices.size();
    one["rim_deviation_mm"] = rim.given.deviation_mm;
    one["cut_off_mm"] = rim.cut_off_mm;
    one["moved_mm"] = rim.moved_mm;
    one["was_capped"] = rim.was_capped;
    one["triangles"] = rim.triangles;
    one["smallest_angle_deg"] = rim.smallest_angle_deg;
    all.push_back(std::move(one));
  }
  return all;
}

std::string adapt_json(const AdaptedMesh& made, const CommandNotes& notes) {
  const AdaptReport& report = made.result.report;
  Json json = {{"complete", report.complete},
               {"complexity", report.complexity},
               {"tetrahedra", made.mesh.changing().tet_count()},
               {"vertices", made.mesh.changing().vertex_count()},
               {"boundary_triangles", made.mesh.faces().triangles.size()},
               {"kept_cells", made.mesh.kept_count()}};
  for (const LabelChange& label : made.result.volumes)
    json["volumes"].push_back({{"label", label.label},
                               {"before_mm3", label.before_mm3},
                               {"after_mm3", label.after_mm3},
                               {"change_percent", label.percent()}});
  add_counts_json(json, report.by_thread);
  for (const AdaptPass& pass : report.passes)
    json["passes"].push_back({{"name", pass.name},
                              {"seconds", pass.seconds},
                              {"tetrahedra", pass.tets},
                              {"vertices", pass.vertices},
                              {"operators", counts_json(pass.counts)}});
  return with_notes(std::move(json), notes);
}

std::string lattice_json(const LatticeMesh& made, const FirstMeshComparison& compared,
                         const CommandNotes& notes) {
  const MixedMesh& mesh = made.made.mesh;
  const LatticeReport& report = made.made.report;
  Json json = {{"tetrahedra", mesh.tetrahedra.size()},
               {"hexahedra", mesh.hexahedra.size()},
               {"pyramids", mesh.pyramids.size()},
               {"vertices", mesh.points.size()},
               {"boundary_triangles", mesh.triangles.size()},
               {"patches", faces_by_patch_json(mesh.info, {mesh.triangle_patches})},
               {"lost_labels", report.lost_labels},
               {"levels_given_up", report.levels_given_up},
               {"furthest_deviation_mm", report.furthest_deviation_mm}};
  add_comparison(json, made.input, compared);
  return with_notes(std::move(json), notes);
}

std::string delaunay_json(const DelaunayFileMesh& made, const FirstMeshComparison& compared,
                          const CommandNotes& notes) {
  const DelaunayReport& report = made.made.report;
  const std::optional<ImproveReport>& improved = made.made.improved;
  const TetMesh& mesh = made.made.mesh;
  Json json;
  json["complete"] = report.complete && (!improved || improved->complete);
  json["rules_hold"] = report.rules_hold;
  json["criterion_asks"] = report.criterion_asks;
  json["input_vertices_kept"] = report.fixed_points_kept;
  json["tetrahedra"] = mesh.tet_count();
  json["vertices"] = mesh.vertex_count();
  json["seeds"] = {
      {"inside", report.inner_seeds}, {"outside", report.outer_seeds}, {"boundary", report.boundary_seeds}};
  json["rounds"] = nlohmann::json::array();
  for (const DelaunayRound& round : report.rounds)
    json["rounds"].push_back({{"seconds", round.seconds},
                              {"tetrahedra_looked_at", round.tets_looked_at},
                              {"surface_candidates", round.surface_candidates},
                              {"volume_candidates", round.volume_candidates},
                              {"topology_candidates", round.topology_candidates},
                              {"inserted", round.inserted},
                              {"removed", round.removed}});
  if (improved)
    json["improvement"] = {{"dihedral_deg_before", angles_json(improved->before)},
                           {"dihedral_deg", angles_json(improved->after)},
                           {"passes", improved->passes.size()}};
  add_comparison(json, made.input, compared);
  json["seconds"] = steps_json(notes);
  return with_files_and_warnings(std::move(json), notes);
}

std::string metric_json(const MeshWithMetric& made, const CommandNotes& notes) {
  return with_notes({{"vertices", made.mesh.changing().vertex_count()},
                     {"tetrahedra", made.mesh.changing().tet_count()},
                     {"kept_cells", made.mesh.kept_count()},
                     {"complexity", made.result.complexity}},
                    notes);
}

std::string improve_json(const ImprovedMesh& made, const ImproveOptions& options, const CommandNotes& notes) {
  const ImproveReport& report = made.report;
  Json json;
  if (!made.cut.openings.empty()) json["cut"] = cut_json(made.cut);
  json["complete"] = report.complete;
  json["tetrahedra"] = made.mesh.changing().tet_count();
  json["targets_deg"] = {options.min_dihedral_deg, options.max_dihedral_deg};
  json["before"] = angles_json(report.before);
  json["after"] = angles_json(report.after);
  add_counts_json(json, report.by_thread);
  json["passes"] = nlohmann::json::array();
  for (const ImprovePass& pass : report.passes)
    json["passes"].push_back({{"seconds", pass.seconds},
                              {"tetrahedra", pass.tets},
                              {"vertices", pass.vertices},
                              {"dihedral_deg", angles_json(pass.angles)},
                              {"operators", counts_json(pass.counts)}});
  return with_notes(std::move(json), notes);
}

std::string centerline_json(const CenterlineMade& made, const CommandNotes& notes) {
  Json json = lines_json(made.lines);
  const auto [least, most] = std::ranges::minmax(made.lines.scalars.at("radius"));
  json["radius_mm"] = {{"min", least}, {"max", most}};
  if (!made.labels.empty()) json["labels"] = made.labels;
  if (!made.closed.empty()) json["closed"] = closed_json(made.closed);
  return with_notes(std::move(json), notes);
}

std::string phantom_json(const PhantomMade& made, const CommandNotes& notes) {
  const PhantomSpec& spec = made.phantom.spec();
  Json json = {{"kind", phantom_kind_name(spec.kind)},
               {"size_voxels", {spec.size.x(), spec.size.y(), spec.size.z()}},
               {"spacing_mm", place(spec.spacing_mm)},
               {"labels", Json::array()}};
  for (std::size_t i = 0; i < made.labels.size(); ++i) {
    const LabelTopology& label = made.labels[i];
    const PhantomTruth truth = made.phantom.truth(label.label);
    json["labels"].push_back({{"label", label.label},
                              {"voxels", label.voxel_count},
                              {"volume_mm3", label.volume_mm3},
                              {"components", label.component_count},
                              {"euler", label.euler_number},
                              {"reference",
                               {{"volume_mm3", made.volumes_mm3[i]},
                                {"components", truth.component_count},
                                {"euler", truth.euler_number}}}});
  }
  if (!made.centerline.lines.empty()) json["centerline"] = lines_json(made.centerline);
  return with_notes(std::move(json), notes);
}

std::string conversion_json(const MixedMesh& mesh, const CommandNotes& notes) {
  return with_notes(
      {{"cells", mesh.view().cell_count()},
       {"points", mesh.points.size()},
       {"boundary_faces", mesh.triangles.size() + mesh.quadrilaterals.size()},
       {"unit", mesh.info.unit},
       {"patches", faces_by_patch_json(mesh.info, {mesh.triangle_patches, mesh.quadrilateral_patches})}},
      notes);
}

std::string renaming_json(const RenamedMesh& made, const CommandNotes& notes) {
  Json json = {{"renamed", Json::array()}};
  for (const PatchRenaming& renaming : made.renamings) {
    json["renamed"].push_back({{"from", renaming.patch}, {"to", renaming.name}});
    if (renaming.kind) json["renamed"].back()["kind"] = renaming.kind->word();
  }
  json["patches"] =
      faces_by_patch_json(made.mesh.info, {made.mesh.triangle_patches, made.mesh.quadrilateral_patches});
  return with_notes(std::move(json), notes);
}

std::string check_json(const std::string& path, const CheckReport& report) {
  Json all = {{"file", path},
              {"kind", report.what},
              {"size", report.size},
              {"fit", report.is_fit()},
              {"findings", Json::array()}};
  for (const Finding& finding : report.findings) {
    Json places = Json::array();
    for (const Vec3& p : finding.places_mm) places.push_back(place(p));
    Json voxels = Json::array();
    for (const Index3& v : finding.voxels) voxels.push_back({v.x(), v.y(), v.z()});
    all["findings"].push_back({{"kind", finding.kind},
                               {"severity", finding.severity == Severity::kFault ? "fault" : "remark"},
                               {"count", finding.count},
                               {"text", finding.text},
                               {"remedy", finding.remedy},
                               {"places_mm", std::move(places)}});
    if (!voxels.empty()) all["findings"].back()["voxels"] = std::move(voxels);
  }
  return all.dump(2);
}

std::string repair_json(const RepairOutcome& outcome, const CommandNotes& notes) {
  const surfaces::RepairReport& r = outcome.report;
  const Json json = {{"method", outcome.was_rebuilt ? "rebuild" : "local"},
                     {"local_failure", outcome.local_failure},
                     {"max_distance_mm", outcome.max_distance_mm},
                     {"moved_mm", r.moved.distance_mm},
                     {"moved_at_mm", place(r.moved.place_mm)},
                     {"given_components", outcome.given_components},
                     {"components", r.components},
                     {"openings", r.openings},
                     {"seam_vertices", r.seam_vertices},
                     {"shared_triangles", r.shared_triangles},
                     {"duplicate_triangles", r.duplicate_triangles},
                     {"loose_triangles", r.loose_triangles},
                     {"stray_pieces", r.stray_pieces},
                     {"stray_area_mm2", r.stray_area_mm2},
                     {"stray_at_mm", place(r.stray_mm)},
                     {"dropped_components", r.dropped_parts},
                     {"dropped_triangles", r.dropped_triangles},
                     {"singular_edges", r.singular_edges},
                     {"singular_points", r.singular_points},
                     {"turned_triangles", r.turned_triangles},
                     {"flipped_edges", r.flipped_edges},
                     {"holes", r.holes},
                     {"widest_hole_mm", r.widest_hole_mm},
                     {"moved_vertices", r.moved_vertices},
                     {"far_vertices", r.far_vertices},
                     {"put_back_mm", r.put_back.distance_mm},
                     {"put_back_at_mm", place(r.put_back.place_mm)},
                     {"rounds", r.rounds},
                     {"removed_triangles", r.removed_triangles},
                     {"cut_triangles", r.cut_triangles},
                     {"inner_triangles", r.inner_triangles},
                     {"inner_openings", r.inner_openings},
                     {"new_triangles", r.new_triangles},
                     {"grid_spacing_mm", outcome.spacing_mm}};
  return with_notes(json, notes);
}

std::string merge_json(const MergeReport& report, const std::vector<std::string>& paths,
                       const CommandNotes& notes) {
  Json json = {{"shared_faces", report.shared_faces}, {"shared_points", report.shared_points},
               {"shared_area", report.shared_area},   {"tolerance", report.tolerance},
               {"farthest", report.farthest},         {"renumbered", nlohmann::json::array()}};
  for (const MergeReport::Renumbered& label : report.renumbered)
    json["renumbered"].push_back(
        {{"file", paths[label.part]}, {"from", label.from}, {"to", label.to}, {"name", label.name}});
  return with_notes(std::move(json), notes);
}

}  // namespace lumesh::report
