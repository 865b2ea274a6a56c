#include "interior_deformation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <optional>

#include "lumesh/adapt/keep.hpp"
#include "lumesh/core/angles.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/mesh/vertex_neighbours.hpp"
#include "lumesh/metric/measures.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/operators/operators.hpp"
#include "lumesh/operators/ordered_execution.hpp"
#include "lumesh/operators/patch_shapes.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::layers {
namespace {

TetMesh copy_of(const TetMesh& mesh, const BoundaryFaces& faces) {
  return TetMesh::build(mesh.points(), mesh.tets(), mesh.labels(), PatchTable{faces.triangles, faces.patches},
                        mesh.info());
}

/// Sizes as they are in all directions, averaged with those around.
TetMesh with_sizes(TetMesh mesh, const BoundaryFaces& faces) {
  constexpr int kSweeps = 2;
  const parallel::Adjacency neighbours = vertex_neighbours(mesh);
  std::vector<SymTensor> logs = own_metric(copy_of(mesh.view(faces))), next(logs.size());
  parallel::for_each_index(logs.size(), [&](std::size_t v) { logs[v] = metric::log(logs[v]); });
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    parallel::for_each_index(logs.size(), [&](std::size_t v) {
      next[v] = logs[v];
      for (const std::uint32_t w : neighbours.of(v)) next[v] = next[v] + logs[w];
      next[v] = (1 / (1 + static_cast<double>(neighbours.of(v).size()))) * next[v];
    });
    logs.swap(next);
  }
  mesh.enable_metric();
  parallel::for_each_index(logs.size(), [&](std::size_t v) {
    mesh.set_metric(VertexId(static_cast<std::uint32_t>(v)), metric::exp(logs[v]), logs[v]);
  });
  return mesh;
}

using Bits = std::array<std::uint64_t, 3>;
Bits bits_of(const Vec3& p) {
  const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x + 0.0); };  // -0 is 0.
  return {bits(p.x()), bits(p.y()), bits(p.z())};
}

std::vector<std::pair<Bits, std::uint32_t>> surface_vertices_by_place(const TetMesh& mesh) {
  std::vector<std::pair<Bits, std::uint32_t>> known;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.dimension(VertexId(v)) != VertexDimension::kVolume)
      known.emplace_back(bits_of(mesh.point(VertexId(v))), v);
  parallel::sort(known.begin(), known.end());
  return known;
}

/// Vertices are told by their places.
void check_places(const TetMesh& mesh) {
  const auto known = surface_vertices_by_place(mesh);
  const auto twice =
      std::ranges::adjacent_find(known, [](const auto& a, const auto& b) { return a.first == b.first; });
  if (twice == known.end()) return;
  throw Error(ErrorKind::kBadInput, fmt::format("two vertices of the surface lie at {} mm; "
                                                "move them apart, or make them one",
                                                coordinates_text(mesh.point(VertexId(twice->second)))));
}

constexpr std::uint32_t kNoColumn = ~0u;
constexpr std::int32_t kNoPatch = -1, kSeveral = -2;

}  // namespace

InteriorDeformation::InteriorDeformation(const TetMesh& mesh, const BoundaryFaces& faces,
                                         const ExtrusionFrame& frame)
    : frame_(frame),
      field_(metric::MetricField::uniform(1)),
      at_first_(dihedral_range(mesh, {})),
      mesh_(copy_of(mesh, faces)) {
  check_places(mesh_);
  vertices_ = frame.surface.vertices;
  reached_mm_.assign(vertices_.size(), 0);
  take_sizes(with_sizes(copy_of(mesh, faces), faces));
}

/// @param sized  The same mesh with the sizes it has.
void InteriorDeformation::take_sizes(TetMesh sized) {
  mesh_.enable_metric();
  parallel::for_each_index(mesh_.vertex_count(), [&](std::size_t i) {
    const VertexId v(static_cast<std::uint32_t>(i));
    mesh_.set_metric(v, sized.metric(v), sized.log_metric(v));
  });
  for (std::uint32_t t = 0; t < mesh_.tet_count(); ++t)
    for (int k = 0; k < 4; ++k) mesh_.set_metric_hint(mesh_.vertex(TetId(t), k), TetId(t));
  field_ = metric::MetricField::on_background(std::move(sized));
}

/// Whatever go_to() does makes no vertex: from here on their numbers stay.
void InteriorDeformation::begin() {
  metric::measure_qualities(mesh_);
  execution_.emplace(operators::Subject{mesh_, field_, frame_.surface.shapes}, parallel::TeamOptions{});
  find_columns();
  followers_ = followers();
}

void InteriorDeformation::go_to(const Columns& columns, int steps) {
  if (!execution_) begin();
  for (int step = steps; step > 0; --step) {
    std::vector<double> goals(reached_mm_.size());
    for (std::size_t v = 0; v < goals.size(); ++v) {
      const double wanted = columns.length_mm(v);
      goals[v] = step == 1 ? wanted : reached_mm_[v] + (wanted - reached_mm_[v]) / step;
    }
    if (goals == reached_mm_) continue;
    const std::vector<Vec3> before(mesh_.points().begin(), mesh_.points().end());
    move(goals);
    measure(before);
    improve_interior();
  }
}

/// Interfaces between labels follow as the interior does.
std::vector<InteriorDeformation::Follower> InteriorDeformation::followers() const {
  std::vector<Follower> all(mesh_.vertex_count());
  std::vector<std::int32_t> outer_patch(all.size(), kNoPatch);
  const BoundaryFaces faces = mesh_.boundary_faces();
  for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
    if (faces.tets[f][1].valid()) continue;
    for (const std::uint32_t v : faces.triangles[f])
      outer_patch[v] =
          outer_patch[v] == kNoPatch || outer_patch[v] == faces.patches[f] ? faces.patches[f] : kSeveral;
  }
  for (std::size_t v = 0; v < all.size(); ++v) {
    if (outer_patch[v] == kNoPatch) continue;
    all[v].kind = Follower::kFixed;
    if (outer_patch[v] == kSeveral) continue;
    const operators::PatchShape& shape = frame_.surface.shapes[static_cast<std::size_t>(outer_patch[v])];
    if (shape.freedom == operators::PatchFreedom::kPlane) all[v] = {Follower::kInPlane, shape.normal};
  }
  for (const std::uint32_t v : vertices_) all[v].kind = Follower::kLed;
  return all;
}

/// Where all vertices would go: those of columns as told, the others as their neighbours do on average.
std::vector<Vec3> InteriorDeformation::displacements(const std::vector<double>& goals_mm) const {
  constexpr int kSweeps = 60;
  const parallel::Adjacency neighbours = vertex_neighbours(mesh_);
  std::vector<Vec3> now(mesh_.vertex_slots(), Vec3::Zero());
  for (std::size_t v = 0; v < vertices_.size(); ++v)
    now[vertices_[v]] = frame_.end(v, goals_mm[v]) - frame_.end(v, reached_mm_[v]);
  std::vector<Vec3> next = now;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    parallel::for_each_index(now.size(), [&](std::size_t v) {
      if (followers_[v].kind == Follower::kLed || followers_[v].kind == Follower::kFixed) return;
      Vec3 sum = Vec3::Zero();
      for (const std::uint32_t w : neighbours.of(v)) sum += now[w];
      next[v] = sum / static_cast<double>(neighbours.of(v).size());
      if (followers_[v].kind == Follower::kInPlane)
        next[v] -= followers_[v].normal.dot(next[v]) * followers_[v].normal;
    });
    now.swap(next);
  }
  return now;
}

/// Moves everything by as much of its way as keeps all tetrahedra positive.
void InteriorDeformation::move(const std::vector<double>& goals_mm) {
  constexpr int kHalvings = 6;
  const std::vector<Vec3> way = displacements(goals_mm);
  std::vector<std::uint32_t> column(mesh_.vertex_slots(), kNoColumn);
  for (std::uint32_t v = 0; v < vertices_.size(); ++v) column[vertices_[v]] = v;
  std::vector<double> share(mesh_.vertex_slots(), 1);
  const auto length_of = [&](std::uint32_t c) {
    const double of_way = share[vertices_[c]];  // Goals are met to the last bit.
    return of_way == 1 ? goals_mm[c] : reached_mm_[c] + of_way * (goals_mm[c] - reached_mm_[c]);
  };
  const auto place = [&](std::uint32_t v) -> Vec3 {
    if (column[v] != kNoColumn) return frame_.end(column[v], length_of(column[v]));
    return share[v] == 0 ? mesh_.point(VertexId(v)) : Vec3(mesh_.point(VertexId(v)) + share[v] * way[v]);
  };
  std::vector<Vec3> places(mesh_.vertex_slots());
  for (int round = 0;; ++round) {
    parallel::for_each_index(places.size(),
                             [&](std::size_t v) { places[v] = place(static_cast<std::uint32_t>(v)); });
    std::vector<std::uint8_t> stays_back(mesh_.vertex_slots(), 0);
    std::uint8_t any = 0;
    parallel::for_each_index(mesh_.tet_slots(), [&](std::size_t t) {
      const Cell<4>& c = mesh_.tets()[t];
      if (!mesh_.alive(TetId(static_cast<std::uint32_t>(t)))) return;
      if (share[c[0]] == 0 && share[c[1]] == 0 && share[c[2]] == 0 && share[c[3]] == 0) return;
      if (orient3d(places[c[0]], places[c[1]], places[c[2]], places[c[3]]) > 0) return;
      for (const std::uint32_t v : c) parallel::raise(stays_back[v]);
      parallel::raise(any);
    });
    if (any == 0) break;
    for (std::size_t v = 0; v < share.size(); ++v)
      if (stays_back[v] != 0) share[v] = round < kHalvings ? 0.5 * share[v] : 0;
  }
  for (std::uint32_t v = 0; v < places.size(); ++v)
    if (mesh_.alive(VertexId(v))) mesh_.set_point(VertexId(v), places[v]);
  for (std::uint32_t c = 0; c < vertices_.size(); ++c) reached_mm_[c] = length_of(c);
}

/// Metrics and qualities after a move; no vertex has gone far from where its metric was found.
/// @param before  Places of the vertices before it: what has not moved keeps its metric.
void InteriorDeformation::measure(std::span<const Vec3> before) {
  parallel::for_each_index(mesh_.vertex_slots(), [&](std::size_t i) {
    const VertexId v(static_cast<std::uint32_t>(i));
    if (!mesh_.alive(v) || mesh_.point(v) == before[i]) return;
    metric::MetricField::Hint hint = mesh_.metric_hint(v);
    const metric::MetricPair here = field_.at(mesh_.point(v), hint);
    mesh_.set_metric(v, here.metric, here.log);
    mesh_.set_metric_hint(v, hint);
  });
  metric::measure_qualities(mesh_);
}

/// Improves the mesh within its surface, where it has become poor.
void InteriorDeformation::improve_interior() {
  constexpr double kShort = 0.6, kPoor = 0.6;
  const std::vector<std::uint8_t> at_short =
      flags_at_tets([&](TetId t) { return has_short_edge(t, kShort); });
  execution_->for_each_vertex_by_priority(
      [&](VertexId v) { return at_short[v.value] != 0 ? 1.0 : 0.0; },
      [&](auto& kernel, VertexId v) { kernel.apply(operators::VertexCollapse{kShort}, v); });
  execution_->repartition();
  execution_->for_each_tet_by_priority(
      [&](TetId t) { return kPoor - mesh_.quality(t); },
      [](auto& kernel, TetId t) { kernel.apply(operators::TetReconnection{}, t); });
  const std::vector<std::uint8_t> at_poor = flags_at_tets([&](TetId t) { return mesh_.quality(t) < kPoor; });
  execution_->for_each_vertex_by_priority(
      [&](VertexId v) { return at_poor[v.value] != 0 ? 1.0 : 0.0; },
      [](auto& kernel, VertexId v) { kernel.apply(operators::VertexSmoothing{}, v); });
  execution_->repartition();
}

/// One flag per vertex: whether a tetrahedron around it is such.
std::vector<std::uint8_t> InteriorDeformation::flags_at_tets(
    const std::function<bool(TetId)>& is_such) const {
  std::vector<std::uint8_t> flags(mesh_.vertex_slots(), 0);
  for_each_tet(mesh_, [&](TetId t) {
    if (!is_such(t)) return;
    for (int k = 0; k < 4; ++k) parallel::raise(flags[mesh_.vertex(t, k).value]);
  });
  return flags;
}

/// Whether a tetrahedron has an edge shorter than this in the metric.
bool InteriorDeformation::has_short_edge(TetId t, double min_length) const {
  return std::ranges::any_of(kTetEdges, [&](const auto& edge) {
    const VertexId a = mesh_.vertex(t, edge[0]), b = mesh_.vertex(t, edge[1]);
    return metric::edge_length(mesh_.point(a), mesh_.metric(a), mesh_.point(b), mesh_.metric(b)) < min_length;
  });
}

/// Vertices of the surface stay where they are to the last bit, which tells them again.
void InteriorDeformation::find_columns() {
  const std::vector<std::pair<Bits, std::uint32_t>> known = surface_vertices_by_place(mesh_);
  for (std::size_t v = 0; v < vertices_.size(); ++v) {
    const Bits bits = bits_of(frame_.end(v, reached_mm_[v]));
    const auto found = std::ranges::lower_bound(known, std::pair{bits, std::uint32_t{0}});
    LUMESH_ASSERT(found != known.end() && found->first == bits);
    vertices_[v] = found->second;
  }
}

void InteriorDeformation::improve() {
  constexpr double kMinDeg = 12, kMaxDeg = 165;  // A mesh that is stretched on purpose has worse ones.
  constexpr int kPasses = 3;
  Context context;
  execution_.reset();
  lumesh::improve(mesh_,
                  {.min_dihedral_deg = std::clamp(at_first_.min_deg, 1.0, kMinDeg),
                   .max_dihedral_deg = std::clamp(at_first_.max_deg, kMaxDeg, 179.0),
                   .passes = kPasses,
                   .slide = false,
                   .sizes = field_},
                  context);
  find_columns();
}

std::vector<std::uint8_t> InteriorDeformation::columns_at_poor_tets() const {
  constexpr double kFloorDeg = 2.5;  // As for the layers' own cells.
  const double floor_deg = std::min({kFloorDeg, at_first_.min_deg, 180 - at_first_.max_deg});
  const double cosine = cosine_deg(floor_deg);
  const std::vector<std::uint8_t> at_poor = flags_at_tets([&](TetId t) {
    const DihedralCosines angles =
        min_max_dihedral(mesh_.corner(t, 0), mesh_.corner(t, 1), mesh_.corner(t, 2), mesh_.corner(t, 3));
    return angles.largest_cosine > cosine || angles.smallest_cosine < -cosine;
  });
  std::vector<std::uint8_t> flags(vertices_.size());
  for (std::size_t v = 0; v < flags.size(); ++v) flags[v] = at_poor[vertices_[v]];
  return flags;
}

namespace {

/// Shortens columns to where the mesh is. False if all are there.
bool shorten_to_reached(const InteriorDeformation& deformation, bool is_patient, Columns& columns) {
  bool any = false;
  for (std::size_t v = 0; v < columns.fraction.size(); ++v) {
    const double length = columns.length_mm(v), reached = deformation.reached_mm(v);
    if (reached == length) continue;
    any = true;
    columns.shorten(v, is_patient ? reached : 0, LayerLimit::kRoom);
  }
  return any;
}

/// Shortens columns that make the mesh poor. False if there are none.
bool shorten_at_poor_tets(const InteriorDeformation& deformation, Columns& columns) {
  constexpr double kShorter = 0.75;
  const std::vector<std::uint8_t> is_poor = deformation.columns_at_poor_tets();
  bool any = false;
  for (std::size_t v = 0; v < is_poor.size(); ++v) {
    if (is_poor[v] == 0 || columns.fraction[v] == 0) continue;
    any = true;
    columns.shorten(v, kShorter * columns.length_mm(v), LayerLimit::kRoom);
  }
  return any;
}

}  // namespace

Core deform_interior(const TetMesh& mesh, const BoundaryFaces& faces, const ExtrusionFrame& frame,
                     Columns& columns) {
  constexpr int kSteps = 4, kPatientTries = 6;
  std::optional<InteriorDeformation> deformation(std::in_place, mesh, faces, frame);
  for (int attempt = 0;; ++attempt) {
    const bool is_patient = attempt < kPatientTries;
    deformation->go_to(columns, attempt == 0 || !is_patient ? kSteps : kSteps / 2);
    Columns shorter = columns;
    if (!shorten_to_reached(*deformation, is_patient, shorter)) {
      deformation->improve();
      if (!is_patient || !shorten_at_poor_tets(*deformation, shorter)) return std::move(*deformation).core();
    }
    smooth_lengths(frame.surface, shorter);
    keep_cells_well_shaped(frame, shorter);
    columns = std::move(shorter);
    // Otherwise restart from the initial mesh; columns only shrink from then on, so that the loop ends.
    if (attempt + 1 >= kPatientTries) deformation.emplace(mesh, faces, frame);
  }
}

}  // namespace lumesh::layers
