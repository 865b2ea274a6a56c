#include "lumesh/report/file_description.hpp"

#include <fmt/core.h>

#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>
#include <tuple>

#include "closed_json.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/parse_number.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/domain/patched_surface.hpp"
#include "lumesh/field/label_field.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/image/crossings.hpp"
#include "lumesh/image/grey_values.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/all_cells.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/stages/input_cuts.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/surface_input.hpp"
#include "lumesh/stages/vessel_ends.hpp"
#include "lumesh/vessels/opening_sections.hpp"

namespace lumesh::report {
namespace {

using json = nlohmann::ordered_json;

double rounded(double value, int digits) {
  return parse_number<double>(fmt::format("{:.{}g}", value, digits)).value_or(value);
}

/// 12 digits, which headers mean, instead of the 17 that arithmetic leaves: 0.5 for 0.49999999999999994.
double tidy(double value) {
  return rounded(value, 12);
}

json tidied(json all) {
  for (json& value : all)
    if (value.is_structured())
      value = tidied(std::move(value));
    else if (value.is_number_float())
      value = tidy(value.get<double>());
  return all;
}

/// Of what is measured.
double short_number(double value) {
  return rounded(value, 5);
}

json list(const Vec3& v) {
  return json::array({tidy(v.x()), tidy(v.y()), tidy(v.z())});
}

json describe_image(const LabelImage& image) {
  const ImageFrame& f = image.frame();
  json all = {{"kind", "image"},
              {"size_voxels", json::array({f.size.x(), f.size.y(), f.size.z()})},
              {"spacing_mm", list(f.spacing_mm)},
              {"origin_mm", list(f.origin_mm)},
              {"direction_columns",
               json::array({list(f.direction.col(0)), list(f.direction.col(1)), list(f.direction.col(2))})},
              {"frame", "LPS"},
              {"labels", json::array()}};
  for (const LabelTopology& t : label_topology(image)) {
    json label = {{"label", t.label}};
    if (const auto name = image.label_names().find(t.label); name != image.label_names().end())
      label["name"] = name->second;
    label.update({{"voxels", t.voxel_count},
                  {"volume_mm3", tidy(t.volume_mm3)},
                  {"components", t.component_count},
                  {"euler", t.euler_number}});
    all["labels"].push_back(std::move(label));
  }
  const CrossingCounts counts = count_crossings(image);
  all["boundary"] = {{"faces", counts.faces}, {"placed_by_values", counts.crossed}};
  return all;
}

/// Counts of values in 16 ranges of one width.
json describe_grey_values(const NumberImage& image) {
  constexpr std::size_t kRanges = 16, kBinsInRange = GreyValues::kBins / kRanges;
  const GreyValues grey = grey_values(std::span<const float>(image.values));
  const double threshold = grey.otsu_threshold();
  json all = {
      {"kind", "grey values"},
      {"size_voxels", json::array({image.frame.size.x(), image.frame.size.y(), image.frame.size.z()})},
      {"spacing_mm", list(image.frame.spacing_mm)},
      {"least", short_number(grey.least)},
      {"most", short_number(grey.most)},
      {"otsu_threshold", short_number(threshold)},
      {"percent_at_or_above", short_number(100 * grey.share_from(threshold))},
      {"histogram", json::array()}};
  for (std::size_t r = 0; r < kRanges; ++r) {
    const auto first = grey.bins.begin() + static_cast<std::ptrdiff_t>(r * kBinsInRange);
    all["histogram"].push_back(
        {{"from", short_number(grey.least + static_cast<double>(r * kBinsInRange) * grey.bin_width())},
         {"voxels", std::accumulate(first, first + kBinsInRange, std::size_t{0})}});
  }
  return all;
}

/// Named as meshes of the image have them.
json describe_openings(std::span<const Opening> openings) {
  json list_of = json::array();
  for (const Opening& opening : openings)
    list_of.push_back({{"name", opening.name},
                       {"label", opening.label},
                       {"area_mm2", short_number(opening.area_mm2)},
                       {"radius_mm", short_number(opening.radius_mm())},
                       {"centre_mm", list(opening.centre_mm)},
                       {"normal", list(opening.normal)}});
  return list_of;
}

/// Where vessels end inside the image, with the places to cut them at, or why they cannot be cut.
json describe_ends(std::span<const VesselEnd> ends) {
  json list_of = json::array();
  for (const VesselEnd& end : ends) {
    json& one = list_of.emplace_back(json{{"radius_mm", short_number(end.radius_mm)}});
    if (end.cut_mm) {
      one["cut_at"] = cut_place_text(*end.cut_mm);
    } else {
      one["end_at"] = cut_place_text(end.place_mm);
      one["cannot_be_cut"] = end.refusal;
    }
  }
  return list_of;
}

json describe_labels(const MeshInfo& info, const AllCells& all_cells) {
  std::map<Label, std::size_t> cells;
  for (std::size_t c = 0; c < all_cells.size(); ++c) ++cells[all_cells.label(c)];
  json list_of = json::array();
  for (const auto& [label, count] : cells) {
    json& one = list_of.emplace_back(json{{"label", label}});
    if (const auto name = info.label_names.find(label); name != info.label_names.end())
      one["name"] = name->second;
    one["cells"] = count;
  }
  return list_of;
}

/// @param in_use  Only those that have faces.
json describe_patches(const MixedMesh& mesh, bool in_use) {
  std::vector<std::size_t> faces(mesh.info.patches.size(), 0);
  for (const auto* patches : {&mesh.triangle_patches, &mesh.quadrilateral_patches}) {
    for (const std::int32_t p : *patches) ++faces[static_cast<std::size_t>(p)];
  }
  json list_of = json::array();
  for (std::size_t p = 0; p < faces.size(); ++p) {
    const Patch& patch = mesh.info.patches[p];
    if (faces[p] > 0 || !in_use)
      list_of.push_back(
          {{"name", patch.name}, {"kind", kind_word(patch.kind, patch.flow)}, {"faces", faces[p]}});
  }
  return list_of;
}

json describe_mesh(MixedMesh mesh) {
  if (mesh.triangles.empty() && mesh.quadrilaterals.empty()) extract_boundary(mesh);
  const Box3 box = bounding_box(mesh.points);
  const MeshView view = mesh.view();
  const AllCells all_cells(view);
  const bool is_surface = all_cells.size() == 0 && mesh.triangles.size() + mesh.quadrilaterals.size() > 0;
  json all = {{"kind", is_surface ? "surface" : "mesh"}, {"points", mesh.points.size()}};
  if (is_surface) {
    all["triangles"] = mesh.triangles.size();
    if (!mesh.quadrilaterals.empty()) all["quadrilaterals"] = mesh.quadrilaterals.size();
  } else {
    all.update({{"tetrahedra", mesh.tetrahedra.size()},
                {"pyramids", mesh.pyramids.size()},
                {"prisms", mesh.prisms.size()},
                {"hexahedra", mesh.hexahedra.size()}});
  }
  all.update({{"unit", mesh.info.unit},
              {"frame", mesh.info.frame},
              {"box", json::array({list(box.min()), list(box.max())})},
              {"labels", describe_labels(mesh.info, all_cells)},
              {"patches", describe_patches(mesh, is_surface)},
              {"provenance", mesh.info.provenance}});
  return all;
}

/// Patches of these names are openings, as meshes of the surface will have them.
void take_kinds(std::span<const Patch> known, json& patches) {
  for (json& described : patches)
    for (const Patch& patch : known)
      if (patch.kind == PatchKind::kOpening && described["name"] == patch.name)
        described["kind"] = kind_word(patch.kind, patch.flow);
}

/// Openings of the flat ends of a closed surface; not of a very large one: that is not worth the time.
void add_openings_of_surface(const DescriptionRequest& request, json& all, Context& context) {
  const auto& [path, unit] = std::tie(request.path, request.selection.unit);
  constexpr std::size_t kMaxTriangles = 1'000'000;
  const auto leave_out = [&](const std::string& why) { context.warn("openings are not looked for: " + why); };
  try {
    SurfaceInput given = read_surface(path, unit, {}, request.cuts, context);
    const MixedMesh& surface = given.mesh;
    if (surface.triangles.size() > kMaxTriangles)
      return leave_out(fmt::format("more than {} triangles", kMaxTriangles));
    const PatchedSurface patched(surface_view(surface, given.resolution_mm));
    take_kinds(patched.patches(), all["patches"]);
    name_closed(given.closed, patched.flat_ends());
    warn_of_filled_ends(given.closed, context);
    if (!given.closed.empty()) all["would_close"] = tidied(closed_json(given.closed));
    const std::vector<Opening> openings = openings_of(patched.flat_ends(), patched.resolution_mm());
    all["openings"] = describe_openings(openings);
    if (all["frame"] != MeshInfo().frame) all["openings_frame"] = MeshInfo().frame;
    warn_of_unit(given, openings, unit, path, context);
    for (const std::string& note : patched.patch_notes()) context.warn(note);
    const std::string warning = closed_surface_warning(patched.patches(), patched.flat_ends());
    if (!warning.empty()) context.warn(warning);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kBadInput || !request.cuts.none()) throw;
    leave_out(error.what());
  }
}

json describe_mesh_file(const DescriptionRequest& request, Context& context) {
  const MixedMesh mesh =
      context.phase("read", [&] { return read_mesh_in(request.path, request.selection.unit, context); });
  json all = describe_mesh(mesh);
  if (mesh.view().cell_count() > 0) warn_of_walled_ends(request.path, mesh, context);
  if (mesh.view().cell_count() == 0 && mesh.triangles.size() + mesh.quadrilaterals.size() > 0)
    context.phase("openings", [&] { add_openings_of_surface(request, all, context); });
  return all;
}

/// Not of an image with very many labels, or of noise: they are not worth the time.
void add_openings(LabelImage& image, const InputCuts& cuts, std::vector<CutPlane> planes, json& all,
                  Context& context) {
  constexpr std::size_t kMaxLabels = 200;
  const auto leave_out = [&](const std::string& why) { context.warn("openings are not looked for: " + why); };
  if (image.values().size() > kMaxLabels) return leave_out(fmt::format("more than {} labels", kMaxLabels));
  try {
    InputCuts before = cuts;
    before.extension = {};
    auto domain = domain_of_cut(image, planes, before, {}, context);
    std::vector<Opening> openings = find_openings(*domain);
    // Cuts come before extensions, and these end no vessel inside the image.
    const std::vector<VesselEnd> ends = vessel_ends(image, planes, openings, ~std::size_t{0}, context);
    if (cuts.extension.is_wanted()) {
      domain = extended_domain(image, planes, *domain, openings, cuts.extension, context);
      openings = find_openings(*domain);
    } else {
      for (const std::string& doubt : doubts_about_shapes(image, *domain, openings)) context.warn(doubt);
    }
    for (const std::string& doubt :
         doubts_about_sections(image, domain->cut_planes(), openings, domain->field().fidelity()))
      context.warn(doubt);
    all["openings"] = describe_openings(openings);
    all["vessel_ends"] = describe_ends(ends);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kBadInput || cuts.extension.is_wanted()) throw;
    leave_out(error.what());
  }
}

std::string value_text(const json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::string text_of(const json& all) {
  std::string text;
  for (const auto& [name, value] : all.items()) {
    if (!value.is_array() || value.empty() || !value[0].is_object()) {
      text += fmt::format("{:<19} {}\n", name, value_text(value));
      continue;
    }
    text += name + "\n";
    for (const json& item : value) {
      for (const auto& [key, entry] : item.items()) text += fmt::format("  {} {}", key, value_text(entry));
      text += "\n";
    }
  }
  return text;
}

json describe_image_file(const DescriptionRequest& request, Context& context) {
  try {
    LabelImage image =
        context.phase("read", [&] { return read_selected_image(request.path, request.selection, context); });
    json all = context.phase("labels", [&] { return describe_image(image); });
    const std::vector<CutPlane> planes =
        naming(request.path, [&] { return cut_off(image, request.cuts, context); });
    context.phase("openings", [&] { add_openings(image, request.cuts, planes, all, context); });
    return all;
  } catch (const NotLabels& grey) {
    context.warn(grey.what());
    return describe_grey_values(read_number_image(request.path, context, request.selection.one_frame()));
  }
}

}  // namespace

FileDescription describe_file(const DescriptionRequest& request, Context& context) {
  const json all = is_mesh_file(request.path) ? describe_mesh_file(request, context)
                                              : describe_image_file(request, context);
  return {all.dump(2), text_of(all)};
}

}  // namespace lumesh::report
