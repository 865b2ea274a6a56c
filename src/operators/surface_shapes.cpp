#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "area_means.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/operators/patch_shapes.hpp"
#include "lumesh/operators/sagittas.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::operators {
namespace {

/// The faces of one patch, as triangles of points of its own.
struct PatchTriangles {
  std::vector<Vec3> points;
  std::vector<Cell<3>> triangles;  // Anticlockwise from outside.
};

/// Vertices of the mesh to those of a patch.
using OwnNumbers = std::map<std::uint32_t, std::uint32_t>;

/// The circle that fits points of a plane best: centre c and radius r that make the sum of
/// (|p|^2 - 2 c p - (r^2 - |c|^2))^2 least, linear in c and r^2 - |c|^2. Source: Kasa 1976,
/// doi:10.1109/TIM.1976.6312298.
Vec3 circle_through(const std::vector<Vec3>& points, const Vec3& u, const Vec3& v) {
  Mat3 sums = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (const Vec3& p : points) {
    const Vec3 row(2 * p.dot(u), 2 * p.dot(v), 1);
    sums += row * row.transpose();
    right += (row[0] * row[0] + row[1] * row[1]) / 4 * row;
  }
  const Vec3 found = sums.fullPivLu().solve(right);
  return {found[0], found[1], std::sqrt(std::max(0.0, found[2] + found.head<2>().squaredNorm()))};
}

/// A cylinder while it is being fitted.
struct CylinderFit {
  Vec3 on_axis, axis;
  double radius;

  [[nodiscard]] double residual(const Vec3& point) const {
    return (point - on_axis).cross(axis).norm() - radius;
  }
  [[nodiscard]] double worst(const std::vector<Vec3>& points) const {
    double worst = 0;
    for (const Vec3& p : points) worst = std::max(worst, std::abs(residual(p)));
    return worst;
  }
};

CylinderFit cylinder_along(const Vec3& axis, const std::vector<Vec3>& points) {
  const Vec3 u = axis.unitOrthogonal(), v = axis.cross(u);
  const Vec3 circle = circle_through(points, u, v);
  return {circle[0] * u + circle[1] * v, axis, circle[2]};
}

/// One Gauss-Newton step on the squares of the residuals, for the axis' place, direction and the radius.
CylinderFit better(const CylinderFit& fit, const std::vector<Vec3>& points) {
  using Vec5 = Eigen::Matrix<double, 5, 1>;
  const Vec3 u = fit.axis.unitOrthogonal(), v = fit.axis.cross(u);
  Eigen::Matrix<double, 5, 5> sums = Eigen::Matrix<double, 5, 5>::Zero();
  Vec5 right = Vec5::Zero();
  for (const Vec3& p : points) {
    const Vec3 from_axis = p - fit.on_axis;
    const double along = from_axis.dot(fit.axis);
    const Vec3 radial = (from_axis - along * fit.axis).normalized();
    const double ru = radial.dot(u), rv = radial.dot(v);
    const Vec5 row = (Vec5() << -ru, -rv, -along * ru, -along * rv, -1).finished();
    sums += row * row.transpose();
    right -= fit.residual(p) * row;
  }
  const Vec5 step = sums.fullPivLu().solve(right);
  return {fit.on_axis + step[0] * u + step[1] * v, (fit.axis + step[2] * u + step[3] * v).normalized(),
          fit.radius + step[4]};
}

/// The axis of the frame that a direction hardly differs from, or the direction.
Vec3 nearly_axis(const Vec3& direction) {
  constexpr double kNearly = 1e-7;
  for (int k = 0; k < 3; ++k)
    if ((direction.cwiseAbs() - Vec3::Unit(k)).norm() < kNearly) return Vec3::Unit(k);
  return direction;
}

/// The cylinder on which all points lie to within `allowed`.
std::optional<CylinderFit> fit_cylinder(const PatchTriangles& patch, double allowed) {
  constexpr std::size_t kFewest = 9;  // A cylinder goes through any five.
  constexpr int kSteps = 30;
  if (patch.points.size() < kFewest) return std::nullopt;
  Mat3 spread = Mat3::Zero();
  for (const Cell<3>& triangle : patch.triangles) {
    const Vec3 normal = triangle_area_normal(patch.points, triangle);
    spread += normal * normal.transpose() / std::max(normal.norm(), 1e-300);
  }
  // All normals are across the axis.
  CylinderFit fit =
      cylinder_along(Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvectors().col(0), patch.points);
  for (int i = 0; i < kSteps && fit.worst(patch.points) > 1e-3 * allowed; ++i)
    fit = better(fit, patch.points);
  for (const Vec3& axis : {nearly_axis(fit.axis), fit.axis}) {
    CylinderFit final_fit = axis == fit.axis ? fit : cylinder_along(axis, patch.points);
    if (final_fit.worst(patch.points) <= allowed) return final_fit;
  }
  return std::nullopt;
}

std::shared_ptr<const Surface> cylinder_of(const PatchTriangles& patch, double allowed) {
  const std::optional<CylinderFit> fit = fit_cylinder(patch, allowed);
  if (!fit) return nullptr;
  double outward = 0;
  for (const Cell<3>& triangle : patch.triangles) {
    const Vec3& corner = patch.points[triangle[0]];
    outward += triangle_area_normal(patch.points, triangle)
                   .dot(corner - fit->on_axis - (corner - fit->on_axis).dot(fit->axis) * fit->axis);
  }
  return std::make_shared<CylinderSurface>(fit->on_axis, fit->axis, fit->radius, outward > 0 ? 1 : -1);
}

/// Points at the rim of the patch.
std::vector<bool> rim_points(const PatchTriangles& patch) {
  std::vector<bool> is_at_rim(patch.points.size(), false);
  for_each_edge(sorted_sides(patch.triangles), [&](std::span<const TriangleSide> edge) {
    if (edge.size() == 1) is_at_rim[edge[0].low] = is_at_rim[edge[0].high] = true;
  });
  return is_at_rim;
}

/// Lets every point inside the patch down by the mean height over the triangles around it.
/// @param height_over  Of each triangle, by its number.
template <class HeightOver>
void lower(PatchTriangles& patch, const std::vector<Vec3>& normals, const HeightOver& height_over) {
  std::vector<ValueOnArea> heights(patch.triangles.size());
  parallel::for_each_index(heights.size(), 64, [&](std::size_t i) {
    heights[i] = {height_over(i), triangle_area(patch.points, patch.triangles[i])};
  });
  const std::vector<double> means = means_around_vertices(patch.triangles, heights, patch.points.size());
  const std::vector<bool> is_at_rim = rim_points(patch);
  for (std::size_t v = 0; v < patch.points.size(); ++v)
    if (!is_at_rim[v] && means[v] != 0) patch.points[v] -= means[v] * normals[v];
}

/// Offsets the points inwards by the mean sagitta, so that a smooth surface through them encloses about what
/// the triangles enclosed.
void lower_by_sagitta(PatchTriangles& patch) {
  const std::vector<Vec3> normals = vertex_normals(patch.points, patch.triangles);
  lower(patch, normals, [&, points = patch.points](std::size_t i) {
    std::array<SurfacePoint, 3> at;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = patch.triangles[i][k];
      at[k] = {points[v], normals[v]};
    }
    return sagitta_of(at);
  });
}

/// The smooth surface through the points, let down until it encloses what the triangles did that had their
/// corners at `before`.
std::shared_ptr<const Surface> surface_of_volume(PatchTriangles& patch, const std::vector<Vec3>& before,
                                                 const std::vector<MeshSurface::Rim>& rims) {
  constexpr int kRounds = 2;
  const std::vector<Vec3> normals = vertex_normals(before, patch.triangles);
  auto surface = std::make_shared<const MeshSurface>(patch.points, patch.triangles, rims);
  for (int round = 0; round < kRounds; ++round) {
    lower(patch, normals, [&, points = patch.points](std::size_t i) {
      const auto& [a, b, c] = patch.triangles[i];
      return *mean_height_over({before[a], before[b], before[c]}, {points[a], points[b], points[c]},
                               [&](const Vec3& near) { return std::optional(surface->closest(near)); });
    });
    surface = std::make_shared<const MeshSurface>(patch.points, patch.triangles, rims);
  }
  return surface;
}

/// An edge between two patches, the lower one first.
struct CurveEdge {
  std::uint32_t a, b;
  std::array<std::uint32_t, 2> patches;
};

/// Edges of curves, ordered by their patches.
std::vector<CurveEdge> curve_edges(const BoundaryFaces& faces) {
  const auto patch_of = [&](const TriangleSide& side) {
    return static_cast<std::uint32_t>(faces.patches[side.triangle]);
  };
  std::vector<CurveEdge> edges;
  for_each_edge(sorted_sides(faces.triangles), [&](std::span<const TriangleSide> edge) {
    if (edge.size() != 2) return;
    const auto [low, high] = std::minmax({patch_of(edge[0]), patch_of(edge[1])});
    if (low != high) edges.push_back({edge[0].low, edge[0].high, {low, high}});
  });
  std::ranges::stable_sort(edges,
                           [](const CurveEdge& x, const CurveEdge& y) { return x.patches < y.patches; });
  return edges;
}

/// The tangent of a curve at a vertex between two others: that of the parabola through them.
Vec3 tangent_between(const Vec3& before, const Vec3& at, const Vec3& after) {
  const Vec3 first = at - before, second = after - at;
  return (second.squaredNorm() * first + first.squaredNorm() * second).normalized();
}

/// One curve of the mesh: its edges, and where its vertices are.
class Curve {
 public:
  Curve(std::span<const CurveEdge> edges, const TetMesh& mesh) : edges_(edges) {
    for (const CurveEdge& edge : edges) {
      vertices_[edge.a].others.push_back(edge.b);
      vertices_[edge.b].others.push_back(edge.a);
    }
    for (auto& [v, vertex] : vertices_) {
      vertex.point = mesh.point(VertexId(v));
      vertex.has_tangent =
          vertex.others.size() == 2 && mesh.dimension(VertexId(v)) != VertexDimension::kCorner;
    }
  }

  [[nodiscard]] const Vec3& point(std::uint32_t v) const { return vertices_.at(v).point; }

  /// Lets the vertices of a curve in a plane down by the mean height of the arcs around, so that a smooth
  /// curve through them encloses what the edges enclosed.
  void lower_by_arcs(const Vec3& plane_normal) {
    struct Sum {
      Vec3 shift = Vec3::Zero();
      double length = 0;
    };
    std::map<std::uint32_t, Sum> sums;
    for (const auto& [a, b, patches] : edges_) {
      if (!vertices_.at(a).has_tangent || !vertices_.at(b).has_tangent) continue;
      const Vec3 edge = point(b) - point(a);
      const Vec3 at_a = plane_normal.cross(tangent_along(a, edge)),
                 at_b = plane_normal.cross(tangent_along(b, edge));
      const double height = mean_arc_height({point(a), at_a}, {point(b), at_b});
      sums[a].shift -= edge.norm() * height * at_a;
      sums[b].shift -= edge.norm() * height * at_b;
      for (const std::uint32_t v : {a, b}) sums[v].length += edge.norm();
    }
    for (const auto& [v, sum] : sums) vertices_.at(v).point += sum.shift / sum.length;
  }

  /// Cubic pieces over the edges.
  [[nodiscard]] std::vector<CurvePiece> pieces() const {
    const auto control_beside = [&](std::uint32_t v, std::uint32_t other) -> Vec3 {
      const Vec3 edge = point(other) - point(v);
      if (!vertices_.at(v).has_tangent) return point(v) + edge / 3;
      const Vec3 tangent = tangent_along(v, edge);
      return point(v) + edge.dot(tangent) / 3 * tangent;
    };
    std::vector<CurvePiece> pieces;
    for (const auto& [a, b, patches] : edges_)
      pieces.push_back({{point(a), control_beside(a, b), control_beside(b, a), point(b)}});
    return pieces;
  }

 private:
  [[nodiscard]] Vec3 tangent_along(std::uint32_t v, const Vec3& edge) const {
    const auto& others = vertices_.at(v).others;
    const Vec3 tangent = tangent_between(point(others[0]), point(v), point(others[1]));
    return tangent.dot(edge) < 0 ? Vec3(-tangent) : tangent;
  }

  struct Vertex {
    std::vector<std::uint32_t> others;  // The other ends of its edges.
    Vec3 point;
    bool has_tangent = false;
  };

  std::span<const CurveEdge> edges_;
  std::map<std::uint32_t, Vertex> vertices_;
};

/// True if alternate projection finds where two patches meet: their surfaces are known exactly, and cross.
bool meet_by_themselves(const PatchShape& one, const PatchShape& other) {
  const auto is_exact = [](const PatchShape& shape) {
    return shape.freedom == PatchFreedom::kPlane || (shape.surface && shape.surface->is_analytic());
  };
  return is_exact(one) && is_exact(other);
}

/// The smooth surfaces and curves of one mesh.
class SurfaceBuilder {
 public:
  SurfaceBuilder(const TetMesh& mesh, PatchShapes shapes)
      : mesh_(mesh),
        faces_(mesh.boundary_faces()),
        edges_(curve_edges(faces_)),
        patches_(shapes.size()),
        numbers_(shapes.size()),
        is_between_labels_(shapes.size(), false),
        shapes_(std::move(shapes)) {
    for (std::size_t i = 0; i < faces_.triangles.size(); ++i) add_face(i);
  }

  void find_cylinders(double allowed) {
    for_each_curved([&](std::size_t p) { shapes_[p].surface = cylinder_of(patches_[p], allowed); });
  }
  /// For every patch without a surface so far; curves first, which are their rims.
  void lay_along_vertices(SurfaceKeeps keeps) {
    std::vector<std::vector<Vec3>> before(shapes_.size());
    for_each_curved([&](std::size_t p) {
      if (shapes_[p].surface) return;
      before[p] = patches_[p].points;
      shapes_[p].keeps_volume = keeps == SurfaceKeeps::kVolume;
      if (shapes_[p].keeps_volume) lower_by_sagitta(patches_[p]);
    });
    std::vector<std::vector<MeshSurface::Rim>> rims(shapes_.size());
    const auto same = [](const CurveEdge& a, const CurveEdge& b) { return a.patches == b.patches; };
    parallel::for_each_run(edges_, same, [&](std::span<const CurveEdge> edges) {
      const auto [p, q] = edges[0].patches;
      if (!is_free(p) || !is_free(q) || meet_by_themselves(shapes_[p], shapes_[q])) return;
      Curve curve(edges, mesh_);
      for (const auto& [wall, flat] : {std::pair{p, q}, {q, p}})
        if (shapes_[wall].keeps_volume && shapes_[flat].freedom == PatchFreedom::kPlane)
          curve.lower_by_arcs(shapes_[flat].normal);
      const std::vector<CurvePiece> pieces = curve.pieces();
      const auto shared = std::make_shared<const MeshCurve>(pieces);
      shapes_[p].curves.emplace_back(PatchId(q), shared);
      shapes_[q].curves.emplace_back(PatchId(p), shared);
      for (const std::uint32_t side : {p, q})
        for (std::size_t k = 0; k < edges.size(); ++k) {
          const std::uint32_t a = numbers_[side][edges[k].a], b = numbers_[side][edges[k].b];
          patches_[side].points[a] = curve.point(edges[k].a);
          patches_[side].points[b] = curve.point(edges[k].b);
          rims[side].push_back({a, b, pieces[k]});
        }
    });
    for_each_curved([&](std::size_t p) {
      if (shapes_[p].surface) return;
      shapes_[p].surface = shapes_[p].keeps_volume ? surface_of_volume(patches_[p], before[p], rims[p])
                                                   : std::make_shared<const MeshSurface>(
                                                         patches_[p].points, patches_[p].triangles, rims[p]);
    });
  }
  PatchShapes take() {
    for_each_curved([&](std::size_t p) { shapes_[p].freedom = PatchFreedom::kCurved; });
    return std::move(shapes_);
  }

 private:
  void add_face(std::size_t i) {
    const auto p = static_cast<std::size_t>(faces_.patches[i]);
    if (faces_.tets[i][1].valid()) is_between_labels_[p] = true;
    Cell<3> own;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = faces_.triangles[i][k];
      const auto [place, added] =
          numbers_[p].try_emplace(v, static_cast<std::uint32_t>(patches_[p].points.size()));
      if (added) patches_[p].points.push_back(mesh_.point(VertexId(v)));
      own[k] = place->second;
    }
    patches_[p].triangles.push_back(own);
  }
  [[nodiscard]] bool is_curved(std::size_t p) const {
    return shapes_[p].freedom != PatchFreedom::kPlane && !is_between_labels_[p] &&
           !patches_[p].triangles.empty();
  }
  [[nodiscard]] bool is_free(std::size_t p) const {
    return shapes_[p].freedom == PatchFreedom::kPlane || is_curved(p);
  }
  template <class Body>
  void for_each_curved(const Body& body) {
    for (std::size_t p = 0; p < shapes_.size(); ++p)
      if (is_curved(p)) body(p);
  }

  const TetMesh& mesh_;
  BoundaryFaces faces_;
  std::vector<CurveEdge> edges_;
  std::vector<PatchTriangles> patches_;
  std::vector<OwnNumbers> numbers_;
  std::vector<bool> is_between_labels_;
  PatchShapes shapes_;
};

}  // namespace

PatchShapes shapes_of_patches(const TetMesh& mesh, double tolerance, SurfaceKeeps keeps) {
  SurfaceBuilder builder(mesh, planes_where_flat(mesh, tolerance));
  builder.find_cylinders(tolerance * bounding_box(mesh.points()).diagonal().norm());
  builder.lay_along_vertices(keeps);
  return builder.take();
}

}  // namespace lumesh::operators
