#include "lumesh/quality/evaluation.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/quality/curvature.hpp"
#include "lumesh/quality/hausdorff.hpp"
#include "lumesh/quality/metric_statistics.hpp"
#include "lumesh/quality/reference.hpp"
#include "lumesh/quality/sections.hpp"
#include "lumesh/quality/statistics.hpp"
#include "lumesh/quality/topology_places.hpp"
#include "lumesh/quality/voxels_kept.hpp"
#include "validity.hpp"

namespace lumesh::quality {

double LabelEvaluation::image_volume_error_percent() const {
  return image && image->volume_mm3 > 0 ? 100 * (volume_mm3 / image->volume_mm3 - 1) : 0;
}

double LabelEvaluation::reference_volume_error_percent() const {
  return reference ? 100 * (volume_mm3 / reference->volume_mm3 - 1) : 0;
}

std::optional<std::int64_t> LabelEvaluation::cavities() const {
  if (!surface.manifold()) return std::nullopt;
  // Each component has one outer surface, and one more for each of its hollows.
  return static_cast<std::int64_t>(surface.components.size()) - static_cast<std::int64_t>(components);
}

std::optional<std::int64_t> LabelEvaluation::handles() const {
  if (!surface.manifold()) return std::nullopt;
  return static_cast<std::int64_t>(surface.components.size()) - euler;
}

double Evaluation::volume_mm3() const {
  double sum = 0;
  for (const LabelEvaluation& label : labels) sum += label.volume_mm3;
  return sum;
}

double Evaluation::image_volume_error_percent() const {
  return image && image->all.volume_mm3 > 0 ? 100 * (volume_mm3() / image->all.volume_mm3 - 1) : 0;
}

namespace {

/// The entry of a label, made if it is not there.
LabelEvaluation& entry(Evaluation& evaluation, Label label) {
  auto& labels = evaluation.labels;
  auto at = std::ranges::lower_bound(labels, label, {}, &LabelEvaluation::label);
  if (at == labels.end() || at->label != label) {
    at = labels.insert(at, LabelEvaluation());
    at->label = label;
    const auto name = evaluation.info.label_names.find(label);
    if (name != evaluation.info.label_names.end()) at->name = name->second;
  }
  return *at;
}

void add_topology(const MeshView& mesh, const TetMesh* kernel, const MeshSurface& surface,
                  Evaluation& evaluation) {
  evaluation.boundary = analyse_surface(mesh.points, surface.outer());
  const std::vector<SolidTopology> solids =
      kernel != nullptr ? analyse_solids(*kernel, evaluation.boundary) : analyse_solids(mesh);
  evaluation.components = solids.back().components;
  evaluation.euler = solids.back().euler;
  for (std::size_t i = 0; i + 1 < solids.size(); ++i) {
    LabelEvaluation& label = entry(evaluation, solids[i].label);
    label.components = solids[i].components;
    label.euler = solids[i].euler;
    label.surface = analyse_surface(mesh.points, surface.around(label.label));
  }
  evaluation.interface_triangles = surface.triangles.size() - evaluation.boundary.triangles;
  evaluation.patches = summarise_patches(mesh, surface);
}

void add_metric(const MeshView& mesh, Evaluation& evaluation, Context& context) {
  if (mesh.metric.empty() || mesh.tetrahedra.empty()) return;
  evaluation.has_metric = true;
  context.phase("lengths and shapes in the metric", [&] {
    try {
      evaluation.metric = measure_in_metric(mesh);
    } catch (const Error& bad_metric) {  // What else is said of the mesh holds all the same.
      evaluation.warnings.push_back(std::string(bad_metric.what()) +
                                    "; what is measured in the metric is left out");
      context.warn(evaluation.warnings.back());
    }
  });
}

/// Volumes of the image become those of its kept part.
void cut_volumes(const EvaluationInput& input, Evaluation& evaluation) {
  const std::vector<double> kept = count_kept_voxels(*input.image, input.cut_planes);
  double all = 0;
  for (std::size_t i = 1; i < kept.size(); ++i) {
    const double volume_mm3 = kept[i] * input.image->frame().voxel_volume_mm3();
    LabelEvaluation& label = entry(evaluation, input.image->values()[i]);
    if (label.image) label.image->volume_mm3 = volume_mm3;
    all += volume_mm3;
  }
  evaluation.image->all.volume_mm3 = all;
}

/// Appends what differs, as "components 1 (image 2)".
template <class Value, class OfImage>
void add_difference(const char* what, const Value& found, const OfImage& of_image, std::string& words) {
  if (std::cmp_equal(found, of_image)) return;
  words += std::string(words.empty() ? "" : ", ") + what + " " + std::to_string(found) + " (image " +
           std::to_string(of_image) + ")";
}

/// What a label's cells have more than its voxels; of handles and cavities none where they cannot be counted.
TopologyDifference difference_of(const LabelEvaluation& label) {
  TopologyDifference more{.label = label.label};
  more.components =
      static_cast<std::int64_t>(label.components) - static_cast<std::int64_t>(label.image->component_count);
  if (const auto cavities = label.cavities())
    more.cavities = *cavities - static_cast<std::int64_t>(label.image->cavity_count);
  if (const auto handles = label.handles()) more.handles = *handles - label.image->handle_count();
  more.euler = label.euler - label.image->euler_number;
  return more;
}

std::vector<TopologyDifference> list_topology_differences(Evaluation& evaluation) {
  std::vector<TopologyDifference> differences;
  for (const LabelEvaluation& label : evaluation.labels) {
    if (!label.image || label.lost()) continue;
    std::string words;
    add_difference("components", label.components, label.image->component_count, words);
    if (const auto cavities = label.cavities())
      add_difference("cavities", *cavities, label.image->cavity_count, words);
    if (const auto handles = label.handles())
      add_difference("handles", *handles, label.image->handle_count(), words);
    if (words.empty()) add_difference("Euler number", label.euler, label.image->euler_number, words);
    if (words.empty()) continue;
    evaluation.topology_differences.push_back("label " + std::to_string(label.label) + ": " + words);
    differences.push_back(difference_of(label));
  }
  return differences;
}

/// The farthest voxel by its number in another frame; by none beyond that.
void number_in(const ImageFrame& frame, KeptVoxels& kept) {
  if (!kept.worst) return;
  const Index3 voxel = frame.to_index(kept.worst->centre_mm).array().round().cast<int>().matrix();
  kept.worst->voxel = frame.contains(voxel) ? std::optional(voxel) : std::nullopt;
}

void add_voxels_kept(const MeshView& mesh, const MeshSurface& surface, const EvaluationInput& input,
                     Evaluation& evaluation) {
  VoxelsKept kept = count_voxels_kept(mesh, surface, *input.image, input.cut_planes);
  if (input.given_frame != nullptr) {
    for (LabelKeptVoxels& label : kept.labels) number_in(*input.given_frame, label.voxels);
    number_in(*input.given_frame, kept.background);
    number_in(*input.given_frame, kept.all);
  }
  for (LabelKeptVoxels& label : kept.labels) entry(evaluation, label.label).voxels_kept = label.voxels;
  evaluation.image->background_kept = kept.background;
  evaluation.image->voxels_kept = kept.all;
}

/// One line for all branches whose narrowest section is tightened, or widened.
std::string sections_warning(std::span<const NarrowestSection> sections,
                             bool (NarrowestSection::*is_so)() const, double percent, const char* what) {
  const NarrowestSection* worst = nullptr;
  std::size_t count = 0;
  for (const NarrowestSection& section : sections) {
    if (!(section.*is_so)()) continue;
    ++count;
    if (!worst || std::abs(section.change_percent()) > std::abs(worst->change_percent())) worst = &section;
  }
  if (!worst) return "";
  return fmt::format(
      "{} of {} branches {} more than {:g} % {} in the mesh than in the voxels; branch {} by {:.1f} %: "
      "{:.4g} of {:.4g} mm² at {}",
      count, sections.size(), count == 1 ? "is" : "are", percent, what, worst->branch,
      std::abs(worst->change_percent()), worst->mesh_area_mm2, worst->voxel_area_mm2,
      place_text(worst->centre_mm));
}

void add_sections(const MeshView& mesh, const MeshSurface& surface, const EvaluationInput& input,
                  Evaluation& evaluation, Context& context) {
  evaluation.sections = context.phase("narrowest sections", [&] {
    return find_narrowest_sections(mesh, surface, *input.image, *input.axes, input.cut_planes);
  });
  using Section = NarrowestSection;
  for (const std::string& warning :
       {sections_warning(*evaluation.sections, &Section::tightened, kTightenedPercent, "narrower"),
        sections_warning(*evaluation.sections, &Section::widened, kWidenedPercent, "wider")}) {
    if (warning.empty()) continue;
    evaluation.warnings.push_back(warning);
    context.warn(warning);
  }
}

void add_openings(const MeshView& mesh, const EvaluationInput& input, Evaluation& evaluation,
                  Context& context) {
  const auto& patches = mesh.info->patches;
  const bool has_any =
      std::ranges::any_of(patches, [](const Patch& patch) { return patch.kind == PatchKind::kOpening; });
  // A mesh of another program may not say which patches are openings.
  if (!has_any && (patches.empty() || mesh.info->provenance.empty())) return;
  evaluation.openings = context.phase("openings", [&] {
    std::optional<ImageDomain> made;
    if (input.domain == nullptr) made.emplace(*input.image, ImageDomainOptions{{}, input.cut_planes});
    const ImageDomain& domain = input.domain != nullptr ? *input.domain : *made;
    return compare_openings(mesh, find_openings(domain));
  });
  for (const std::string& doubt : doubts_about(*evaluation.openings)) {
    evaluation.warnings.push_back(doubt);
    context.warn(doubt);
  }
}

void add_image(const MeshView& mesh, const MeshSurface& surface, const EvaluationInput& input,
               Evaluation& evaluation, Context& context) {
  const LabelImage& image = *input.image;
  context.phase("voxel topology", [&] {
    for (const LabelTopology& voxels : label_topology(image)) entry(evaluation, voxels.label).image = voxels;
  });
  ImageEvaluation& result = evaluation.image.emplace();
  result.frame = input.given_frame != nullptr ? *input.given_frame : image.frame();
  result.all = context.phase("voxel topology of the union", [&] { return union_topology(image); });
  if (!input.cut_planes.empty())
    context.phase("voxels that the cuts keep", [&] { cut_volumes(input, evaluation); });
  ImageDistances distances = context.phase(
      "distances to the image", [&] { return compare_with_image(mesh, surface, image, input.cut_planes); });
  result.voxel_size_mm = distances.voxel_size_mm;
  result.distances = distances.outer;
  for (const LabelDistances& label : distances.labels)
    entry(evaluation, label.label).distances = label.distances;
  context.phase("voxels kept", [&] { add_voxels_kept(mesh, surface, input, evaluation); });
  add_openings(mesh, input, evaluation, context);
  if (input.axes) add_sections(mesh, surface, input, evaluation, context);
  if (!input.cut_planes.empty()) return;
  const std::vector<TopologyDifference> differences = list_topology_differences(evaluation);
  if (!differences.empty())
    evaluation.topology_places = context.phase(
        "places of other topology", [&] { return find_topology_places(mesh, image, differences); });
}

void add_statistics(const MeshView& mesh, Evaluation& evaluation, Context& context) {
  evaluation.statistics = context.phase("statistics", [&] { return measure(mesh); });
  for (const LabelVolume& volume : evaluation.statistics.labels) {
    LabelEvaluation& label = entry(evaluation, volume.label);
    label.cells = volume.cells;
    label.volume_mm3 = volume.volume_mm3;
  }
}

void add_phantom(const MeshView& mesh, const MeshSurface& surface, const EvaluationInput& input,
                 Evaluation& evaluation, Context& context) {
  evaluation.reference_voxel_mm = std::cbrt(input.phantom->frame().voxel_volume_mm3());
  context.phase("distances to the phantom", [&] {
    for (const LabelReference& label : compare_with_phantom(mesh, surface, *input.phantom, input.cut_planes))
      entry(evaluation, label.label).reference = label;
  });
}

}  // namespace

Evaluation evaluate(const MeshView& mesh, const EvaluationInput& input, Context& context) {
  if (mesh.cell_count() == 0)
    throw Error(ErrorKind::kBadInput,
                "the mesh has no volume cells; evaluate takes tetrahedra and mixed meshes");
  Evaluation evaluation;
  evaluation.info = *mesh.info;
  evaluation.cut_planes = input.cut_planes.size();
  add_statistics(mesh, evaluation, context);
  add_metric(mesh, evaluation, context);
  const MeshSurface surface = context.phase("surface", [&] {
    return input.kernel != nullptr ? extract_surface(*input.kernel) : extract_surface(mesh);
  });
  context.phase("topology", [&] { add_topology(mesh, input.kernel, surface, evaluation); });
  context.phase("validity", [&] { find_problems(mesh, input.kernel, surface, evaluation); });
  evaluation.curvature = context.phase("curvature", [&] { return summarise(wall_curvature(mesh, surface)); });
  if (input.image) add_image(mesh, surface, input, evaluation, context);
  if (input.phantom) add_phantom(mesh, surface, input, evaluation, context);
  return evaluation;
}

}  // namespace lumesh::quality
