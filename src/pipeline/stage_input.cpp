#include <fmt/core.h>

#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/image/crossings.hpp"
#include "lumesh/image/selection.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/io/sha256.hpp"
#include "lumesh/stages/input_parts.hpp"
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
  state.input_name = "phantom " + state.c.input.phantom;
  state.input_sha256 = text_sha256(to_json_text(state.phantom->spec()));
  state.image = state.context.phase("voxels", [&] { return state.phantom->rasterise(); });
  const ImageSelection& selection = state.c.input.selection;
  if (!selection.labels.empty()) select_labels(*state.image, selection.labels);
  edit_image(selection, state.context, *state.image);
}

void read_file(CaseState& state) {
  const InputKeys& input = state.c.input;
  state.input_name = input.image.empty() ? input.surface : input.image;
  if (input.image.empty()) {
    state.surface = state.context.phase("read", [&] {
      return read_surface(input.surface, input.selection.unit, input.of_surface, input.cuts, state.context);
    });
  } else {
    state.image = state.context.phase(
        "read", [&] { return read_selected_image(input.image, input.selection, state.context); });
  }
  state.input_sha256 = state.context.phase("hash", [&] { return file_sha256(state.input_name); });
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

void describe_surface(CaseState& state, report::StageReport& stage) {
  stage.figures.push_back({"Triangles", std::uint64_t{state.surface->mesh.triangles.size()}});
  warn_of_unit(state.surface->mesh, state.openings(), state.c.input.selection.unit, state.input_name,
               state.context);
  if (state.surface->closed.empty()) return;
  name_closed(state.surface->closed, state.domain().flat_ends());
  std::size_t number = 0;
  for (const std::string& line : closing_lines(state.surface->closed)) {
    state.context.info(line);
    stage.figures.push_back({fmt::format("Closed {}", ++number), line});
  }
}

/// Where no vessel has an opening, the mesh's stage says so.
void warn_of_dead_ends(CaseState& state, report::StageReport& stage) {
  if (!state.image || state.openings().empty()) return;
  const double voxel_mm = state.image->frame().spacing_mm.maxCoeff();
  std::vector<VesselEnd> ends = vessel_ends(state.centerline, voxel_mm, state.openings());
  try_cuts(*state.image, state.centerline, state.cut_planes, 1, ends);
  if (!ends.empty()) stage.warnings.push_back(dead_end_warning(ends));
}

}  // namespace

void read_input(CaseState& state, report::StageReport& stage) {
  stage.what = "What is meshed: the voxels that belong to the vessel, or its surface.";
  if (state.c.input.phantom.empty())
    read_file(state);
  else
    make_phantom(state);
  stage.figures.push_back({"Input", state.input_name});
  naming(state.input_name, [&] {
    if (!state.image) return;
    state.cut_planes =
        state.context.phase("cuts", [&] { return cut_off(*state.image, state.c.input.cuts, state.context); });
    if (state.c.mesher == Mesher::kLattice) state.c.lattice_options().require_labels_of(*state.image);
    if (state.c.input.cuts.extension.is_wanted())
      state.image_domain = domain_of_cut(*state.image, state.cut_planes, state.c.input.cuts,
                                         state.c.input.field, state.context);
    describe_image(*state.image, stage);
  });
  read_sources(state);
  check_layers(state);
  if (state.surface) describe_surface(state, stage);
}

void make_centerline(CaseState& state, report::StageReport& stage) {
  stage.what = "The axes of the vessels, from opening to opening, with the radius of the vessel along them.";
  const CenterlineOptions& options = state.c.centerline.options;
  state.centerline = naming(state.input_name, [&] {
    return state.image ? extract_centerline(*state.image, options, state.context)
                       : extract_centerline(state.surface->mesh.view(), options, state.context);
  });
  check_centerline_points(state);
  warn_of_dead_ends(state, stage);
  stage.figures.push_back({"Lines", std::uint64_t{state.centerline.lines.size()}});
  stage.figures.push_back({"Points", std::uint64_t{state.centerline.points.size()}});
  stage.figures.push_back({"Length", length_mm(state.centerline), "mm"});
}

}  // namespace lumesh::pipeline
