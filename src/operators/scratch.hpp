#pragma once
/// @file The working memory of one thread's operators.

#include <cmath>

#include "angle_star.hpp"
#include "builder.hpp"
#include "cavity.hpp"
#include "links.hpp"
#include "lumesh/operators/kernel.hpp"
#include "neighbourhoods.hpp"
#include "star_shapes.hpp"
#include "tried_edges.hpp"
#include "uniform_star.hpp"

namespace lumesh::operators {

struct NearVertex {
  VertexId vertex;
  double length = 0;
};

/// Edges in the links of two vertices.
struct LinkEdges {
  std::vector<std::uint64_t> of_from, of_to;
};

struct Scratch {
  Scratch(TetMesh& mesh, int owner) : builder{mesh, owner} {}

  Builder builder;
  EdgeRing ring;
  VertexBall ball, other_ball;
  LinkEdges link_edges;
  Cavity cavity;
  std::vector<float> qualities;
  std::vector<NearVertex> near;
  StarShapes shapes;
  UniformStar uniform;
  AngleStar angles;
  TriedEdges tried_splits, tried_removals;  // Of this run, by EdgeSplit and TetReconnection.
};

/// Collapses v, which is held, onto `into`, a neighbour. Not counted.
Outcome collapse_held_vertex(auto& site, VertexId v, VertexId into, const CollapseRules& rules);

/// Quality cubed of the tetrahedron (a, b, c, d) of vertices of the mesh; -1 if it is flat, inverted or
/// refused.
[[nodiscard]] inline double quality_cubed(const ShapeMeasure& measure, const TetMesh& mesh, VertexId a,
                                          VertexId b, VertexId c, VertexId d) {
  if (measure.kind == ShapeMeasure::Kind::kDihedralAngles) {
    const double quality =
        angle_quality(mesh.point(a), mesh.point(b), mesh.point(c), mesh.point(d), measure.obtuse_weight);
    const bool is_fit =
        quality > 0 && !measure.refuses(mesh.point(a), mesh.point(b), mesh.point(c), mesh.point(d));
    return is_fit ? metric::cube(quality) : -1;
  }
  return metric::mean_ratio_cubed(mesh.point(a), mesh.point(b), mesh.point(c), mesh.point(d),
                                  mesh.log_metric(a), mesh.log_metric(b), mesh.log_metric(c),
                                  mesh.log_metric(d));
}

[[nodiscard]] inline double metric_length(const TetMesh& mesh, VertexId a, VertexId b) {
  return metric::edge_length(mesh.point(a), mesh.metric(a), mesh.point(b), mesh.metric(b));
}

/// Measures nothing where there is no bound.
[[nodiscard]] inline bool is_longer_than(double max_length, const TetMesh& mesh, VertexId a, VertexId b) {
  return std::isfinite(max_length) && metric_length(mesh, a, b) > max_length;
}

}  // namespace lumesh::operators
