#include <fmt/core.h>
#include <fmt/ranges.h>

#include <set>

#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/image/crossings.hpp"
#include "lumesh/image/selection.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/io/sha256.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/surface_input.hpp"
#include "lumesh/stages/vessel_ends.hpp"
#include "stages.hpp"

namespace lumesh::pipeline {
namespace {

void make_phantom(CaseState& state) {
  PhantomSpec spec = state.c.input.phantom_spec;
  spec.kind = phantom_kind_from_name(state.c.input.phantom);
  try {
    state.phantom.emplace(spec);
  } catch (const Error& error) {
    throw Error(ErrorKind::kBadInput, std::string("[input] ") + error.what());
  }
  state.given.name = "phantom " + state.c.input.phantom;
  state.input_sha256 = text_sha256(to_json_text(state.phantom->spec()));
  state.given.image = state.context.phase("voxels", [&] { return state.phantom->rasterise(); });
  const ImageSelection& selection = state.c.input.selection;
  if (!selection.labels.empty()) {
    const std::vector<Label>& there = state.given.image->values();
    const std::set<Label> wanted = labels_called(selection.labels, {there.begin() + 1, there.end()}, {});
    select_labels(*state.given.image, std::vector<Label>(wanted.begin(), wanted.end()));
  }
  edit_image(selection, state.context, *state.given.image);
}

void describe_image(const LabelImage& image, report::StageReport& stage) {
  const ImageFrame& frame = image.frame();
  const Vec3& spacing = frame.spacing_mm;
  stage.figures.push_back(
      {"Voxels", fmt::format("{} x {} x {}", frame.size.x(), frame.size.y(), frame.size.z())});
  stage.figures.push_back(
      {"Voxel size", fmt::format("{:g} x {:g} x {:g}", spacing.x(), spacing.y(), spacing.z()), "mm"});
  const std::vector<LabelTopology> labels = label_topology(image);
  for (const LabelTopology& label : labels)
    stage.figures.push_back({fmt::format("Label {}", label.label), label.volume_mm3, "mm3",
                             fmt::format("{} voxels, {} pieces, Euler number {}", label.voxel_count,
                                         label.component_count, label.euler_number)});
  if (!image.crossings().empty()) {
    const CrossingCounts counts = count_crossings(image);
    stage.figures.push_back(
        {"Boundary placed by values",
         100.0 * static_cast<double>(counts.crossed) / static_cast<double>(counts.faces), "%",
         fmt::format("{} of {} voxel faces of the object", counts.crossed, counts.faces)});
  }
  if (labels.empty())
    throw Error(ErrorKind::kBadInput, "has no voxel that is not background; check labels and threshold");
}

void extend_image(CaseState& state, report::StageReport& stage) {
  static_cast<void>(state.given.domain_of_image());
  const LabelImage& image = *state.given.image;
  const std::vector<double> voxels = count_kept_voxels(image, state.given.cut_planes);
  for (std::size_t i = 1; i < voxels.size(); ++i)
    if (voxels[i] > 0)
      stage.figures.push_back({fmt::format("Label {} with extensions", image.values()[i]),
                               voxels[i] * image.frame().voxel_volume_mm3(), "mm3"});
}

void describe_surface(CaseState& state, report::StageReport& stage) {
  const SurfaceInput& given = *state.given.surface;
  const bool is_as_read = given.closed.empty() && state.c.input.cuts.none();
  stage.figures.push_back({is_as_read ? "Triangles" : "Triangles, once closed, cut and extended",
                           std::uint64_t{given.mesh.triangles.size()}});
  state.given.look_at_surface();
  if (given.closed.empty()) return;
  const std::vector<std::string> lines = closing_lines(given.closed);
  for (const std::string& line : lines) state.context.info(line);
  stage.figures.push_back(
      {"Closed", std::uint64_t{given.closed.size()}, "", fmt::format("{}", fmt::join(lines, "; "))});
}

/// Where no vessel has an opening, the mesh's stage says so.
void warn_of_dead_ends(CaseState& state, report::StageReport& stage) {
  if (!state.given.image || state.given.openings().empty()) return;
  const double voxel_mm = state.given.image->frame().spacing_mm.maxCoeff();
  std::vector<VesselEnd> ends = vessel_ends(state.centerline, voxel_mm, state.given.openings());
  try_cuts(*state.given.image, state.centerline, state.given.cut_planes, 1, ends);
  if (!ends.empty()) stage.warnings.push_back(dead_end_warning(ends));
}

}  // namespace

void read_input(CaseState& state, report::StageReport& stage) {
  stage.what = "What is meshed: the voxels that belong to the vessel, or its surface.";
  if (state.c.input.phantom.empty()) {
    state.given.read();
    state.input_sha256 = state.context.phase("hash", [&] { return file_sha256(state.given.name); });
  } else {
    make_phantom(state);
  }
  stage.figures.push_back({"Input", state.given.name});
  if (state.given.image) {
    state.given.cut_image();
    if (state.c.mesher == Mesher::kLattice)
      naming(state.given.name, [&] { state.c.lattice_options().require_labels_of(*state.given.image); });
    naming(state.given.name, [&] { describe_image(*state.given.image, stage); });
    if (state.c.input.cuts.extension.is_wanted()) extend_image(state, stage);
  }
  // Also where the mesh comes from a checkpoint: frames behind it get the names of its openings.
  if (state.given.image && state.c.input.selection.openings_of_frames)
    static_cast<void>(state.given.domain_of_image());
  read_sources(state);
  check_layers(state);
  if (state.given.surface) describe_surface(state, stage);
}

void make_centerline(CaseState& state, report::StageReport& stage) {
  stage.what = "The axes of the vessels, from opening to opening, with the radius of the vessel along them.";
  state.centerline = state.given.axes(state.c.centerline.options);
  check_centerline_points(state);
  warn_of_dead_ends(state, stage);
  stage.figures.push_back({"Lines", std::uint64_t{state.centerline.lines.size()}});
  stage.figures.push_back({"Points", std::uint64_t{state.centerline.points.size()}});
  stage.figures.push_back({"Length", length_mm(state.centerline), "mm"});
}

}  // namespace lumesh::pipeline
