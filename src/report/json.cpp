#include <nlohmann/json.hpp>

#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/quality/topology_places.hpp"
#include "lumesh/report/summary.hpp"

namespace lumesh::report {

namespace {

using Json = nlohmann::ordered_json;
using namespace lumesh::quality;

Json point(const Vec3& p) {
  return Json::array({p.x(), p.y(), p.z()});
}

Json to_json(const Histogram& histogram) {
  return {{"low", histogram.low}, {"high", histogram.high}, {"counts", histogram.counts}};
}

Json to_json(const Extreme& extreme) {
  return {{"value", extreme.value},
          {"tetrahedron", extreme.tetrahedron},
          {"centre_mm", point(extreme.centre_mm)}};
}

Json to_json(const DistanceSummary& summary) {
  return {{"max", summary.max},
          {"mean", summary.mean},
          {"p95", summary.p95},
          {"samples", summary.samples},
          {"worst_mm", point(summary.worst_mm)}};
}

Json to_json(const std::optional<SurfaceDistances>& distances) {
  if (!distances) return nullptr;
  return {{"mesh_to_image", to_json(distances->mesh_to_image_mm)},
          {"image_to_mesh", to_json(distances->image_to_mesh_mm)},
          {"vertex_to_voxel_two_sided", distances->vertex_to_voxel_two_sided_mm},
          {"vertices_to_voxels", distances->vertices_to_voxels_mm},
          {"voxels_to_vertices", distances->voxels_to_vertices_mm}};
}

Json to_json(const SurfaceTopology& surface) {
  Json components = Json::array();
  for (const SurfaceComponent& c : surface.components)
    components.push_back({{"triangles", c.triangles},
                          {"area_mm2", c.area_mm2},
                          {"enclosed_volume_mm3", c.enclosed_volume_mm3},
                          {"euler", c.euler},
                          {"genus", c.genus < 0 ? Json(nullptr) : Json(c.genus)}});
  return {{"closed", surface.closed()},
          {"manifold", surface.manifold()},
          {"components", surface.components.size()},
          {"genus", surface.genus() < 0 ? Json(nullptr) : Json(surface.genus())},
          {"vertices", surface.vertices},
          {"triangles", surface.triangles},
          {"open_edges", surface.open_edges},
          {"non_manifold_edges", surface.non_manifold_edges},
          {"non_manifold_vertices", surface.non_manifold_vertices},
          {"pieces", components}};
}

Json dihedral_json(const TetrahedronStatistics& s) {
  return {{"min", s.smallest_dihedral_deg.value},
          {"max", s.largest_dihedral_deg.value},
          {"mean_of_smallest", s.mean_smallest_dihedral_deg},
          {"below", {{"5", s.below_5_deg}, {"10", s.below_10_deg}, {"15", s.below_15_deg}}},
          {"above", {{"150", s.above_150_deg}, {"160", s.above_160_deg}, {"165", s.above_165_deg}}},
          {"smallest", to_json(s.smallest_dihedral_deg)},
          {"largest", to_json(s.largest_dihedral_deg)},
          {"histogram", to_json(s.dihedral_deg)}};
}

Json mean_ratio_json(const TetrahedronStatistics& s) {
  return {{"min", s.smallest_mean_ratio.value},
          {"mean", s.mean_mean_ratio},
          {"smallest", to_json(s.smallest_mean_ratio)},
          {"histogram", to_json(s.mean_ratio)}};
}

Json band_json(const EdgeBand& band) {
  return {{"edges", band.edges},
          {"fraction_in_band", band.fraction_in_band()},
          {"fraction_short", band.fraction_short()},
          {"fraction_long", band.fraction_long()}};
}

Json metric_edges_json(const MetricStatistics& s) {
  Json json = band_json(s);
  json.update({{"min", s.shortest_edge},
               {"max", s.longest_edge},
               {"mean", s.mean_edge},
               {"histogram", to_json(s.edge_length)}});
  if (s.free_edges) json["free"] = band_json(*s.free_edges);
  return json;
}

Json metric_ratio_json(const MetricStatistics& s) {
  return {{"min", s.smallest_mean_ratio.value},
          {"mean", s.mean_mean_ratio},
          {"below", {{"0.1", s.poor_tetrahedra}}},
          {"smallest", to_json(s.smallest_mean_ratio)},
          {"histogram", to_json(s.mean_ratio)}};
}

/// Nothing without a metric; null throughout if the metric is none.
void add_metric_json(const Evaluation& e, Json& json) {
  if (!e.has_metric) return;
  for (const char* key : {"metric_edge_length", "metric_mean_ratio", "complexity", "vertices_per_complexity",
                          "tetrahedra_per_complexity"})
    json[key] = nullptr;
  if (!e.metric) return;
  json["metric_edge_length"] = metric_edges_json(*e.metric);
  json["metric_mean_ratio"] = metric_ratio_json(*e.metric);
  json["complexity"] = e.metric->complexity;
  json["vertices_per_complexity"] = e.metric->vertices_per_complexity();
  json["tetrahedra_per_complexity"] = e.metric->tetrahedra_per_complexity();
}

Json reference_json(const LabelEvaluation& label, const Evaluation& e) {
  const LabelReference& r = *label.reference;
  const auto summary = [](const std::optional<DistanceSummary>& d) {
    return d ? to_json(*d) : Json(nullptr);
  };
  return {{"volume_mm3", r.volume_mm3},
          {"volume_error_percent",
           e.cut_planes > 0 ? Json(nullptr) : Json(label.reference_volume_error_percent())},
          {"components", r.components},
          {"euler", r.euler},
          {"topology_equal",
           label.components == static_cast<std::uint64_t>(r.components) && label.euler == r.euler},
          {"surface_distance_mm", summary(r.surface_distance_mm)},
          {"truth_to_mesh_mm", summary(r.truth_to_mesh_mm)},
          {"normal_angle_deg", summary(r.normal_angle_deg)}};
}

template <class Value>
Json or_null(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json to_json(const LabelTopology& voxels) {
  return {{"voxels", voxels.voxel_count},
          {"components", voxels.component_count},
          {"euler", voxels.euler_number},
          {"cavities", voxels.cavity_count},
          {"handles", voxels.handle_count()}};
}

Json to_json(const KeptVoxels& kept, double voxel_size_mm) {
  Json json = {{"counted", kept.counted}, {"kept", kept.kept}, {"share", kept.share()}, {"worst", nullptr}};
  if (const auto& worst = kept.worst) {
    json["worst"] = {{"distance_mm", worst->distance_mm},
                     {"distance_voxels", worst->distance_mm / voxel_size_mm},
                     {"centre_mm", point(worst->centre_mm)},
                     {"voxel", nullptr}};
    if (const auto& voxel = worst->voxel)
      json["worst"]["voxel"] = Json::array({voxel->x(), voxel->y(), voxel->z()});
  }
  return json;
}

Json to_json(const CurvatureSummary& curvature) {
  return {{"vertices", curvature.vertices},
          {"root_mean_square", curvature.root_mean_square_per_mm},
          {"mean", curvature.mean_per_mm},
          {"p2", curvature.p2_per_mm},
          {"p98", curvature.p98_per_mm}};
}

Json to_json(const OpeningsCompared& compared) {
  Json json = Json::array();
  for (const OpeningInMesh& o : compared.openings)
    json.push_back({{"patches", o.patches},
                    {"label", o.opening.label},
                    {"mesh_area_mm2", o.mesh_area_mm2},
                    {"image_area_mm2", o.opening.area_mm2},
                    {"change_percent", o.change_percent()},
                    {"radius_mm", o.opening.radius_mm()},
                    {"centre_mm", point(o.opening.centre_mm)},
                    {"normal", point(o.opening.normal)},
                    {"parts", o.shape.parts},
                    {"edges_around", o.shape.edges},
                    {"off_plane_mm", o.shape.off_mm},
                    {"wrong", is_wrong(o)}});
  for (const std::string& name : compared.others)
    json.push_back({{"patches", name}, {"image_area_mm2", nullptr}, {"wrong", true}});
  return json;
}

Json to_json(const std::vector<NarrowestSection>& sections) {
  Json json = Json::array();
  for (const NarrowestSection& s : sections)
    json.push_back({{"branch", s.branch},
                    {"centre_mm", point(s.centre_mm)},
                    {"normal", point(s.direction)},
                    {"mesh_area_mm2", s.mesh_area_mm2},
                    {"voxel_area_mm2", s.voxel_area_mm2},
                    {"change_percent", s.change_percent()},
                    {"tightened", s.tightened()},
                    {"widened", s.widened()}});
  return json;
}

const char* name_of(TopologyChange change) {
  switch (change) {
    case TopologyChange::kExtraPiece:
      return "extra piece";
    case TopologyChange::kMissingPiece:
      return "missing piece";
    case TopologyChange::kJoined:
      return "joined";
    case TopologyChange::kSplit:
      return "split";
    case TopologyChange::kFilled:
      return "filled";
    case TopologyChange::kCut:
      return "cut";
  }
  return "";
}

Json to_json(const std::vector<TopologyPlace>& places) {
  const auto index = [](const Index3& v) { return Json::array({v.x(), v.y(), v.z()}); };
  Json json = Json::array();
  for (const TopologyPlace& p : places)
    json.push_back({{"label", p.label},
                    {"change", name_of(p.change)},
                    {"words", in_words(p)},
                    {"centre_mm", point(p.centre_mm)},
                    {"box", {{"low", index(p.box.low)}, {"high", index(p.box.high)}}},
                    {"cells", p.cells},
                    {"voxels", p.voxels},
                    {"volume_mm3", p.volume_mm3},
                    {"handles", p.handles},
                    {"cavities", p.cavities}});
  return json;
}

Json to_json(const LabelEvaluation& label, const Evaluation& e) {
  Json json = {{"label", label.label},
               {"name", label.name},
               {"cells", label.cells},
               {"volume_mm3", label.volume_mm3},
               {"components", label.components},
               {"euler", label.euler},
               {"cavities", or_null(label.cavities())},
               {"handles", or_null(label.handles())},
               {"boundary", to_json(label.surface)}};
  if (label.image) {
    json["voxel_volume_mm3"] = label.image->volume_mm3;
    json["volume_error_percent"] = label.image_volume_error_percent();
    json["image"] = to_json(*label.image);
    if (label.voxels_kept) json["voxels_kept"] = to_json(*label.voxels_kept, e.image->voxel_size_mm);
    json["hausdorff_mm"] = to_json(label.distances);
  }
  if (label.reference) json["reference"] = reference_json(label, e);
  return json;
}

Json patches_json(const std::vector<PatchSummary>& patches) {
  Json json = Json::array();
  for (const PatchSummary& p : patches) {
    Json patch = {{"name", p.name},
                  {"kind", kind_word(p.kind, p.flow)},
                  {"faces", p.faces},
                  {"area_mm2", p.area_mm2},
                  {"smallest_angle_deg", p.smallest_angle_deg},
                  {"centre_mm", point(p.centre_mm)},
                  {"normal", point(p.normal)}};
    if (is_plane(p.kind)) patch["flatness_mm"] = p.flatness_mm;
    json.push_back(patch);
  }
  return json;
}

Json image_json(const Evaluation& e) {
  const ImageEvaluation& image = *e.image;
  const auto& size = image.frame.size;
  Json json = {{"size", Json::array({size.x(), size.y(), size.z()})},
               {"spacing_mm", point(image.frame.spacing_mm)},
               {"voxel_size_mm", image.voxel_size_mm},
               {"voxel_volume_mm3", image.all.volume_mm3},
               {"volume_error_percent", e.image_volume_error_percent()}};
  json.update(to_json(image.all));
  json["voxels_kept"] = to_json(image.voxels_kept, image.voxel_size_mm);
  json["background_voxels_kept"] = to_json(image.background_kept, image.voxel_size_mm);
  return json;
}

}  // namespace

std::string openings_json(const OpeningsCompared& openings) {
  return to_json(openings).dump();
}

std::string evaluation_json(const Evaluation& e) {
  const MeshStatistics& m = e.statistics;
  const TetrahedronStatistics& t = m.tetrahedra;
  Json json = {{"valid", e.valid()},
               {"warnings", e.warnings},
               {"problem_count", e.problem_count},
               {"problems", e.problems},
               {"unit", e.info.unit},
               {"frame", e.info.frame},
               {"provenance", e.info.provenance},
               {"vertices", m.vertices},
               {"tetrahedra", t.count},
               {"pyramids", m.pyramids},
               {"prisms", m.prisms},
               {"hexahedra", m.hexahedra},
               {"inverted", m.inverted_cells},
               {"bounding_box_mm", Json::array({point(m.low_mm), point(m.high_mm)})},
               {"mean_edge_mm", t.mean_edge_mm}};
  json["dihedral_deg"] = dihedral_json(t);
  json["mean_ratio"] = mean_ratio_json(t);
  json["aspect"] = {{"max", t.largest_aspect.value}, {"mean", t.mean_aspect}};
  add_metric_json(e, json);
  if (m.pyramids + m.prisms + m.hexahedra > 0)
    json["scaled_jacobian"] = {{"min", m.smallest_scaled_jacobian}};
  json["components"] = e.components;
  json["euler"] = e.euler;
  json["volume_mm3"] = e.volume_mm3();
  json["labels"] = Json::array();
  for (const LabelEvaluation& label : e.labels) json["labels"].push_back(to_json(label, e));
  json["boundary"] = to_json(e.boundary);
  json["boundary"]["patches"] = patches_json(e.patches);
  json["mean_curvature_per_mm"] = to_json(e.curvature);
  json["interface_triangles"] = e.interface_triangles;
  if (e.image) {
    json["image"] = image_json(e);
    json["hausdorff_mm"] = to_json(e.image->distances);
    json["topology_differences"] = e.topology_differences;
    json["topology_places"] = to_json(e.topology_places);
    json["openings"] = e.openings ? to_json(*e.openings) : Json(nullptr);
    json["narrowest_sections"] = e.sections ? to_json(*e.sections) : Json(nullptr);
  }
  if (e.reference_voxel_mm) json["reference"] = {{"voxel_size_mm", *e.reference_voxel_mm}};
  return json.dump(1) + "\n";
}

}  // namespace lumesh::report
