#include <fmt/core.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "case_sections.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/io/file_formats.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/metric/sources.hpp"
#include "outputs.hpp"

namespace lumesh::pipeline {
namespace {

[[noreturn]] void throw_bad_case(const std::string& what) {
  throw Error(ErrorKind::kBadInput, what);
}

/// Refuses keys of [input] that say nothing of what it is.
void require_none(const std::vector<std::string>& keys, const std::string& of, const std::string& input) {
  if (keys.empty()) return;
  throw_bad_case(fmt::format("[input] {} is for {}; leave it out with {}", fmt::join(keys, ", "), of, input));
}

/// The keys of [input] on a phantom's image.
struct PhantomImageKeys {
  PhantomSpec spec;
  void describe(OptionList& list) { spec.describe_image(list, "phantom_"); }
};

/// Refuses keys that are for another kind of input.
void require_keys_of_input(const InputKeys& input) {
  const bool is_surface = !input.surface.empty(), is_phantom = !input.phantom.empty();
  const std::string given = is_surface ? "surface" : is_phantom ? "phantom" : "image";
  if (!is_phantom)
    require_none(differing_options(PhantomImageKeys{input.phantom_spec}, PhantomImageKeys()), "phantoms",
                 given);
  if (!is_surface)
    return require_none(differing_options(input.of_surface, SurfaceInputOptions()), "surfaces", given);
  require_none(input.selection.given(), "images", given);
  require_none(differing_options(input.field, LabelFieldOptions()), "images", given);
}

void check_input(const Case& c) {
  const InputKeys& input = c.input;
  const int given =
      (input.image.empty() ? 0 : 1) + (input.surface.empty() ? 0 : 1) + (input.phantom.empty() ? 0 : 1);
  if (given != 1)
    throw_bad_case("[input] needs one of image, surface and phantom, not " + std::to_string(given) +
                   " of them");
  if (!input.surface.empty() && c.mesher == Mesher::kLattice)
    throw_bad_case("the lattice mesher takes images; for [input] surface set mesher = \"delaunay\"");
  naming("[input]", [&] { input.cuts.validate(); });
  const ImageSelection& selection = input.selection;
  require_keys_of_input(input);
  if (input.phantom.empty()) return;
  ImageSelection of_phantoms = selection;  // Without what is for files.
  of_phantoms.labels.clear();
  of_phantoms.largest_component = of_phantoms.fill_cavities = false;
  of_phantoms.drop_below = 0;
  of_phantoms.touching = TouchChoice::kKeep;
  require_none(of_phantoms.given(), "images", "phantom");
  try {
    static_cast<void>(phantom_kind_from_name(input.phantom));
  } catch (const Error& unknown) {
    throw_bad_case(std::string("[input] ") + unknown.what());
  }
}

bool has_keys(const Case& c, const std::string& section) {
  return section_text(c, section) != section_text(Case(), section);
}

/// Refuses settings for the mesher that is not taken: they would be set for nothing.
void require_one_mesher(const Case& c) {
  const bool is_lattice = c.mesher == Mesher::kLattice;
  const std::string other = is_lattice ? "delaunay" : "lattice";
  if (has_keys(c, other))
    throw_bad_case(fmt::format(
        "[{0}] is for mesher = \"{0}\", and the mesher is {1}; set mesher or leave the section out", other,
        is_lattice ? "lattice" : "delaunay"));
}

/// Refuses a key before the first section together with one of the mesher's section that it stands for.
void require_one_size(const Case& c) {
  const auto require_one = [](bool has_both, const char* first, const char* own, const char* remedy) {
    if (has_both) throw_bad_case(fmt::format("{} and {} exclude each other; {}", first, own, remedy));
  };
  constexpr const char* kZero = "give one of them (0 leaves one out)";
  const bool has_edge = c.edge_length_mm > 0;
  const DelaunayOptions& delaunay = c.delaunay.delaunay;
  require_one(has_edge && c.lattice.spacing_mm > 0, "edge_length", "[lattice] edge_length", kZero);
  require_one(has_edge && delaunay.edge_length_mm > 0, "edge_length", "[delaunay] edge_length", kZero);
  require_one(has_edge && delaunay.delta_mm > 0, "edge_length", "[delaunay] delta", kZero);
  require_one(c.cells_per_diameter > 0 && c.lattice.fidelity != LatticeOptions().fidelity,
              "cells_per_diameter", "[lattice] fidelity", "give one of them");
}

/// Names of the keys of a section that a file or the command line gives, but for those whose value is the
/// default: case_text() writes all.
std::set<std::string> given_in(const CaseSection& section, const CaseSection& defaults,
                               const std::set<std::string>& given) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < section.options.all().size(); ++i) {
    const Option& key = section.options.all()[i];
    if (given.contains(section.name + "." + key.name) &&
        key.value_text() != defaults.options.all()[i].value_text())
      names.insert(key.name);
  }
  return names;
}

/// Options that exclude or need one another, by their descriptions.
void check_given(const Case& c, const std::set<std::string>& given) {
  Case copy = c, untouched;
  const std::vector<CaseSection> sections = sections_of(copy), defaults = sections_of(untouched);
  for (std::size_t s = 0; s < sections.size(); ++s) {
    const CaseSection& section = sections[s];
    const std::set<std::string> names = given_in(section, defaults[s], given);
    const auto has = [&](const std::string& name) { return names.contains(name); };
    const std::string head = section.name.empty() ? "" : "[" + section.name + "] ";
    for (const Option& key : section.options.all()) {
      if (!has(key.name)) continue;
      for (const std::string& other : key.excluded)
        if (has(other))
          throw_bad_case(
              fmt::format("{}{} and {} exclude each other; give one of them", head, key.name, other));
      for (const std::string& other : key.needed)
        if (!has(other)) throw_bad_case(fmt::format("{}{} needs {}", head, key.name, other));
    }
  }
}

template <class Source>
std::string option_of_source() {
  Source source;
  return options_of(source).all().front().name;
}

/// Sources that a case may have, for messages: "analytic, points or curvature".
std::string sources_of_cases() {
  std::vector<std::string> names = metric::MetricRequest::source_options();
  for (const std::string& refused :
       {option_of_source<metric::TensorSource>(), option_of_source<metric::HessianSource>()})
    std::erase(names, refused);
  const std::string last = names.back();
  names.pop_back();
  return fmt::format("{} or {}", fmt::join(names, ", "), last);
}

void check_metric(const Case& c) {
  const metric::MetricRequest& m = c.metric;
  if (m.source<metric::VelocitySource>().velocity == "phantom" && c.input.phantom.empty())
    throw_bad_case("[metric] velocity = \"phantom\" needs [input] phantom");
  if (m.source<metric::TensorSource>().is_wanted() || m.source<metric::HessianSource>().is_wanted())
    throw_bad_case(
        "[metric] metric and hessian have a value for each vertex of a mesh that is there; use `lumesh "
        "metric` and `lumesh adapt` on that mesh");
  if (m.limits.complexity > 0 && !m.has_source())
    throw_bad_case("[metric] complexity has nothing to scale; give " + sources_of_cases());
}

void check_unused(const Case& c) {
  if (c.metric.has_source()) return;
  for (const char* section : {"metric", "adapt"})
    if (has_keys(c, section))
      throw_bad_case(
          fmt::format("[{}] changes nothing without sizes; give {} in [metric], or leave the section out",
                      section, sources_of_cases()));
}

/// Only tetrahedra are changed.
void check_mixed(const Case& c) {
  if (!c.makes_mixed_mesh()) return;
  constexpr const char* kRemedy = "leave one of them out; without mixed the lattice makes tetrahedra only";
  if (c.metric.has_source())
    throw_bad_case(fmt::format(
        "[lattice] mixed makes hexahedra and pyramids, which [metric] and [adapt] do not change; {}",
        kRemedy));
  if (c.layers.is_wanted() && c.layers.options.side == LayerSide::kInward)
    throw_bad_case(fmt::format(
        "[lattice] mixed makes hexahedra and pyramids, which layers cannot deform with [layers] side "
        "= \"inward\"; {}",
        kRemedy));
}

/// Formats hold the cells.
void check_shapes(const Case& c) {
  const bool has_prisms = c.layers.is_wanted() && c.layers.options.cells == LayerCells::kPrisms;
  if (!c.makes_mixed_mesh() && !has_prisms) return;
  for (const std::string& name : c.output.meshes)
    if (!is_for(name, FileUse::kWriteMixed))
      throw_bad_case(fmt::format("[output] meshes: {} holds tetrahedra only, not the {}; use {}, or {}", name,
                                 has_prisms ? "prisms of [layers]" : "hexahedra of [lattice] mixed",
                                 formats_for(FileUse::kWriteMixed),
                                 has_prisms ? "set [layers] cells = \"tetrahedra\"" : "leave mixed out"));
}

void check_layer_keys(const Case& c) {
  if (!c.layers.is_wanted()) {
    if (has_keys(c, "layers"))
      throw_bad_case(
          "[layers] first_height is missing: the height of the layer next to the surface; without layers "
          "leave the section out");
    return;
  }
  static_cast<void>(layer_heights(c.layers.options));
}

/// The section's own checks, with its keys and as bad input.
template <class Check>
void check_section(const std::string& section, const Check& check) {
  try {
    check();
  } catch (const Error& error) {
    std::string message = with_case_keys(error.what(), {section});
    if (message.find("[" + section + "]") == std::string::npos) message = "[" + section + "] " + message;
    throw Error(ErrorKind::kBadInput, message);
  }
}

void check_output(const Case& c) {
  if (c.output.meshes.empty()) throw_bad_case("[output] meshes names no file; such as [\"mesh.vtu\"]");
  for (const std::string& name : c.output.meshes)
    naming("[output] meshes", [&] { require_format(name, FileUse::kWriteVolume); });
  std::set<std::filesystem::path> folders_of_foam;
  for (const std::filesystem::path name : c.output.meshes)
    if (name.extension() == ".foam" && !folders_of_foam.insert(name.parent_path()).second)
      throw_bad_case(
          fmt::format("[output] meshes: {} would replace the mesh of another .foam, since a folder has one "
                      "constant/polyMesh; name one of them",
                      name.string()));
  if (!c.output.surface.empty())
    naming("[output] surface", [&] { require_format(c.output.surface, FileUse::kWriteSurface); });
  if (!c.output.report.empty() && !c.output.report.ends_with(".html"))
    throw_bad_case(fmt::format("[output] report: {} must end in .html", c.output.report));
  if (!c.output.json.empty() && !c.output.json.ends_with(".json"))
    throw_bad_case(fmt::format("[output] json: {} must end in .json", c.output.json));
  const std::vector<std::string> names = names_of_files(c);
  for (const std::string& name : names) {
    const std::filesystem::path path = name;
    if (path.has_parent_path())
      throw_bad_case(
          fmt::format("[output] {} must be a name without folders; all go to [output] folder", name));
    if (std::ranges::count(names, name) > 1)
      throw_bad_case(fmt::format("[output] {} is named for two files; give each its own name", name));
  }
}

}  // namespace

void check_case(const Case& c, const std::set<std::string>& given) {
  check_input(c);
  check_given(c, given);
  require_one_mesher(c);
  require_one_size(c);
  check_section("lattice", [&] { c.lattice.validate(); });
  check_section("delaunay", [&] { c.delaunay.validate(); });
  check_section("centerline", [&] { c.centerline.options.validate(); });
  check_section("metric", [&] { c.metric.validate(); });
  check_metric(c);
  check_section("adapt", [&] { c.adapt.validate(); });
  check_unused(c);
  check_output(c);
  check_mixed(c);
  check_shapes(c);
  check_section("layers", [&] { check_layer_keys(c); });
  check_section("openings",
                [&] { naming("names", [&] { static_cast<void>(renamings_from(c.openings.names)); }); });
}

}  // namespace lumesh::pipeline
