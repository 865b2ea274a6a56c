#include "outputs.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "case_sections.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/version.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/new_folder.hpp"
#include "lumesh/io/output_checks.hpp"
#include "lumesh/io/polylines_file.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/mesh/length_unit.hpp"
#include "lumesh/quality/faults.hpp"
#include "lumesh/report/command_notes.hpp"
#include "lumesh/report/drawing.hpp"
#include "lumesh/report/layers_report.hpp"
#include "lumesh/report/stage_parts.hpp"
#include "lumesh/stages/evaluation_stage.hpp"
#include "lumesh/stages/mesh_output.hpp"

namespace lumesh::pipeline {
namespace {

constexpr const char* kEffectiveCase = "effective.toml";
constexpr const char* kCenterlineFile = "centerline.vtp";
constexpr const char* kFirstFile = "first.vtu";
constexpr const char* kPartial = "partial";

/// For another run: where it writes, and how long it may take, is its own matter.
std::string text_of_case(const CaseState& state) {
  Case again = state.c;
  again.output.folder.clear();
  again.run = {};
  return fmt::format(
      "# lumesh {}: the case {}: all settings used, without [run] and the output folder\n# input {}\n# "
      "SHA-256 {}\n\n{}",
      kVersion, state.c.name, state.given.name, state.input_sha256, case_text(again));
}

/// The mesh with its patches under the names that the user gives: the stages go by their own.
struct NamedMesh {
  explicit NamedMesh(const CaseState& state)
      : faces(state.boundary_faces()), info(state.mesh_info()), view(state.view(faces)) {
    static_cast<void>(rename_found(info, state.renamings));  // What is missing is said of the last mesh.
    view.info = &info;
  }
  NamedMesh(const NamedMesh&) = delete;
  NamedMesh& operator=(const NamedMesh&) = delete;

  BoundaryFaces faces;
  MeshInfo info;
  MeshView view;
};

}  // namespace

std::vector<std::string> names_of_files(const Case& c) {
  std::vector<std::string> names = c.output.meshes;
  for (const std::string& name :
       {c.output.surface, c.output.report, c.output.json, std::string(kEffectiveCase)})
    if (!name.empty()) names.push_back(name);
  if (c.output.stages && c.needs_centerline()) names.emplace_back(kCenterlineFile);
  if (c.output.stages && c.metric.has_source()) names.emplace_back(kFirstFile);
  return names;
}

void describe_mesh(const CaseState& state, report::StageReport& stage) {
  const NamedMesh mesh(state);
  quality::EvaluationInput input =
      evaluation_input(state.given.image ? &*state.given.image : nullptr, state.given.image_domain(),
                       state.phantom ? &*state.phantom : nullptr, state.c.input.cuts, state.given.cut_planes,
                       state.centerline);
  if (state.given.image) input.given_frame = &state.given.given_frame;
  input.kernel = state.mixed ? nullptr : &state.mesh;
  stage.evaluation =
      state.context.phase("measures", [&] { return quality::evaluate(mesh.view, input, state.context); });
  if (!state.c.output.report.empty())
    stage.pictures = state.context.phase("pictures", [&] { return report::draw_stage_pictures(mesh.view); });
}

void describe_layers(const CaseState& state, const std::optional<quality::Evaluation>& before,
                     report::StageReport& stage) {
  const MeshView view = state.mixed->view();
  stage.evaluation =
      state.context.phase("measures", [&] { return quality::evaluate(view, {}, state.context); });
  const double min_before_deg = before ? before->statistics.tetrahedra.smallest_dihedral_deg.value : 180;
  stage.layers = report::measure_layers(view, std::move(stage.layers->report), min_before_deg);
  stage.figures.push_back({"Smallest dihedral angle beside the layers",
                           stage.layers->core.tetrahedra.smallest_dihedral_deg.value, "°",
                           before ? fmt::format("before: {:.2f}", min_before_deg) : ""});
  if (const std::string flat = stage.layers->flat_cells_beside(); !flat.empty()) {
    state.context.warn(flat);
    stage.warnings.push_back(flat);
  }
  if (state.c.output.report.empty()) return;
  state.context.phase("pictures", [&] {
    stage.pictures = report::draw_stage_pictures(view);
    report::LayerPictures drawn = report::draw_layer_shares(stage.layers->report.surface);
    stage.pictures.push_back(report::captioned(
        std::move(drawn.front), "The share of the thickness wanted that the layers have on the surface."));
    stage.pictures.push_back(report::captioned(std::move(drawn.back), "The same from the opposite side."));
  });
}

report::NamedPicture picture_of_centerline(const CaseState& state) {
  const NamedMesh mesh(state);
  report::SurfacePicture drawn = state.context.phase("pictures", [&] {
    return report::draw_surface_with_lines(mesh.view, report::surface_for_pictures(mesh.view),
                                           state.centerline,
                                           {.scalar = "radius", .scalar_name = "radius, mm"});
  });
  return {"The centerline within the surface of the first mesh, coloured by the radius of the vessel.",
          std::move(drawn.picture), std::move(drawn.legend), std::move(drawn.scale)};
}

std::filesystem::path folder_of(const Case& c) {
  return c.output.folder.empty() ? std::filesystem::current_path() / c.name
                                 : std::filesystem::path(c.output.folder);
}

bool has_results(const Case& c) {
  const std::vector<std::string> names = names_of_files(c);
  return std::ranges::any_of(
      names, [&](const std::string& name) { return std::filesystem::exists(folder_of(c) / name); });
}

std::filesystem::path folder_of_results(const CaseState& state) {
  const std::filesystem::path folder = folder_of(state.c);
  return state.is_complete || !state.has_earlier_results ? folder : folder / kPartial;
}

void check_inputs(const Case& c) {
  for (const CaseFileRead& file : files_read_by(c))
    if (!std::filesystem::exists(file.path))
      throw Error(ErrorKind::kBadInput, fmt::format("{}: no such file; check {}", file.path, file.key));
}

namespace {

void make_folder(const std::filesystem::path& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed || !std::filesystem::is_directory(folder) || ::access(folder.c_str(), W_OK | X_OK) != 0)
    throw Error(ErrorKind::kBadInput,
                folder.string() + ": cannot be made or written to; set another [output] folder");
}

/// The folder of the case, or one in it that is put into its place by settle_stage_files(); made if need be.
std::filesystem::path folder_of_stage_files(const CaseState& state) {
  const std::filesystem::path folder =
      state.has_earlier_results ? folder_of(state.c) / kPartial : folder_of(state.c);
  make_folder(folder);
  return folder;
}

}  // namespace

void check_outputs(const Case& c) {
  check_inputs(c);
  const std::filesystem::path folder = folder_of(c);
  const io::NewFolder tried = naming(
      "[output] folder", [&] { return io::NewFolder(c.run.checkpoints ? folder / "checkpoints" : folder); });
  for (const std::filesystem::path& one : {folder, tried.path()}) make_folder(one);
  std::vector<std::string> outputs, inputs;
  for (const std::string& name : names_of_files(c)) outputs.push_back((folder / name).string());
  for (const CaseFileRead& file : files_read_by(c)) inputs.push_back(file.path);
  naming("[output]", [&] {
    io::check_output_folders(outputs, ErrorKind::kBadInput);
    io::check_inputs_stay(outputs, inputs, ErrorKind::kBadInput);
    std::erase(outputs, (folder / kEffectiveCase).string());  // Which may be the case that is run again.
    io::check_inputs_stay(outputs, {c.file}, ErrorKind::kBadInput);
  });
}

std::vector<report::OutputFile> write_meshes(const CaseState& state, const std::filesystem::path& folder) {
  const OutputKeys& output = state.c.output;
  make_folder(folder);
  const BoundaryFaces faces = state.boundary_faces();
  const MeshInUnit in_unit(state.view(faces), output.unit);
  const MeshView& view = in_unit.view();
  std::vector<report::OutputFile> files;
  for (const std::string& name : output.meshes) {
    state.context.phase("write", [&] { write_mesh(folder / name, view); });
    warn_of_names(folder / name, view, state.context);
    files.push_back({name, report::kMeshWords});
  }
  if (!output.surface.empty()) {
    state.context.phase("write", [&] { write_surface(folder / output.surface, view, state.context); });
    files.push_back({output.surface, "its boundary"});
  }
  write_text_file(folder / kEffectiveCase, text_of_case(state));
  files.push_back({kEffectiveCase, "the case with all settings used; `lumesh run` takes it"});
  return files;
}

std::vector<std::string> faults_of_written(const CaseState& state) {
  const BoundaryFaces faces = state.boundary_faces();
  const MeshView view = state.view(faces);
  return state.context.phase("validity", [&] { return quality::find_faults(view); });
}

void write_centerline(const CaseState& state, std::vector<report::OutputFile>& files) {
  if (!state.c.output.stages) return;
  write_polylines(folder_of_stage_files(state) / kCenterlineFile, state.centerline, state.info());
  files.push_back({kCenterlineFile, report::kCenterlineWords});
}

void write_first_mesh(const CaseState& state, std::vector<report::OutputFile>& files) {
  if (!state.c.output.stages) return;
  const NamedMesh mesh(state);
  write_mesh(folder_of_stage_files(state) / kFirstFile, MeshInUnit(mesh.view, state.c.output.unit).view());
  files.push_back({kFirstFile, state.has_metric ? "the first mesh with its metric" : "the first mesh"});
}

void settle_stage_files(const CaseState& state, const std::vector<report::OutputFile>& files) {
  if (!state.has_earlier_results || !state.is_complete) return;
  const std::filesystem::path folder = folder_of(state.c);
  for (const report::OutputFile& file : files) {
    std::error_code failed;
    std::filesystem::rename(folder / kPartial / file.path, folder / file.path, failed);
    if (failed)
      throw Error(ErrorKind::kBadInput, (folder / file.path).string() + ": cannot be replaced by that in " +
                                            kPartial + ": " + failed.message());
  }
  std::error_code is_in_use;
  if (!files.empty()) std::filesystem::remove(folder / kPartial, is_in_use);
}

void write_report(const Case& c, const std::filesystem::path& folder, const report::CaseReport& report) {
  if (!c.output.json.empty()) write_text_file(folder / c.output.json, report::case_report_json(report));
  if (!c.output.report.empty()) write_text_file(folder / c.output.report, report::case_report_html(report));
}

}  // namespace lumesh::pipeline
