#include "case_sections.hpp"

#include <fmt/core.h>

#include "case_stage.hpp"
#include "lumesh/domain/usual_edge.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/run_options.hpp"

namespace lumesh {

void InputKeys::describe(OptionList& list) {
  list.path("image", image, "Label image").of_files(FileUse::kReadImage);
  list.path("surface", surface, "Or a surface, open ends are capped").of_files(FileUse::kRead);
  list.text("phantom", phantom, "Or a synthetic image: carotid, bifurcation, layered, sphere, torus");
  phantom_spec.describe_image(list, "phantom_");
  selection.describe(list);
  describe_unit(list, selection.unit);
  cuts.describe(list);
  field.describe(list);
  of_surface.describe(list);
}

void CenterlineKeys::describe(OptionList& list) {
  list.flag("make", is_wanted, "Make the centerline even if no stage needs it");
  options.describe(list);
}

void OpeningKeys::describe(OptionList& list) {
  describe_names(list, names);
}

void OutputKeys::describe(OptionList& list) {
  list.path("folder", folder, "Where all files go; none: a folder of the case's name");
  list.texts("meshes", meshes, "The last mesh, in the format of each name").of_files(FileUse::kWriteVolume);
  list.text("surface", surface, "The outer boundary of the last mesh, closed; none: not written")
      .of_files(FileUse::kWriteSurface);
  describe_out_unit(list, unit);
  describe_report(list, report);
  list.text("json", json, "All numbers (.json); none: not written");
  list.flag("stages", stages,
            "Write the centerline, and where a metric adapts the mesh, the first one with its metric");
}

void RunKeys::describe(OptionList& list) {
  describe_threads(list, threads);
  describe_time_limit(list, time_limit_s);
  list.flag("checkpoints", checkpoints, "Keep what every stage leaves, for `lumesh run --resume`");
}

std::vector<CaseSection> sections_of(Case& c) {
  std::vector<CaseSection> sections(1);
  OptionList& first = sections.front().options;
  first.choice("mesher", c.mesher, {{"lattice", Mesher::kLattice}, {"delaunay", Mesher::kDelaunay}},
               "What makes the first mesh; delaunay also of surfaces and with sizes");
  first.number("edge_length", c.edge_length_mm, above(0), "Edges on surfaces of the first mesh")
      .in("mm")
      .zero(usual_edge_text());
  describe_cells_per_diameter(first, c.cells_per_diameter);
  const auto add = [&](std::string name, std::string meaning, auto& described) {
    sections.push_back({std::move(name), std::move(meaning), options_of(described)});
  };
  add("input", "What is meshed: one of image, surface, phantom", c.input);
  add("lattice", "The first mesh, with mesher = \"lattice\"", c.lattice);
  add("delaunay", "The first mesh, with mesher = \"delaunay\"", c.delaunay);
  add("centerline", "Axes of the vessels with their radii", c.centerline);
  add("metric", "Sizes and directions of the elements; without a source the first mesh is the last",
      c.metric);
  add("adapt", "Adaptation of the first mesh to the metric", c.adapt);
  add("layers", "Boundary layers of the last mesh; without first_height there are none", c.layers);
  add("openings", "Names of patches in the files", c.openings);
  add("output", "Files", c.output);
  add("run", "How it runs", c.run);
  return sections;
}

LatticeOptions Case::lattice_options() const {
  LatticeOptions options = lattice;
  if (!(options.spacing_mm > 0)) options.spacing_mm = edge_length_mm;
  options.cells_per_diameter = cells_per_diameter;
  return options;
}

DelaunayRequest Case::delaunay_request() const {
  DelaunayRequest request = delaunay;
  if (!(request.delaunay.edge_length_mm > 0)) request.delaunay.edge_length_mm = edge_length_mm;
  request.sizes.cells_per_diameter = cells_per_diameter;
  request.improvement.execution = adapt.adapt.execution;
  request.improvement.team = adapt.adapt.team;
  return request;
}

bool Case::needs_centerline() const {
  return centerline.is_wanted || metric.source<metric::PointSource>().points == "centerline" ||
         (mesher == Mesher::kDelaunay && delaunay_request().sizes.needs_axes());
}

std::string Case::with_keys(const std::string& message) const {
  return pipeline::with_case_keys(message, pipeline::sections_of(pipeline::CaseStage::kMesh, mesher),
                                  pipeline::size_key_of(*this));
}

namespace pipeline {

std::string key_called(std::string_view option, const std::vector<std::string>& sections) {
  Case any;
  const std::vector<CaseSection> all = sections_of(any);
  const auto rank = [&](const CaseSection& s) { return std::ranges::find(sections, s.name); };
  const CaseSection* best = nullptr;
  std::string name;
  for (const CaseSection& section : all)
    for (const Option& key : section.options.all())
      if (key.is_called(option) && (best == nullptr || rank(section) < rank(*best))) {
        best = &section;
        name = key.name;
      }
  return best == nullptr || best->name.empty() ? name : "[" + best->name + "] " + name;
}

std::vector<CaseFileRead> files_read_by(const Case& c) {
  Case copy = c;
  std::vector<CaseFileRead> files;
  for (const CaseSection& section : sections_of(copy))
    for (const Option& key : section.options.all()) {
      const auto* const file = std::get_if<OptionPath>(&key.target);
      if (file == nullptr || file->path == &copy.output.folder || file->path->empty() ||
          std::ranges::find(file->words, *file->path) != file->words.end())
        continue;
      const bool is_plugin = file->path == &copy.delaunay.sizes.plugin;
      files.push_back({fmt::format("[{}] {}", section.name, key.name),
                       is_plugin ? copy.delaunay.sizes.plugin_path() : *file->path});
    }
  return files;
}

std::string size_key_of(const Case& c) {
  const bool is_lattice = c.mesher == Mesher::kLattice;
  if (is_lattice && c.lattice.spacing_mm > 0) return "[lattice] edge_length";
  if (!is_lattice && c.delaunay.delaunay.delta_mm > 0) return "[delaunay] delta";
  if (!is_lattice && c.delaunay.delaunay.edge_length_mm > 0) return "[delaunay] edge_length";
  return "edge_length";
}

std::string with_case_keys(const std::string& message, const std::vector<std::string>& sections,
                           const std::string& size_key) {
  return with_spelled_options(message, [&](std::string_view name) {
    const bool is_size = name == "edge_length" || name == "delta" || name == "spacing";
    return is_size && !size_key.empty() ? size_key : key_called(name, sections);
  });
}

}  // namespace pipeline
}  // namespace lumesh
