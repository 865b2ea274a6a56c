#include "passes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/metric/measures.hpp"
#include "lumesh/operators/operators.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/relaxed.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh {
namespace {

using operators::CentroidInsertion, operators::EdgeSplit, operators::Outcome, operators::TetReconnection,
    operators::Thinning, operators::VertexCollapse, operators::VertexSmoothing;

struct RankedEdge {
  double length;
  int edge;  // Of kTetEdges.
};

/// Edges of a tetrahedron that a sweep wants, in the order of a key; equal ones as they came.
class EdgeList {
 public:
  void add_longest_first(RankedEdge edge) {
    insert(edge, [](const RankedEdge& a, const RankedEdge& b) { return a.length > b.length; });
  }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] const RankedEdge* begin() const { return edges_.data(); }
  [[nodiscard]] const RankedEdge* end() const { return edges_.data() + count_; }

 private:
  template <class Before>
  void insert(const RankedEdge& edge, const Before& before) {
    std::size_t place = count_++;
    for (; place > 0 && before(edge, edges_[place - 1]); --place) edges_[place] = edges_[place - 1];
    edges_[place] = edge;
  }

  std::array<RankedEdge, 6> edges_;
  std::size_t count_ = 0;
};

/// True if the edge lies on a patch's face of t; for curves, on faces of two patches of t. A curve whose
/// faces belong to different tetrahedra is found with the surfaces.
bool has_rank(const TetMesh& mesh, TetId t, int edge, SplitRank rank) {
  if (rank == SplitRank::kAll) return true;
  const auto [i, j] = kTetEdges[edge];
  const auto dimension = [&](int k) { return mesh.dimension(mesh.vertex(t, k)); };
  const auto max_dimension = rank == SplitRank::kCurves ? VertexDimension::kCurve : VertexDimension::kSurface;
  if (dimension(i) > max_dimension || dimension(j) > max_dimension) return false;
  for (int f = 0; f < 4; ++f)
    if (f != i && f != j && mesh.patch(t, f).valid()) return true;
  return false;
}

/// Where to cut an edge: its parts should have about unit length, and be two or a third and the rest.
double fraction_of(double length) {
  return std::lround(length) == 3 ? 1.0 / 3 : 0.5;
}

/// The squares of an edge's length in the metrics of its ends; its length lies between the two.
struct EndLengths {
  double smaller, larger;
};

EndLengths squared_lengths_of(const TetMesh& mesh, TetId t, int edge) {
  const VertexId a = mesh.vertex(t, kTetEdges[edge][0]), b = mesh.vertex(t, kTetEdges[edge][1]);
  const Vec3 along = mesh.point(b) - mesh.point(a);
  const double at_a = mesh.metric(a).quadratic(along), at_b = mesh.metric(b).quadratic(along);
  return {std::min(at_a, at_b), std::max(at_a, at_b)};
}

double length_of(const EndLengths& squared) {
  return metric::logarithmic_mean(std::sqrt(squared.smaller), std::sqrt(squared.larger));
}

/// An edge much too long is worse than a short one: the point that splits it may come nearer to others.
operators::InsertionRules rules_for(double length, double longest, operators::InsertionRules rules) {
  constexpr double kMin = 0.35;
  const double factor = std::min(1.0, metric::kLongestUnit * longest / length);
  rules.min_length = std::max(std::min(kMin, rules.min_length), factor * rules.min_length);
  return rules;
}

EdgeList long_edges(const operators::Subject& subject, TetId t, double longest, double arc_weight,
                    SplitRank rank) {
  const TetMesh& mesh = subject.mesh;
  EdgeList edges;
  for (int e = 0; e < 6; ++e) {
    if (!has_rank(mesh, t, e, rank)) continue;
    const EndLengths squared = squared_lengths_of(mesh, t, e);
    double length = squared.larger <= longest * longest ? 0 : length_of(squared);
    if (arc_weight > 0 && length <= longest && has_rank(mesh, t, e, SplitRank::kSurfaces)) {
      const auto [i, j] = kTetEdges[e];
      length = arc_weight * operators::arc_height(mesh, t, i, j, subject.shapes);
    }
    if (length > longest) edges.add_longest_first({length, e});
  }
  return edges;
}

/// The length of each vertex's shortest edge where that is shorter than `shortest`, else `shortest`.
std::vector<float> nearest_below(const TetMesh& mesh, double shortest) {
  std::vector<float> nearest(mesh.vertex_slots(), static_cast<float>(shortest));
  for_each_tet(mesh, [&](TetId t) {
    for (int e = 0; e < 6; ++e) {
      const EndLengths squared = squared_lengths_of(mesh, t, e);
      if (squared.smaller >= shortest * shortest) continue;
      const auto length = static_cast<float>(length_of(squared));
      for (const int k : kTetEdges[e]) parallel::lower_to(nearest[mesh.vertex(t, k).value], length);
    }
  });
  return nearest;
}

}  // namespace

template <operators::Execution Execution>
void Passes<Execution>::split_long_edges(double longest, double arc_weight, SplitRank rank,
                                         PointPlacement placement,
                                         const operators::InsertionRules& rules) const {
  const bool at_centroids = placement == PointPlacement::kCentroid && rank == SplitRank::kAll;
  execution.for_each_tet_by_priority(
      [&](TetId t) {
        const EdgeList edges = long_edges(subject, t, longest, arc_weight, rank);
        return edges.empty() ? 0 : edges.begin()->length;
      },
      [&](auto& kernel, TetId t) {
        const EdgeList edges = long_edges(subject, t, longest, arc_weight, rank);
        if (at_centroids && !edges.empty() &&
            kernel.apply(CentroidInsertion{rules_for(edges.begin()->length, longest, rules)}, t) ==
                Outcome::kApplied)
          return;
        for (const RankedEdge& one : edges) {
          const auto [i, j] = kTetEdges[one.edge];
          const EdgeSplit split{fraction_of(one.length), rules_for(one.length, longest, rules)};
          if (kernel.apply(split, {t, i, j}) == Outcome::kApplied) return;
        }
      });
}

template <operators::Execution Execution>
void Passes<Execution>::collapse_short_edges(double shortest, const operators::CollapseRules& rules) const {
  const std::vector<float> nearest = nearest_below(subject.mesh, shortest);
  execution.for_each_vertex_by_priority(
      [&](VertexId v) {
        return static_cast<float>(shortest) - nearest[v.value];
      },  // 0 where none is shorter.
      [&](auto& kernel, VertexId v) {
        kernel.apply(VertexCollapse{shortest, rules}, v);
      });
}

template <operators::Execution Execution>
void Passes<Execution>::thin_out(const operators::ThinningRules& rules) const {
  std::vector<std::uint8_t> kept(subject.mesh.vertex_slots(), 0);
  execution.for_each_vertex_by_priority([](VertexId /*v*/) { return 1.0; },
                                        [&](auto& kernel, VertexId v) {
                                          kernel.apply(Thinning{kept, rules}, v);
                                        });
}

template <operators::Execution Execution>
void Passes<Execution>::reconnect(double below, Reconnection which, operators::SwapRules rules) const {
  const TetMesh& mesh = subject.mesh;
  rules.repeat = which == Reconnection::kOriginal;
  execution.for_each_tet_by_priority(
      [&](TetId t) {
        const double priority = below - mesh.quality(t);
        return priority <= 0 || which == Reconnection::kOriginal ||
                       operators::has_changed_since_trial(mesh, t, operators::kVerticesOfAnEdge)
                   ? priority
                   : 0;
      },
      [&](auto& kernel, TetId t) { kernel.apply(TetReconnection{rules}, t); });
}

template <operators::Execution Execution>
void Passes<Execution>::improve_worst(double below, operators::SwapRules swaps,
                                      const operators::SmoothingRules& smoothing) const {
  const TetMesh& mesh = subject.mesh;
  swaps.repeat = true;  // Vertices move in between.
  execution.for_each_tet_by_priority(
      [&](TetId t) {
        const double priority = below - mesh.quality(t);
        return priority <= 0 || operators::has_changed_since_trial(mesh, t) ? priority : 0;
      },
      [&](auto& kernel, TetId t) {
        if (kernel.apply(TetReconnection{swaps}, t) == Outcome::kApplied) return;
        for (int k = 0; k < 4; ++k) kernel.apply(VertexSmoothing{smoothing}, mesh.vertex(t, k));
      });
}

template <operators::Execution Execution>
void Passes<Execution>::smooth(const operators::SmoothingRules& rules) const {
  execution.for_each_vertex([&](auto& kernel, VertexId v) { kernel.apply(VertexSmoothing{rules}, v); });
}

template struct Passes<operators::OrderedExecution>;
template struct Passes<operators::SpeculativeExecution>;

double longest_edge(const TetMesh& mesh) {
  constexpr std::size_t kBlock = 4096;
  return parallel::max_of(mesh.tet_slots(), kBlock, 0.0, [&](std::size_t i) {
    const TetId t(static_cast<std::uint32_t>(i));
    if (!mesh.alive(t)) return 0.0;
    double longest = 0;
    for (int e = 0; e < 6; ++e) longest = std::max(longest, length_of(squared_lengths_of(mesh, t, e)));
    return longest;
  });
}

}  // namespace lumesh
