#include <fmt/core.h>

#include <filesystem>
#include <set>

#include "case_keys.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "outputs.hpp"
#include "stages.hpp"

namespace lumesh::pipeline {
namespace {

[[noreturn]] void refuse(const std::string& what) {
  throw Error(ErrorKind::kBadInput, what);
}

void check_input(const Case& c) {
  const InputKeys& input = c.input;
  const int given =
      (input.image.empty() ? 0 : 1) + (input.surface.empty() ? 0 : 1) + (input.phantom.empty() ? 0 : 1);
  if (given != 1)
    refuse("[input] needs one of image, surface and phantom, not " + std::to_string(given) + " of them");
  if (!input.surface.empty() && c.mesher == Mesher::kLattice)
    refuse("the lattice mesher takes images; for [input] surface set mesher = \"delaunay\"");
  const ImageSelection& selection = input.selection;
  if (!input.surface.empty() && (!input.cuts.none() || !selection.takes_all()))
    refuse(
        "[input] labels, threshold, below, probabilities, largest_component, cut_planes and cut_at are for "
        "images; leave them out with surface");
  if (selection.threshold && selection.below)
    refuse("[input] threshold and below exclude each other; give one of them");
  if (selection.has_level() && !selection.probabilities.empty())
    refuse("[input] threshold or below and probabilities exclude each other; give one of them");
  if (input.phantom.empty()) return;
  if (selection.has_level() || !selection.probabilities.empty())
    refuse("[input] threshold, below and probabilities are for images; leave them out with phantom");
  try {
    static_cast<void>(phantom_kind_from_name(input.phantom));
  } catch (const Error& unknown) {
    refuse(std::string("[input] ") + unknown.what());
  }
}

/// What is set for the mesher that is not taken would be set for nothing.
void refuse_other_mesher(const Case& c) {
  const bool is_lattice = c.mesher == Mesher::kLattice;
  const std::string other = is_lattice ? "delaunay" : "lattice";
  if (section_text(c, other) != section_text(Case(), other))
    refuse(fmt::format(
        "[{0}] is for mesher = \"{0}\", and the mesher is {1}; set mesher or leave the section out", other,
        is_lattice ? "lattice" : "delaunay"));
}

void check_metric(const Case& c) {
  const MetricKeys& m = c.metric;
  if (m.largest_mm > 0 && m.smallest_mm > m.largest_mm)
    refuse(fmt::format("[metric] min_size {:g} is larger than max_size {:g}", m.smallest_mm, m.largest_mm));
  if (m.gradation != 0 && m.gradation <= 1)
    refuse(
        fmt::format("[metric] gradation must be greater than 1, such as 1.5, or 0; not {:g}", m.gradation));
  if (m.largest_aspect != 0 && m.largest_aspect < 1)
    refuse(fmt::format("[metric] max_aspect must be at least 1, or 0; not {:g}", m.largest_aspect));
  if (m.velocity == "phantom" && c.input.phantom.empty())
    refuse("[metric] velocity = \"phantom\" needs [input] phantom");
  if (m.complexity > 0 && !m.is_wanted())
    refuse("[metric] complexity has nothing to scale; give points, velocity or curvature");
}

void check_layer_keys(const Case& c) {
  const LayerOptions& o = c.layers.options;
  if (!c.layers.is_wanted()) {
    if (o.count > 0 || o.thickness > 0 || !o.patches.empty() || !c.layers.label.empty())
      refuse(
          "[layers] first_height is missing: the height of the layer next to the surface; without layers "
          "leave out count, thickness, patches and label, too");
    return;
  }
  try {
    static_cast<void>(layer_heights(o));
  } catch (const Error& contradiction) {
    refuse(std::string("[layers] ") + contradiction.what());
  }
  static_cast<void>(layer_options_of(c));
  if (o.cells == LayerCells::kTetrahedra) return;
  for (const std::string& name : c.output.meshes)
    if (!is_mixed_volume_file(name))
      refuse(fmt::format(
          "[output] meshes: {} holds tetrahedra only, not the prisms of [layers]; use .vtu, .vtk, "
          ".mesh, .meshb, .msh or .foam, or set [layers] cells = \"tetrahedra\"",
          name));
}

void check_output(const Case& c) {
  if (c.output.meshes.empty()) refuse("[output] meshes names no file; such as [\"mesh.vtu\"]");
  for (const std::string& name : c.output.meshes)
    if (!is_volume_file(name))
      refuse(
          fmt::format("[output] meshes: {} has an unknown format; use .vtu, .vtk, .mesh, .meshb, .msh, "
                      ".foam, .xdmf or NAME-mesh-complete",
                      name));
  std::set<std::filesystem::path> folders_of_foam;
  for (const std::filesystem::path name : c.output.meshes)
    if (name.extension() == ".foam" && !folders_of_foam.insert(name.parent_path()).second)
      refuse(
          fmt::format("[output] meshes: {} would replace the mesh of another .foam, since a folder has one "
                      "constant/polyMesh; name one of them",
                      name.string()));
  if (!c.output.surface.empty() && !is_surface_file(c.output.surface))
    refuse(fmt::format("[output] surface: {} has an unknown format; use .vtp or .stl", c.output.surface));
  if (!c.output.report.empty() && !c.output.report.ends_with(".html"))
    refuse(fmt::format("[output] report: {} must end in .html", c.output.report));
  if (!c.output.json.empty() && !c.output.json.ends_with(".json"))
    refuse(fmt::format("[output] json: {} must end in .json", c.output.json));
  const std::vector<std::string> names = names_of_files(c);
  for (const std::string& name : names) {
    const std::filesystem::path path = name;
    if (path.has_parent_path())
      refuse(fmt::format("[output] {} must be a name without folders; all go to [output] folder", name));
    if (std::count(names.begin(), names.end(), name) > 1)
      refuse(fmt::format("[output] {} is named for two files; give each its own name", name));
  }
}

}  // namespace

void check_case(const Case& c) {
  check_input(c);
  refuse_other_mesher(c);
  if (c.cells_per_diameter > 0 && c.cells_per_diameter < 1)
    refuse(fmt::format("cells_per_diameter must be at least 1, or 0; not {:g}", c.cells_per_diameter));
  if (!c.sizes.points.empty() && !(c.sizes.floor_mm > 0))
    refuse("[delaunay] size_points needs size_floor, the least size in mm");
  if (c.sizes.ceiling_mm > 0 && c.sizes.ceiling_mm < c.sizes.floor_mm)
    refuse("[delaunay] size_ceiling is less than size_floor");
  check_metric(c);
  try {
    c.adapt.validate();
  } catch (const Error& contradiction) {
    refuse(std::string("[adapt] ") + contradiction.what());
  }
  check_output(c);
  check_layer_keys(c);
  try {
    static_cast<void>(renamings_from(c.openings.names));
  } catch (const Error& wrong) {
    refuse(std::string("[openings] names: ") + wrong.what());
  }
}

}  // namespace lumesh::pipeline
