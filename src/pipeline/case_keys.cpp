#include "case_keys.hpp"

#include <map>

namespace lumesh::pipeline {
namespace {

constexpr double kAny = std::numeric_limits<double>::infinity();
constexpr double kTiny = 1e-12;  // The least number that is more than none.

/// Collects the keys of one section after the other.
class KeyList {
 public:
  void section(std::string name) { section_ = std::move(name); }

  void key(std::string name, KeyTarget target, std::string meaning) {
    number(std::move(name), std::move(target), -kAny, kAny, std::move(meaning));
  }
  void number(std::string name, KeyTarget target, double least, double most, std::string meaning) {
    keys_.push_back({section_, std::move(name), "", std::move(target), least, most, std::move(meaning)});
  }
  /// Another name for the key before, mostly the paper's.
  void alias(std::string name) { keys_.back().alias = std::move(name); }

  template <class Enum>
  void choice(std::string name, Enum& chosen, std::vector<std::string> words, std::string meaning) {
    key(std::move(name),
        Choice{std::move(words), [&chosen] { return static_cast<std::size_t>(chosen); },
               [&chosen](std::size_t i) { chosen = static_cast<Enum>(i); }},
        std::move(meaning));
  }

  [[nodiscard]] std::vector<Key> take() { return std::move(keys_); }

 private:
  std::string section_;
  std::vector<Key> keys_;
};

void add_input_keys(KeyList& list, InputKeys& input) {
  list.section("input");
  list.key("image", FilePath{&input.image, {}}, "Label image: NIfTI, NRRD, MetaImage, GIPL, DICOM folder");
  list.key("surface", FilePath{&input.surface, {}}, "Or a closed surface: .stl, .vtp, .mesh, .msh");
  list.key("phantom", &input.phantom, "Or a synthetic image: carotid, bifurcation, layered, sphere, torus");
  list.number("phantom_size", &input.phantom_spec.size, 0, 2048,
              "Voxels of the phantom; 0: the kind's default");
  list.number("phantom_spacing", &input.phantom_spec.spacing_mm, 0, kAny, "Their size in mm; 0: the default");
  list.number("phantom_noise", &input.phantom_spec.noise_voxels, 0, 2, "Voxels by which its boundary moves");
  list.key("labels", &input.selection.labels, "Labels of the image to mesh; empty: all");
  list.key("threshold", &input.selection.threshold,
           "Voxels at or above become label 1, the rest background; their values place the boundary");
  list.key("below", &input.selection.below, "The same for voxels at or below");
  list.key("probabilities", FilePath{&input.selection.probabilities, {}},
           "Image of the object's probability, 0 to 1, on the image's grid, which places the boundary");
  list.key("largest_component", &input.selection.largest_component, "Only the largest connected piece");
  list.key("cut_planes", &input.cuts.planes,
           "Planes [x, y, z, nx, ny, nz] in mm that cut off their normal's side");
  list.key("cut_at", &input.cuts.places_mm,
           "Places [x, y, z] in mm: the vessel there is cut square to its axis, and its smaller part goes");
  list.choice("boundary", input.field.fidelity, {"smooth", "exact"},
              "Voxels that noise explains better may change side, or every one keeps its side");
  list.number("feature_angle", &input.feature_angle_deg, 1, 180,
              "Degrees from which edges of a surface are kept");
}

void add_lattice_keys(KeyList& list, LatticeOptions& o) {
  list.section("lattice");
  list.number("spacing", &o.spacing_mm, 0, kAny, "Lattice spacing at the boundary in mm; 0: edge_length");
  list.number("fidelity", &o.fidelity, 0.1, 0.98,
              "The spacing is at most 4 (1 - fidelity) times the half thickness");
  list.number("coarsening", &o.coarsening, 0, 4, "Times the spacing may double inside");
  list.number("max_refinement", &o.max_refinement, 0, 5, "Times it may halve in thin parts");
  list.number("max_tetrahedra", &o.max_tetrahedra, 1, kAny,
              "Refinement of thin parts is given up to stay near this");
  list.number("min_dihedral", &o.min_dihedral_deg, 1, 25, "Floor of the dihedral angles in degrees");
  list.number("max_dihedral", &o.max_dihedral_deg, 130, 175, "Ceiling of the dihedral angles in degrees");
}

void add_delaunay_keys(KeyList& list, Case& c) {
  DelaunayOptions& o = c.delaunay;
  list.section("delaunay");
  list.number("delta", &o.delta_mm, 0, kAny, "Spacing of points on surfaces in mm; 0: edge_length / 1.3");
  list.number("size", &o.size_mm, 0, kAny, "Largest edge length inside in mm; 0: 1.3 delta");
  list.number("surface_distance", &o.surface_distance_mm, 0, kAny,
              "How far triangles may stand off a bent surface, in mm; 0: delta decides");
  list.number("radius_edge", &o.radius_edge, 1.5, kAny, "Largest circumradius per shortest edge");
  list.number("facet_angle", &o.facet_angle_deg, 0, 30, "Smallest angle of boundary triangles in degrees");
  list.choice("seeding", o.seeding, {"lattice", "surface", "few"}, "What refinement begins with");
  list.key("size_points", FilePath{&c.sizes.points, {"centerline"}},
           "Sizes grow with the distance to these points: a file, or \"centerline\"");
  list.number("size_factor", &c.sizes.factor, kTiny, kAny, "So many times that distance");
  list.number("size_floor", &c.sizes.floor_mm, 0, kAny, "But never less than this, in mm");
  list.number("size_ceiling", &c.sizes.ceiling_mm, 0, kAny, "Nor more than this, in mm; 0: no bound");
  list.key("sizing", FilePath{&c.sizes.plugin, {}}, "A sizing plugin, PATH[:OPTIONS]");
  list.key("improve", &c.improves, "Better the dihedral angles afterwards");
  list.number("min_dihedral", &c.improvement.min_dihedral_deg, 1, 60,
              "Improvement raises smaller dihedral angles, in degrees");
  list.number("max_dihedral", &c.improvement.max_dihedral_deg, 90, 179, "And lowers larger ones");
}

void add_metric_keys(KeyList& list, MetricKeys& metric) {
  list.section("metric");
  list.key("points", FilePath{&metric.points, {"centerline"}},
           "Ellipsoids around the nearest of these points: a file, or \"centerline\"");
  list.number("k", &metric.neighbours, 1, 10000, "So many nearest points");
  list.key("velocity", FilePath{&metric.velocity, {"phantom"}},
           "Stretched along the flow: a file with velocities, or \"phantom\"");
  list.key("velocity_array", &metric.velocity_array, "Name of the array; empty: velocity, or the only one");
  list.number("velocity_k", &metric.velocity_neighbours, 3, 10000,
              "So many nearest samples; 3 is the paper's");
  list.key("curvature", &metric.curvature, "Fine where the surface bends");
  list.number("min_size", &metric.smallest_mm, 0, kAny, "No size below this, in mm; 0: no bound");
  list.number("max_size", &metric.largest_mm, 0, kAny, "No size above this, in mm; 0: no bound");
  list.number("max_aspect", &metric.largest_aspect, 0, kAny,
              "Largest ratio of sizes at a point; 0: no bound");
  list.number("gradation", &metric.gradation, 0, kAny,
              "Sizes grow at most by this factor per unit edge, > 1; 0: no bound");
  list.key("frozen_sizes", &metric.frozen_sizes,
           "Near a surface that is not adapted, sizes go over to those of its triangles");
  list.number("complexity", &metric.complexity, 0, kAny,
              "Sizes are scaled to this complexity, about half the vertices; 0: as they are");
}

void add_adapt_keys(KeyList& list, Case& c) {
  AdaptOptions& o = c.adapt;
  list.section("adapt");
  list.choice("boundary", c.boundary.boundary, {"frozen", "adapt"},
              "Keep the surface as it is, or adapt it along the image's boundary");
  list.alias("sref");
  list.number("feature_angle", &c.boundary.feature_angle_deg, 1, 180,
              "Degrees from which patches keep their creases");
  list.key("allow_pieces", &c.boundary.allows_pieces, "Take meshes of several pieces, too");
  list.number("split_above", &o.split_above, 1, 3, "Edges longer than this, in the metric, are split");
  list.alias("cdff");
  list.number("collapse_below", &o.collapse_below, 0.1, 0.8, "Shorter edges are collapsed");
  list.number("least_length", &o.least_length, 0.1, 0.8, "Least distance of a new point to others");
  list.alias("cdfn");
  list.number("quality_passes", &o.quality_passes, 0, 1000, "Passes for quality");
  list.alias("nqual");
  list.number("smoothing_passes", &o.smoothing_passes, 0, 1000, "Smoothings at the end of each of them");
  list.alias("nsmth");
  list.number("reconnect_below", &o.reconnect_below, 0, 1, "Mean ratio of the tetrahedra to reconnect");
  list.choice("placement", o.placement, {"edge", "centroid"}, "Where new points of the volume are put");
  list.choice("reconnection", o.reconnection, {"original", "optimised"},
              "Try all tetrahedra again, or those whose surroundings changed");
  list.choice("execution", o.execution, {"ordered", "speculative"},
              "The same bits for every number of threads, or locks");
  list.choice("balance", o.team.balance, {"none", "first-idle", "hierarchical", "stealing"},
              "Who gives work to idle threads");
  list.key("pin", &o.team.pin, "Keep every thread on its processor");
}

void add_layer_keys(KeyList& list, LayerKeys& layers) {
  LayerOptions& o = layers.options;
  list.section("layers");
  list.number("first_height", &o.first_height, 0, kAny,
              "Height of the layer next to the surface; 0: no layers");
  list.alias("blds");
  list.choice("relative_to", o.scale, {"mm", "radius", "edge"},
              "What heights are in: mm, times the local radius, or times the edges around");
  list.key("patches", &o.patches, "On which patches; empty: all walls");
  list.alias("patch");
  list.choice("side", o.side, {"outward", "inward"}, "Around the mesh, or within it, where it gives way");
  list.number(
      "into", &o.into, 0, kAny,
      "Inwards, of an image of several labels: the one that gives way; 0: the only one at the patches");
  list.number("growth", &o.growth, kTiny, kAny, "Height of each layer through that before");
  list.alias("blr");
  list.number("growth_rise", &o.growth_rise, 1, kAny,
              "Factor of the growth itself per layer, after those of constant growth");
  list.alias("bldr");
  list.number("constant_layers", &o.constant_layers, 1, 200,
              "Layers of constant growth, before the growth itself rises");
  list.alias("bli");
  list.number("most_growth", &o.most_growth, kTiny, kAny, "Bound of the growth that rises");
  list.alias("blrm");
  list.number("count", &o.count, 0, 200, "Number of layers; 0: what the thickness asks for");
  list.alias("nbl");
  list.number("thickness", &o.thickness, 0, kAny,
              "Of all layers, met exactly by the growth; 0: what the count makes");
  list.choice("cells", o.cells, {"prisms", "tetrahedra"}, "Prisms, or three tetrahedra for each");
  list.key("split_openings", &o.splits_openings,
           "The ring of layers around an opening becomes a patch of its own");
  list.key("label", &layers.label,
           "Label of the layers: NAME=NUMBER, NAME or NUMBER; empty: the next free one");
}

void add_opening_keys(KeyList& list, OpeningKeys& openings) {
  list.section("openings");
  list.key("names", &openings.names,
           "\"PATCH=NAME\", such as \"outlet_2=left_ica\", \"X,Y,Z=NAME\" for the one near a place in mm, "
           "\"AREAmm2=NAME\" for the one of about that area; NAME:KIND makes it an inlet, outlet, wall or "
           "symmetry");
}

void add_output_keys(KeyList& list, Case& c) {
  list.section("output");
  list.key("folder", FilePath{&c.output.folder, {}},
           "Where all files go; empty: a folder of the case's name");
  list.key("meshes", &c.output.meshes,
           "The last mesh, in the format of each name: .vtu, .vtk, .mesh, .meshb, .msh, .foam, .xdmf, "
           "NAME-mesh-complete");
  list.key("surface", &c.output.surface, "Its boundary: .vtp, .stl; empty: not written");
  list.key("report", &c.output.report, "Report with plots and pictures (.html); empty: not written");
  list.key("json", &c.output.json, "All numbers (.json); empty: not written");
  list.key("stages", &c.output.stages, "Write the centerline and the first mesh with its metric, too");
  list.section("run");
  list.number("threads", &c.run.threads, 0, 4096, "0: all cores");
  list.number("time_limit", &c.run.time_limit_s, 0, kAny,
              "Seconds after which the best mesh so far is written; 0: none");
  list.key("checkpoints", &c.run.checkpoints, "Keep what every stage leaves, for `lumesh run --resume`");
}

}  // namespace

std::vector<Key> keys_of(Case& c) {
  KeyList list;
  list.choice("mesher", c.mesher, {"lattice", "delaunay"},
              "What makes the first mesh; delaunay also of surfaces and with sizes");
  list.number("edge_length", &c.edge_length_mm, 0, kAny,
              "Of edges on surfaces of the first mesh, in mm; 0: 2.5 voxels");
  list.number("cells_per_diameter", &c.cells_per_diameter, 0, 25,
              "About so many edges along the diameter of each vessel, or more where edge_length is shorter; "
              "0: no such wish");
  add_input_keys(list, c.input);
  add_lattice_keys(list, c.lattice);
  add_delaunay_keys(list, c);
  list.section("centerline");
  list.key("make", &c.centerline.is_wanted, "Make it even if no stage needs it");
  list.number("spacing", &c.centerline.spacing_mm, 0, kAny,
              "Distance of its points in mm; 0: follows the radius");
  add_metric_keys(list, c.metric);
  add_adapt_keys(list, c);
  add_layer_keys(list, c.layers);
  add_opening_keys(list, c.openings);
  add_output_keys(list, c);
  return list.take();
}

std::string section_meaning(const std::string& section) {
  static const std::map<std::string, std::string> kMeanings = {
      {"input", "What is meshed: one of image, surface, phantom"},
      {"lattice", "The first mesh, with mesher = \"lattice\""},
      {"delaunay", "The first mesh, with mesher = \"delaunay\""},
      {"centerline", "Axes of the vessels with their radii"},
      {"metric", "Sizes and directions of the elements; without a source the first mesh is the last"},
      {"adapt", "Adaptation of the first mesh to the metric"},
      {"layers", "Boundary layers of the last mesh; without first_height there are none"},
      {"openings", "Names of patches in the files"},
      {"output", "Files"},
      {"run", "How it runs"}};
  const auto found = kMeanings.find(section);
  return found == kMeanings.end() ? "" : found->second;
}

}  // namespace lumesh::pipeline
