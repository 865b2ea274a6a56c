#include "passes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "lumesh/metric/measures.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

using operators::Outcome;

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
  void add_shortest_first(RankedEdge edge) {
    insert(edge, [](const RankedEdge& a, const RankedEdge& b) { return a.length < b.length; });
  }
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
  const auto most = rank == SplitRank::kCurves ? VertexDimension::kCurve : VertexDimension::kSurface;
  if (dimension(i) > most || dimension(j) > most) return false;
  for (int f = 0; f < 4; ++f)
    if (f != i && f != j && mesh.patch(t, f).valid()) return true;
  return false;
}

/// Where to cut an edge: its parts should have about unit length, and be two or a third and the rest.
double fraction_of(double length) {
  return std::lround(length) == 3 ? 1.0 / 3 : 0.5;
}

/// Works on the tetrahedron in slot i as long as `step` changes it, at most three times.
template <class Step>
void for_each_slot(TetMesh& mesh, const Step& step) {
  constexpr int kMostSteps = 3;
  const std::uint32_t slots = mesh.tet_slots();
  for (std::uint32_t i = 0; i < slots; ++i)
    for (int n = 0; n < kMostSteps && mesh.alive(TetId(i)); ++n)
      if (!step(TetId(i))) break;
}

}  // namespace

void split_long_edges(TetMesh& mesh, Kernel& kernel, double longest, SplitRank rank,
                      const operators::InsertionRules& rules) {
  for_each_slot(mesh, [&](TetId t) {
    EdgeList edges;
    for (int e = 0; e < 6; ++e) {
      if (!has_rank(mesh, t, e, rank)) continue;
      const double length = kernel.edge_length(t, kTetEdges[e][0], kTetEdges[e][1]);
      if (length > longest) edges.add_longest_first({length, e});
    }
    return std::any_of(edges.begin(), edges.end(), [&](const RankedEdge& one) {
      const auto [i, j] = kTetEdges[one.edge];
      return kernel.split_edge(t, i, j, fraction_of(one.length), rules) == Outcome::kApplied;
    });
  });
}

void collapse_short_edges(TetMesh& mesh, Kernel& kernel, double shortest,
                          const operators::CollapseRules& rules) {
  for_each_slot(mesh, [&](TetId t) {
    EdgeList edges;
    for (int e = 0; e < 6; ++e) {
      const double length = kernel.edge_length(t, kTetEdges[e][0], kTetEdges[e][1]);
      if (length < shortest) edges.add_shortest_first({length, e});
    }
    return std::any_of(edges.begin(), edges.end(), [&](const RankedEdge& one) {
      const auto [i, j] = kTetEdges[one.edge];
      return kernel.collapse_edge(t, i, j, rules) == Outcome::kApplied ||
             kernel.collapse_edge(t, j, i, rules) == Outcome::kApplied;
    });
  });
}

void reconnect(TetMesh& mesh, Kernel& kernel, double below, const operators::SwapRules& rules) {
  const std::uint32_t slots = mesh.tet_slots();
  const auto improve = [&](TetId t) {
    for (const auto& [i, j] : kTetEdges)
      if (kernel.remove_edge(t, i, j, rules) == Outcome::kApplied) return;
    for (int f = 0; f < 4; ++f)
      if (kernel.swap_face(t, f, rules) == Outcome::kApplied) return;
  };
  for (std::uint32_t i = 0; i < slots; ++i) {
    const TetId t(i);
    if (mesh.alive(t) && mesh.quality(t) < below) improve(t);
  }
}

void smooth(TetMesh& mesh, Kernel& kernel, const operators::SmoothingRules& rules) {
  const std::uint32_t slots = mesh.vertex_slots();
  for (std::uint32_t v = 0; v < slots; ++v)
    if (mesh.alive(VertexId(v)) && mesh.incident_tet(VertexId(v)).valid())
      kernel.smooth_vertex(VertexId(v), rules);
}

double longest_edge(const TetMesh& mesh) {
  constexpr std::size_t kBlock = 4096;
  return parallel::reduce_blocks<double>(
      mesh.tet_slots(), kBlock, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double longest = 0;
        for (std::size_t i = begin; i < end; ++i) {
          const TetId t(static_cast<std::uint32_t>(i));
          if (!mesh.alive(t)) continue;
          for (const auto& [k, l] : kTetEdges) {
            const VertexId a = mesh.vertex(t, k), b = mesh.vertex(t, l);
            longest = std::max(
                longest, metric::edge_length(mesh.point(a), mesh.metric(a), mesh.point(b), mesh.metric(b)));
          }
        }
        return longest;
      },
      [](double a, double b) { return std::max(a, b); });
}

}  // namespace lumesh
