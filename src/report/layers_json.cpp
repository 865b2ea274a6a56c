#include "layers_json.hpp"

#include "command_notes_json.hpp"

namespace lumesh::report {

namespace {

using LayerJson = nlohmann::ordered_json;

LayerJson place_json(const LayerCoverage::Place& place) {
  return {{"at_mm", {place.at.x(), place.at.y(), place.at.z()}},
          {"achieved", place.achieved},
          {"why", name_of(place.why)}};
}

/// Calls visit(name, value) for what a coverage says of its patch as a whole.
template <class Coverage, class Visit>
void for_each_value(Coverage& c, const Visit& visit) {
  visit("patch", c.patch);
  visit("area_mm2", c.area_mm2);
  visit("layers", c.layers);
  visit("wanted_mm", c.wanted_mm);
  visit("achieved_mm", c.achieved_mm);
  visit("least_mm", c.min_mm);
  visit("complete", c.complete);
  visit("mean_layers", c.mean_layers);
  visit("all_layers", c.all_layers);
  visit("layered", c.layered);
  visit("first_height_kept", c.first_kept);
  visit("least_first_height", c.min_first);
  visit("greatest_first_height", c.greatest_first);
  visit("bare", c.unlayered);
}

LayerJson patch_json(const LayerCoverage& c) {
  LayerJson json;
  for_each_value(c, [&](const char* name, const auto& value) { json[name] = value; });
  json["limited"] = LayerJson::object();
  json["worst"] = LayerJson::array();
  for (std::size_t i = 1; i < kLayerLimits; ++i)
    json["limited"][name_of(static_cast<LayerLimit>(i))] = c.limited[i];
  for (const LayerCoverage::Place& place : c.worst) json["worst"].push_back(place_json(place));
  return json;
}

LayerJson surface_json(const LayerShares& surface) {
  LayerJson points = LayerJson::array();
  for (const Vec3& p : surface.points) points.push_back({p.x(), p.y(), p.z()});
  return {{"points", points}, {"triangles", surface.triangles}, {"of_points", surface.of_points}};
}

Vec3 vector_of(const LayerJson& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

LayerLimit limit_named(const std::string& name) {
  for (std::size_t i = 0; i < kLayerLimits; ++i)
    if (name == name_of(static_cast<LayerLimit>(i))) return static_cast<LayerLimit>(i);
  return LayerLimit::kNone;
}

LayerCoverage patch_of(const LayerJson& json) {
  LayerCoverage c;
  for_each_value(c, [&](const char* name, auto& value) { json.at(name).get_to(value); });
  for (std::size_t i = 1; i < kLayerLimits; ++i)
    c.limited[i] = json.at("limited").at(name_of(static_cast<LayerLimit>(i)));
  for (const LayerJson& place : json.at("worst"))
    c.worst.push_back({vector_of(place.at("at_mm")), place.at("achieved"), limit_named(place.at("why"))});
  return c;
}

}  // namespace

LayerJson coverage_json(const LayerReport& report) {
  LayerJson json = {{"layers", report.layers},
                    {"heights", report.heights},
                    {"cells", report.cells},
                    {"complete", report.complete()},
                    {"patches", LayerJson::array()}};
  for (const LayerCoverage& patch : report.patches) json["patches"].push_back(patch_json(patch));
  return json;
}

LayerJson layers_of_mesh_json(const LayersOfMesh& layers) {
  const quality::TetrahedronStatistics& core = layers.core.tetrahedra;
  LayerJson json = coverage_json(layers.report);
  json["core"] = {
      {"tetrahedra", core.count},
      {"dihedral_deg", {{"min", core.smallest_dihedral_deg.value}, {"max", core.largest_dihedral_deg.value}}},
      {"mean_ratio", {{"min", core.smallest_mean_ratio.value}, {"mean", core.mean_mean_ratio}}}};
  json["shapes"] = {
      {"tetrahedra", layers.layers.tetrahedra.count},
      {"pyramids", layers.layers.pyramids},
      {"prisms", layers.layers.prisms},
      {"dihedral_deg",
       {{"min", layers.shapes.smallest_dihedral_deg}, {"max", layers.shapes.largest_dihedral_deg}}},
      {"aspect", {{"max", layers.shapes.largest_aspect}, {"mean", layers.shapes.mean_aspect}}}};
  if (layers.layers.prisms + layers.layers.pyramids > 0)
    json["shapes"]["scaled_jacobian"] = {{"min", layers.layers.smallest_scaled_jacobian}};
  return json;
}

LayerJson whole_report_json(const LayerReport& report) {
  LayerJson json = coverage_json(report);
  json["core_pyramids"] = report.core_pyramids;
  json["core_prisms"] = report.core_prisms;
  json["surface"] = surface_json(report.surface);
  return json;
}

LayerReport layer_report_of(const LayerJson& json) {
  LayerReport report;
  report.layers = json.at("layers");
  report.heights = json.at("heights").get<std::vector<double>>();
  report.cells = json.at("cells");
  report.core_pyramids = json.at("core_pyramids");
  report.core_prisms = json.at("core_prisms");
  for (const LayerJson& patch : json.at("patches")) report.patches.push_back(patch_of(patch));
  const LayerJson& surface = json.at("surface");
  for (const LayerJson& point : surface.at("points")) report.surface.points.push_back(vector_of(point));
  report.surface.triangles = surface.at("triangles").get<std::vector<Cell<3>>>();
  report.surface.of_points = surface.at("of_points").get<std::vector<double>>();
  return report;
}

std::string layers_json(const LayersOfMesh& layers, const CommandNotes& notes) {
  return with_notes(layers_of_mesh_json(layers), notes);
}

}  // namespace lumesh::report
