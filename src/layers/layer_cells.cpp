#include "layer_cells.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "lumesh/mesh/parts.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/parallel/loops.hpp"
#include "prism.hpp"

namespace lumesh::layers {
namespace {

/// Adds the layers to a copy of the mesh.
class LayerBuilder {
 public:
  LayerBuilder(const Footing& footing, const ExtrusionFrame& frame, const Columns& columns,
               const LayerOptions& options)
      : mesh_(footing.mesh),
        faces_(footing.faces),
        selection_(footing.selection),
        vertices_(footing.vertices),
        metric_(footing.metric),
        frame_(frame),
        surface_(frame.surface),
        columns_(columns),
        options_(options),
        is_inward_(options.side == LayerSide::kInward),
        label_(options.label) {
    for (std::uint32_t v = 0; v < surface_.points.size(); ++v) counts_.push_back(columns.count(v));
  }

  MixedMesh build() {
    copy_mesh();
    add_points();
    copy_faces();
    for (std::uint32_t t = 0; t < surface_.triangles.size(); ++t) add_column(t);
    for (const RimEdge& edge : surface_.rim) add_side(edge);
    if (metric_) add_metric();
    return std::move(out_);
  }

 private:
  [[nodiscard]] bool has_layer(std::uint32_t v, int k) const { return k < counts_[v]; }
  [[nodiscard]] int layers_over(const Cell<3>& c) const {
    return std::max({counts_[c[0]], counts_[c[1]], counts_[c[2]]});
  }
  /// Number of the upper end of layer k of a column, or of its last one. One end of it is the mesh's own
  /// vertex: the lower one, or inwards the upper one.
  [[nodiscard]] std::uint32_t point(std::uint32_t v, int k) const {
    k = std::min(k, counts_[v] - 1);
    if (k == (is_inward_ ? counts_[v] - 1 : -1)) return vertices_[v];
    return first_[v] + static_cast<std::uint32_t>(is_inward_ ? k + 1 : k);
  }

  void copy_mesh() {
    out_ = copy_of(mesh_.view(faces_));
    out_.metric.clear();
    out_.triangles.clear();
    out_.triangle_patches.clear();
    const std::span<const Label> labels = mesh_.labels();
    is_new_label_ = std::ranges::find(labels, label_) == labels.end();
    if (!options_.label_name.empty())
      out_.info.label_names[label_] = options_.label_name;
    else if (is_new_label_)
      out_.info.label_names[label_] = free_label_name(is_inward_ ? "layer" : "vessel_wall");
  }
  [[nodiscard]] std::string free_label_name(const std::string& usual) const {
    const auto is_taken = [&](const auto& entry) { return entry.second == usual; };
    const bool taken = std::ranges::any_of(out_.info.label_names, is_taken);
    return taken ? fmt::format("{}_{}", usual, label_) : usual;
  }
  void add_points() {
    first_.assign(surface_.points.size(), 0);
    for (std::uint32_t v = 0; v < surface_.points.size(); ++v) {
      first_[v] = static_cast<std::uint32_t>(out_.points.size());
      const int first = is_inward_ ? -1 : 0;
      for (int k = first; k < first + counts_[v]; ++k) out_.points.push_back(frame_.point(columns_, v, k));
    }
  }

  void add_metric() {
    std::vector<std::uint32_t> feet(out_.points.size());
    std::iota(feet.begin(), feet.end(), 0);
    for (std::uint32_t v = 0; v < vertices_.size(); ++v)
      std::fill_n(feet.begin() + first_[v], counts_[v], vertices_[v]);
    out_.metric.resize(feet.size());
    parallel::for_each_index(
        feet.size(), 64, [&](std::size_t i) { out_.metric[i] = metric_(out_.points[i], VertexId(feet[i])); });
  }

  /// A new patch; where one of the mesh has the name, with a number behind it.
  std::int32_t patch_named(const std::string& name, PatchKind kind, std::array<Label, 2> labels) {
    const auto [place, is_new] =
        patch_numbers_.try_emplace(name, static_cast<std::int32_t>(out_.info.patches.size()));
    if (is_new) out_.info.patches.push_back({free_patch_name(out_.info.patches, name), kind, labels});
    return place->second;
  }
  /// Faces of the mesh; those under layers become interfaces where the layers' label is another than the
  /// mesh's. Parts of a patch that stay unlayered get a patch of their own, unless nothing is behind it.
  void copy_faces() {
    std::vector<std::uint8_t> at_layers(mesh_.vertex_count(), 0), at_columns(mesh_.vertex_count(), 0);
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
      at_columns[vertices_[v]] = 1;
      at_layers[vertices_[v]] = has_layer(v, 0) ? 1 : 0;
    }
    for (std::size_t f = 0; f < faces_.triangles.size(); ++f) {
      const Cell<3>& c = faces_.triangles[f];
      const auto patch = static_cast<std::size_t>(faces_.patches[f]);
      const bool unlayered = std::ranges::none_of(c, [&](std::uint32_t v) { return at_layers[v] != 0; });
      if (selection_.layered[patch] == 0) {
        add_face(c, faces_.patches[f]);
        continue;
      }
      if (is_inward_ && !unlayered) stand_on_layers(patch, mesh_.label(faces_.tets[f][0]));
      if (unlayered)
        add_face(c, patch_of_unlayered(patch));
      else if (const Label inside = mesh_.label(faces_.tets[f][0]);
               inside != label_)  // Else there is no face.
        add_face(c, patch_under_layers(patch, inside));
    }
  }
  /// Inwards the wall keeps its place, and what is behind it now are the layers.
  void stand_on_layers(std::size_t patch, Label inside) {
    for (Label& label : out_.info.patches[patch].labels)
      if (label == inside) label = label_;
  }
  std::int32_t patch_of_unlayered(std::size_t patch) {
    const Patch whole = mesh_.info().patches[patch];
    const bool is_same = is_inward_ && selection_.between[patch] == 0;
    return is_same ? static_cast<std::int32_t>(patch)
                   : patch_named(whole.name + "_bare", PatchKind::kWall, whole.labels);
  }
  /// @param inside  Label of the cell of the mesh there. A patch around several keeps its name at the first.
  std::int32_t patch_under_layers(std::size_t patch, Label inside) {
    const std::array<Label, 2> labels = {std::min(inside, label_), std::max(inside, label_)};
    const auto [first, is_new] = first_labels_.try_emplace(is_inward_ ? ~std::size_t{0} : patch, inside);
    const std::string name = is_inward_ ? "layer_inner" : mesh_.info().patches[patch].name;
    if (first->second != inside)
      return patch_named(fmt::format("{}_{}", name, inside), PatchKind::kInterface, labels);
    if (is_inward_) return patch_named(name, PatchKind::kInterface, labels);
    out_.info.patches[patch].kind = PatchKind::kInterface;
    out_.info.patches[patch].labels = labels;
    return static_cast<std::int32_t>(patch);
  }
  void add_face(const Cell<3>& c, std::int32_t patch) {
    out_.triangles.push_back(c);
    out_.triangle_patches.push_back(patch);
  }

  void add_column(std::uint32_t t) {
    const Cell<3>& c = surface_.triangles[t];
    const int layers = layers_over(c);
    if (layers == 0) return;
    const auto tets = tetrahedra_of_prism(c);
    for (int k = 0; k < layers; ++k) {
      if (options_.cells == LayerCells::kPrisms)
        add_prism(c, k);
      else
        for (const PrismTet& tet : tets) add_tet(c, tet, k);
    }
    if (is_inward_)
      add_face({point(c[0], -1), point(c[2], -1), point(c[1], -1)}, surface_.patches[t]);
    else
      add_face({point(c[0], layers - 1), point(c[1], layers - 1), point(c[2], layers - 1)},
               patch_named("layer_outer", PatchKind::kWall, {label_, kBackground}));
  }
  void add_tet(const Cell<3>& c, const PrismTet& tet, int k) {
    if (!has_layer(c[doubled_column(tet)], k)) return;
    Cell<4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = point(c[tet[i].column], tet[i].upper != 0 ? k : k - 1);
    out_.tetrahedra.push_back(corners);
    out_.tetrahedron_labels.push_back(label_);
  }
  /// A prism, or the pyramid or tetrahedron that is left where columns do not have this layer.
  void add_prism(Cell<3> c, int k) {
    const auto has = [&](std::uint32_t v) { return has_layer(v, k); };
    const auto columns = std::ranges::count_if(c, has);
    const auto turn_until = [&](const auto& good) {
      while (!good()) std::rotate(c.begin(), c.begin() + 1, c.end());
    };
    const auto low = [&](std::size_t i) { return point(c[i], k - 1); };
    const auto up = [&](std::size_t i) { return point(c[i], k); };
    if (columns == 3) {
      out_.prisms.push_back({low(0), low(2), low(1), up(0), up(2), up(1)});
      out_.prism_labels.push_back(label_);
    } else if (columns == 2) {
      turn_until([&] { return !has(c[2]); });
      out_.pyramids.push_back({low(0), up(0), up(1), low(1), low(2)});
      out_.pyramid_labels.push_back(label_);
    } else {
      turn_until([&] { return has(c[0]); });
      out_.tetrahedra.push_back({low(0), low(1), low(2), up(0)});
      out_.tetrahedron_labels.push_back(label_);
    }
  }

  /// The faces of the layers over an edge of the rim, seen from outside anticlockwise.
  void add_side(const RimEdge& edge) {
    const int layers = std::max(counts_[edge.a], counts_[edge.b]);
    if (layers == 0) return;
    const bool is_ring = edge.patch >= 0 && surface_.planes[edge.a].count > 0 &&
                         is_plane(mesh_.info().patches[static_cast<std::size_t>(edge.patch)].kind);
    const std::int32_t patch = is_ring ? patch_of_ring(edge.patch)
                                       : patch_named("layer_side", PatchKind::kWall, {label_, kBackground});
    for (int k = 0; k < layers; ++k) add_side(edge, k, patch);
  }
  std::int32_t patch_of_ring(std::int32_t opening) {
    const bool is_wall_around = !is_inward_ && is_new_label_;
    if (!options_.splits_openings && !is_wall_around) return opening;
    const Patch& of = mesh_.info().patches[static_cast<std::size_t>(opening)];
    const std::int32_t ring = patch_named(of.name + "_layer", of.kind, {label_, kBackground});
    out_.info.patches[static_cast<std::size_t>(ring)].flow = of.flow;
    return ring;
  }
  void add_side(const RimEdge& edge, int k, std::int32_t patch) {
    const std::uint32_t a = point(edge.a, k - 1), b = point(edge.b, k - 1), up_a = point(edge.a, k),
                        up_b = point(edge.b, k);
    const bool has_a = has_layer(edge.a, k), has_b = has_layer(edge.b, k);
    if (has_a && has_b && options_.cells == LayerCells::kPrisms) {
      out_.quadrilaterals.push_back({a, b, up_b, up_a});
      out_.quadrilateral_patches.push_back(patch);
      return;
    }
    if (!has_a) return add_face({a, b, up_b}, patch);
    if (!has_b) return add_face({a, b, up_a}, patch);
    const bool from_a = edge.a < edge.b;  // Diagonals as those of tetrahedra_of_prism().
    add_face({a, b, from_a ? up_b : up_a}, patch);
    add_face({from_a ? a : b, up_b, up_a}, patch);
  }

  const TetMesh& mesh_;
  const BoundaryFaces& faces_;
  const PatchSelection& selection_;
  const std::vector<std::uint32_t>& vertices_;
  const MetricAtFoot& metric_;
  const ExtrusionFrame& frame_;
  const LayerSurface& surface_;
  const Columns& columns_;
  const LayerOptions& options_;
  bool is_inward_;
  bool is_new_label_ = true;
  Label label_;
  std::vector<int> counts_;           // Of each column's layers.
  std::vector<std::uint32_t> first_;  // Of each column's own points.
  std::map<std::string, std::int32_t> patch_numbers_;
  std::map<std::size_t, Label> first_labels_;  // Under the layers of each patch.
  MixedMesh out_;
};

}  // namespace

MixedMesh with_layers(const Footing& footing, const ExtrusionFrame& frame, const Columns& columns,
                      const LayerOptions& options) {
  return LayerBuilder(footing, frame, columns, options).build();
}

}  // namespace lumesh::layers
