#include "give_way.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <map>

#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/metric/measures.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/operators/ordered_execution.hpp"
#include "lumesh/operators/patch_shapes.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::layers {
namespace {

constexpr int kSteps = 4;

TetMesh copy_of(const TetMesh& mesh, const BoundaryFaces& faces) {
  return TetMesh::build(mesh.points(), mesh.tets(), mesh.labels(), PatchTable{faces.triangles, faces.patches},
                        mesh.info());
}

/// Neighbours of every vertex along edges.
Lists neighbours_of(const TetMesh& mesh) {
  auto pairs =
      parallel::collect<std::uint64_t>(mesh.tet_count(), [&](std::size_t t, std::vector<std::uint64_t>& out) {
        const Cell<4>& c = mesh.tets()[t];
        for (const auto& [i, j] : kTetEdges) {
          const std::uint64_t a = c[static_cast<std::size_t>(i)], b = c[static_cast<std::size_t>(j)];
          out.push_back(a << 32 | b);
          out.push_back(b << 32 | a);
        }
      });
  return lists_of(std::move(pairs), mesh.vertex_count());
}

/// Sizes as they are: the mean length of the edges around each vertex, in all directions.
metric::MetricField sizes_of(TetMesh mesh) {
  const Lists neighbours = neighbours_of(mesh);
  mesh.enable_metric();
  parallel::for_each_index(mesh.vertex_count(), [&](std::size_t v) {
    const VertexId vertex(static_cast<std::uint32_t>(v));
    double sum = 0;
    for (const std::uint32_t w : neighbours.of(v))
      sum += (mesh.point(VertexId(w)) - mesh.point(vertex)).norm();
    const double size = sum / static_cast<double>(neighbours.of(v).size());
    const SymTensor metric = (1 / (size * size)) * SymTensor::diagonal(1, 1, 1);
    mesh.set_metric(vertex, metric, metric::log(metric));
  });
  return metric::MetricField::on_background(std::move(mesh));
}

/// How a vertex may follow.
struct Follower {
  enum Kind : std::uint8_t { kFree, kInPlane, kFixed, kLed } kind = kFree;
  Vec3 normal = Vec3::Zero();  ///< Of the plane.
};

class Yielding {
 public:
  Yielding(const TetMesh& mesh, const BoundaryFaces& faces, const Growth& growth, const Columns& columns)
      : growth_(growth), columns_(columns), field_(sizes_of(copy_of(mesh, faces))) {
    core_.mesh = copy_of(mesh, faces);
    core_.vertices = growth.surface.vertices;
    core_.reached.assign(core_.vertices.size(), 0);
  }

  Core run() {
    for (int step = 1; step <= kSteps; ++step) {
      move(static_cast<double>(step) / kSteps);
      mend();
    }
    return std::move(core_);
  }

 private:
  [[nodiscard]] Vec3 end_of(std::size_t v, double share) const {
    return growth_.surface.points[v] + (columns_.length_mm(v) * share) * growth_.directions.of[v];
  }

  [[nodiscard]] std::vector<Follower> followers() const {
    const TetMesh& mesh = core_.mesh;
    std::vector<Follower> all(mesh.vertex_count());
    for (std::uint32_t v = 0; v < all.size(); ++v)
      if (mesh.dimension(VertexId(v)) != VertexDimension::kVolume) all[v].kind = Follower::kFixed;
    const operators::PatchShapes shapes = operators::planes_where_flat(mesh);
    const BoundaryFaces faces = mesh.boundary_faces();
    for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
      const operators::PatchShape& shape = shapes[static_cast<std::size_t>(faces.patches[f])];
      if (shape.freedom != operators::PatchFreedom::kPlane) continue;
      for (const std::uint32_t v : faces.triangles[f])
        if (mesh.dimension(VertexId(v)) == VertexDimension::kSurface)
          all[v] = {Follower::kInPlane, shape.normal};
    }
    for (const std::uint32_t v : core_.vertices) all[v].kind = Follower::kLed;
    return all;
  }

  /// Where all vertices would go: those of columns as told, the others as their neighbours do on average.
  [[nodiscard]] std::vector<Vec3> displacements(double target) const {
    constexpr int kSweeps = 60;
    const TetMesh& mesh = core_.mesh;
    const std::vector<Follower> how = followers();
    const Lists neighbours = neighbours_of(mesh);
    std::vector<Vec3> now(mesh.vertex_count(), Vec3::Zero());
    for (std::size_t v = 0; v < core_.vertices.size(); ++v)
      now[core_.vertices[v]] = end_of(v, target) - end_of(v, core_.reached[v]);
    std::vector<Vec3> next = now;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      parallel::for_each_index(now.size(), [&](std::size_t v) {
        if (how[v].kind == Follower::kLed || how[v].kind == Follower::kFixed) return;
        Vec3 sum = Vec3::Zero();
        for (const std::uint32_t w : neighbours.of(v)) sum += now[w];
        next[v] = sum / static_cast<double>(neighbours.of(v).size());
        if (how[v].kind == Follower::kInPlane) next[v] -= how[v].normal.dot(next[v]) * how[v].normal;
      });
      now.swap(next);
    }
    return now;
  }

  /// Moves everything by as much of its way as keeps all tetrahedra positive.
  void move(double target) {
    constexpr int kHalvings = 6;
    TetMesh& mesh = core_.mesh;
    const std::vector<Vec3> way = displacements(target);
    std::vector<std::uint32_t> column(mesh.vertex_count(), kNoColumn);
    for (std::uint32_t v = 0; v < core_.vertices.size(); ++v) column[core_.vertices[v]] = v;
    std::vector<double> share(mesh.vertex_count(), 1);
    const auto place = [&](std::uint32_t v) -> Vec3 {
      const std::uint32_t c = column[v];
      if (c != kNoColumn) return end_of(c, core_.reached[c] + share[v] * (target - core_.reached[c]));
      return share[v] == 0 ? mesh.point(VertexId(v)) : Vec3(mesh.point(VertexId(v)) + share[v] * way[v]);
    };
    for (int round = 0;; ++round) {
      std::vector<std::uint8_t> stays_back(mesh.vertex_count(), 0);
      std::uint8_t any = 0;
      parallel::for_each_index(mesh.tet_count(), [&](std::size_t t) {
        const Cell<4>& c = mesh.tets()[t];
        if (share[c[0]] == 0 && share[c[1]] == 0 && share[c[2]] == 0 && share[c[3]] == 0) return;
        if (orient3d(place(c[0]), place(c[1]), place(c[2]), place(c[3])) > 0) return;
        for (const std::uint32_t v : c) parallel::raise(stays_back[v]);
        parallel::raise(any);
      });
      if (any == 0) break;
      for (std::size_t v = 0; v < share.size(); ++v)
        if (stays_back[v] != 0) share[v] = round < kHalvings ? 0.5 * share[v] : 0;
    }
    std::vector<Vec3> places(mesh.vertex_count());
    for (std::uint32_t v = 0; v < places.size(); ++v) places[v] = place(v);
    for (std::uint32_t v = 0; v < places.size(); ++v) mesh.set_point(VertexId(v), places[v]);
    for (std::size_t v = 0; v < core_.vertices.size(); ++v)
      core_.reached[v] += share[core_.vertices[v]] * (target - core_.reached[v]);
  }

  /// Betters the mesh within its surface. The vertices are numbered anew.
  void mend() {
    constexpr int kRounds = 2;
    constexpr double kShort = 0.6, kPoor = 0.6;
    TetMesh& mesh = core_.mesh;
    metric::assign_vertex_metrics(mesh, field_);
    metric::measure_qualities(mesh);
    operators::PatchShapes shapes = operators::planes_where_flat(mesh);
    operators::OrderedExecution execution({mesh, field_, shapes}, {});
    for (int round = 0; round < kRounds; ++round) {
      execution.over_urgent_vertices(
          [](VertexId) { return 1.0; },
          [&](auto& kernel, VertexId v) { kernel.collapse_vertex(v, kShort, {}); });
      execution.repartition();
      execution.over_tets([&](TetId t) { return kPoor - mesh.quality(t); },
                          [](auto& kernel, TetId t) { kernel.reconnect(t, {}); });
      execution.over_vertices([](auto& kernel, VertexId v) { kernel.smooth_vertex(v, {}); });
      execution.repartition();
    }
    mesh.reorder_along_curve();
    find_columns();
  }

  using Bits = std::array<std::uint64_t, 3>;
  static Bits bits_of(const Vec3& p) {
    return {std::bit_cast<std::uint64_t>(p.x()), std::bit_cast<std::uint64_t>(p.y()),
            std::bit_cast<std::uint64_t>(p.z())};
  }
  /// Vertices of the surface stay where they are to the last bit, which tells them again.
  void find_columns() {
    const TetMesh& mesh = core_.mesh;
    std::vector<std::pair<Bits, std::uint32_t>> known;
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
      if (mesh.dimension(VertexId(v)) != VertexDimension::kVolume)
        known.emplace_back(bits_of(mesh.point(VertexId(v))), v);
    parallel::sort(known.begin(), known.end());
    for (std::size_t v = 0; v < core_.vertices.size(); ++v) {
      const Bits bits = bits_of(end_of(v, core_.reached[v]));
      const auto found = std::lower_bound(known.begin(), known.end(), std::pair{bits, std::uint32_t{0}});
      LUMESH_ASSERT(found != known.end() && found->first == bits);
      core_.vertices[v] = found->second;
    }
  }

  static constexpr std::uint32_t kNoColumn = ~0u;
  const Growth& growth_;
  const Columns& columns_;
  metric::MetricField field_;
  Core core_;
};

}  // namespace

Core give_way(const TetMesh& mesh, const BoundaryFaces& faces, const Growth& growth, const Columns& columns) {
  return Yielding(mesh, faces, growth, columns).run();
}

}  // namespace lumesh::layers
