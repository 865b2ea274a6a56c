#include "lumesh/quality/metric_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "extremes.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/metric_fault.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/metric/measures.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/key_table.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh::quality {

namespace {

constexpr std::size_t kVertexBlock = 4096, kTetrahedronBlock = 8192;

/// The corners of all tetrahedra by their vertex; corner c is vertex c % 4 of tetrahedron c / 4.
using CornersByVertex = parallel::KeyTable<std::uint32_t>;

CornersByVertex corners_by_vertex(const MeshView& mesh) {
  const std::size_t count = 4 * mesh.tetrahedra.size();
  LUMESH_ASSERT(count <= std::numeric_limits<std::uint32_t>::max());
  return {count, mesh.points.size(),
          [](std::size_t c, const auto& take) { take(static_cast<std::uint32_t>(c)); },
          [&](std::uint32_t c) { return mesh.tetrahedra[c / 4][c % 4]; }};
}

/// What the tetrahedra need of the metric, per point.
struct VertexMetrics {
  std::vector<SymTensor> log;
  std::vector<double> density;  ///< sqrt(det M) in 1/mm^3.
};

/// Vertices whose metric is none.
struct Refused {
  std::size_t first = 0;
  std::size_t count = 0;
};

/// Looks at the vertices of tetrahedra only: what other cells or no cells use may be without a metric.
VertexMetrics take_logarithms(const MeshView& mesh, const CornersByVertex& corners) {
  VertexMetrics result;
  result.log.resize(mesh.points.size());
  result.density.resize(mesh.points.size());
  const Refused refused = parallel::reduce(
      mesh.points.size(), kVertexBlock, Refused(),
      [&](Refused& part, std::size_t v) {
        if (corners.of(v).empty()) return;
        if (!is_metric(mesh.metric[v])) {
          if (part.count++ == 0) part.first = v;
          return;
        }
        result.log[v] = metric::log(mesh.metric[v]);
        result.density[v] = std::exp(result.log[v].trace() / 2);
      },
      [](const Refused& all, const Refused& more) {
        return Refused{all.count > 0 ? all.first : more.first, all.count + more.count};
      });
  if (refused.count > 0)
    throw Error(ErrorKind::kBadInput,
                "the metric at vertex " + std::to_string(refused.first) +
                    " is not finite and positive definite (vertices with such a metric: " +
                    std::to_string(refused.count) + "); repair the metric");
  return result;
}

/// Starts where minima and histograms can be lowered and added to; means are still sums.
MetricStatistics empty_tally() {
  MetricStatistics tally;
  tally.shortest_edge = tally.smallest_mean_ratio.value = std::numeric_limits<double>::infinity();
  tally.edge_length = {0, 2 * std::numbers::sqrt2, std::vector<std::uint64_t>(80, 0)};
  tally.mean_ratio = {0, 1, std::vector<std::uint64_t>(50, 0)};
  return tally;
}

void join(EdgeBand& all, const EdgeBand& more) {
  all.edges += more.edges;
  all.short_edges += more.short_edges;
  all.long_edges += more.long_edges;
}

MetricStatistics joined(MetricStatistics all, const MetricStatistics& more) {
  join(all, more);
  if (all.free_edges && more.free_edges)
    join(*all.free_edges, *more.free_edges);
  else if (more.free_edges)
    all.free_edges = more.free_edges;
  all.shortest_edge = std::min(all.shortest_edge, more.shortest_edge);
  all.longest_edge = std::max(all.longest_edge, more.longest_edge);
  all.mean_edge += more.mean_edge;
  all.edge_length.merge(more.edge_length);
  lower(all.smallest_mean_ratio, more.smallest_mean_ratio.value, more.smallest_mean_ratio.tetrahedron);
  all.mean_mean_ratio += more.mean_mean_ratio;
  all.poor_tetrahedra += more.poor_tetrahedra;
  all.mean_ratio.merge(more.mean_ratio);
  all.complexity += more.complexity;
  all.vertices += more.vertices;
  all.tetrahedra += more.tetrahedra;
  return all;
}

void count_in_band(EdgeBand& band, double length) {
  ++band.edges;
  band.short_edges += length < metric::kShortestUnit;
  band.long_edges += length > metric::kLongestUnit;
}

void count_edge(MetricStatistics& tally, double length) {
  count_in_band(tally, length);
  tally.shortest_edge = std::min(tally.shortest_edge, length);
  tally.longest_edge = std::max(tally.longest_edge, length);
  tally.mean_edge += length;
  tally.edge_length.add(length);
}

/// Which points are on boundary faces; empty if the view has none.
std::vector<std::uint8_t> boundary_points(const MeshView& mesh) {
  if (mesh.triangles.empty() && mesh.quadrilaterals.empty()) return {};
  std::vector<std::uint8_t> on_boundary(mesh.points.size(), 0);
  for_each_patch_face(mesh, [&](const auto& face, std::int32_t) {
    for (const std::uint32_t v : face) on_boundary[v] = 1;
  });
  return on_boundary;
}

/// Counts each edge at its lower vertex, so that no list of all edges is needed.
MetricStatistics measure_edges(const MeshView& mesh, const CornersByVertex& corners) {
  const std::vector<std::uint8_t> on_boundary = boundary_points(mesh);
  return parallel::reduce_blocks(
      mesh.points.size(), kVertexBlock, empty_tally(),
      [&](std::size_t begin, std::size_t end) {
        MetricStatistics part = empty_tally();
        EdgeBand free_edges;
        std::vector<std::uint32_t> above;  // The vertex's neighbours of higher index.
        for (std::size_t v = begin; v < end; ++v) {
          above.clear();
          for (const std::uint32_t corner : corners.of(v))
            for (const std::uint32_t other : mesh.tetrahedra[corner / 4])
              if (other > v) above.push_back(other);
          sort_unique(above);
          for (const std::uint32_t w : above) {
            const double length =
                metric::edge_length(mesh.points[v], mesh.metric[v], mesh.points[w], mesh.metric[w]);
            count_edge(part, length);
            if (!on_boundary.empty() && !(on_boundary[v] && on_boundary[w]))
              count_in_band(free_edges, length);
          }
          part.vertices += !corners.of(v).empty();
        }
        if (!on_boundary.empty()) part.free_edges = free_edges;
        return part;
      },
      joined);
}

MetricStatistics measure_shapes(const MeshView& mesh, const VertexMetrics& metrics) {
  return parallel::reduce(
      mesh.tetrahedra.size(), kTetrahedronBlock, empty_tally(),
      [&](MetricStatistics& part, std::size_t i) {
        const auto [p, q, r, s] = mesh.tetrahedra[i];
        const Vec3 &a = mesh.points[p], &b = mesh.points[q], &c = mesh.points[r], &d = mesh.points[s];
        const double ratio =
            metric::mean_ratio(a, b, c, d, metrics.log[p], metrics.log[q], metrics.log[r], metrics.log[s]);
        ++part.tetrahedra;
        lower(part.smallest_mean_ratio, ratio, static_cast<std::uint32_t>(i));
        part.mean_mean_ratio += ratio;
        part.poor_tetrahedra += ratio < kPoorMeanRatio;
        part.mean_ratio.add(ratio);
        part.complexity +=
            tetrahedron_volume(a, b, c, d) / 4 *
            (metrics.density[p] + metrics.density[q] + metrics.density[r] + metrics.density[s]);
      },
      joined);
}

}  // namespace

MetricStatistics measure_in_metric(const MeshView& mesh) {
  LUMESH_ASSERT(!mesh.tetrahedra.empty());
  if (mesh.metric.size() != mesh.points.size())
    throw Error(ErrorKind::kBadInput, "the mesh has " + std::to_string(mesh.metric.size()) + " metrics for " +
                                          std::to_string(mesh.points.size()) +
                                          " points; give each point one");
  const CornersByVertex corners = corners_by_vertex(mesh);
  const VertexMetrics metrics = take_logarithms(mesh, corners);
  MetricStatistics result = joined(measure_edges(mesh, corners), measure_shapes(mesh, metrics));
  // A mesh whose every tetrahedron is a single point has no edges.
  if (result.edges == 0) result.shortest_edge = 0;
  result.mean_edge /= static_cast<double>(std::max<std::uint64_t>(1, result.edges));
  result.mean_mean_ratio /= static_cast<double>(result.tetrahedra);
  locate(result.smallest_mean_ratio, mesh);
  return result;
}

}  // namespace lumesh::quality
