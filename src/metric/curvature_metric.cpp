#include "lumesh/metric/curvature_metric.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lumesh/core/assert.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"
#include "vertex_rings.hpp"

namespace lumesh::metric {

namespace {

/// Unit normals of frames in which heights are fitted, weighted by area: curvature_of() takes the slope in
/// the frame into account, so that a tilt does no harm. Surfaces that meshes follow need the weights by angle
/// of vertex_normals() (domain/surface.hpp).
std::vector<Vec3> frame_normals(std::span<const Vec3> points, std::span<const Cell<3>> triangles) {
  std::vector<Vec3> normals(points.size(), Vec3::Zero());
  for (const Cell<3>& t : triangles)
    for (const std::uint32_t v : t) normals[v] += triangle_area_normal(points, t);
  for (Vec3& normal : normals) normal = normal.norm() > 0 ? normal.normalized() : Vec3::UnitZ();
  return normals;
}

/// Principal curvatures of the height h(x, y) with first derivatives d, e and second ones a, b, c.
SurfaceCurvature curvature_of(const Mat3& frame, double d, double e, double a, double b, double c) {
  // First and second fundamental form; principal curvatures k solve II x = k I x.
  const double root = std::sqrt(1 + d * d + e * e);
  Eigen::Matrix2d first, second;
  first << 1 + d * d, d * e, d * e, 1 + e * e;
  second << a / root, b / root, b / root, c / root;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> solver(second, first);
  const auto lifted = [&](int i) -> Vec3 {
    const Eigen::Vector2d x = solver.eigenvectors().col(i);
    return (frame * Vec3(x[0], x[1], d * x[0] + e * x[1])).normalized();
  };
  SurfaceCurvature found;
  found.axes.col(0) = lifted(0);
  found.axes.col(2) = (frame * Vec3(-d, -e, 1)).normalized();
  found.axes.col(1) = found.axes.col(2).cross(found.axes.col(0));
  found.curvatures = {solver.eigenvalues()[0], solver.eigenvalues()[1]};
  return found;
}

SurfaceCurvature fitted_curvature(std::span<const Vec3> points, std::span<const Vec3> normals, std::size_t v,
                                  std::span<const std::uint32_t> neighbours) {
  constexpr double kTikhonov = 1e-10;
  Mat3 frame;
  frame.col(2) = normals[v];
  frame.col(0) = normals[v].unitOrthogonal();
  frame.col(1) = normals[v].cross(frame.col(0));
  double reach = 0;
  for (const std::uint32_t w : neighbours) reach = std::max(reach, (points[w] - points[v]).norm());
  using Terms = Eigen::Matrix<double, 5, 1>;
  Eigen::Matrix<double, 5, 5> squares = Eigen::Matrix<double, 5, 5>::Zero();
  Terms products = Terms::Zero();
  for (const std::uint32_t w : neighbours) {
    if (normals[w].dot(normals[v]) <= 0) continue;  // Round the bend, or on the other side of a thin part.
    const Vec3 p = frame.transpose() * (points[w] - points[v]) / reach;
    const double across = p.head<2>().squaredNorm();
    if (p[2] * p[2] > across) continue;
    const double lift = p.squaredNorm() / across;
    Terms terms;
    terms << p[0], p[1], lift * p[0] * p[0] / 2, lift * p[0] * p[1], lift * p[1] * p[1] / 2;
    const double weight = 1 / p.squaredNorm();
    squares += weight * terms * terms.transpose();
    products += weight * p[2] * terms;
  }
  squares.diagonal().array() += kTikhonov * squares.trace();
  const Terms found = squares.trace() > 0 ? Terms(squares.ldlt().solve(products)) : Terms(Terms::Zero());
  return curvature_of(frame, found[0], found[1], found[2] / reach, found[3] / reach, found[4] / reach);
}

/// The boundary taken apart: every piece has vertices of its own.
struct SmoothSurface {
  std::vector<Vec3> points;
  std::vector<Cell<3>> triangles;
  std::vector<std::uint32_t> vertices;  ///< Of the mesh, ascending, with every point.
};

SmoothSurface take_apart(const TetMesh& mesh, double feature_angle_deg) {
  const BoundaryFaces faces = mesh.boundary_faces();
  DisjointSets parts = smooth_parts(mesh.points(), faces.triangles, faces.patches, feature_angle_deg);
  std::vector<std::uint32_t> piece(faces.triangles.size());
  for (std::uint32_t t = 0; t < piece.size(); ++t) piece[t] = parts.find(t);
  std::vector<std::array<std::uint32_t, 2>> corners;  // Vertex and piece.
  for (std::size_t t = 0; t < piece.size(); ++t)
    for (const std::uint32_t v : faces.triangles[t]) corners.push_back({v, piece[t]});
  parallel::sort_unique(corners);
  SmoothSurface surface;
  for (const auto& corner : corners) {
    surface.points.push_back(mesh.points()[corner[0]]);
    surface.vertices.push_back(corner[0]);
  }
  surface.triangles = faces.triangles;
  parallel::for_each_index(piece.size(), [&](std::size_t t) {
    for (std::uint32_t& v : surface.triangles[t]) {
      v = rank_in(corners, std::array<std::uint32_t, 2>{v, piece[t]});
    }
  });
  return surface;
}

}  // namespace

void CurvatureOptions::describe(OptionList& list) {
  list.number("edges_per_radius", edges_per_radius, above(0),
              "Edges along an arc as long as its radius of curvature")
      .needs("curvature");
  list.number("chord_height", chord_mm, above(0),
              "Instead: how far the middle of an edge may stand off its arc")
      .in("mm")
      .zero("as the edges per radius say")
      .needs("curvature")
      .excludes("edges_per_radius");
}

void CurvatureOptions::validate() const {
  require_ranges_of(*this);
  if (!(largest_mm > 0 && feature_angle_deg > 0 && feature_angle_deg <= 180))
    throw Error(ErrorKind::kUsage, "the largest size must be above 0, the feature angle also at most 180");
}

double CurvatureOptions::largest_of(std::span<const Vec3> points) const {
  return std::isfinite(largest_mm) ? largest_mm : bounding_box(points).sizes().norm();
}

double CurvatureOptions::size_of(double curvature, double largest) const {
  // By curvatures, not radii: these may be infinite.
  if (chord_mm == 0)
    return curvature * largest * edges_per_radius > 1 ? 1 / (curvature * edges_per_radius) : largest;
  if (curvature * chord_mm >= 1) return std::min(2 / curvature, largest);
  const double size = 2 * std::sqrt(chord_mm * (2 - chord_mm * curvature) / curvature);
  return std::min(size, largest);
}

SymTensor metric_of_curvature(const SurfaceCurvature& curvature, const CurvatureOptions& options,
                              double largest) {
  const double first = options.size_of(std::abs(curvature.curvatures[0]), largest);
  const double second = options.size_of(std::abs(curvature.curvatures[1]), largest);
  return from_sizes(curvature.axes, Vec3(first, second, std::min(first, second)));
}

std::vector<SurfaceCurvature> fit_curvatures(std::span<const Vec3> points,
                                             std::span<const Cell<3>> triangles) {
  constexpr int kRings = 2;
  constexpr std::size_t kMinNeighbours = 12;
  std::vector<std::uint64_t> edges;
  edges.reserve(6 * triangles.size());
  for (const Cell<3>& t : triangles)
    for (int i = 0; i < 3; ++i) parallel::add_both_ways(t[i], t[(i + 1) % 3], edges);
  const parallel::Adjacency neighbours = parallel::adjacency_of(edges, points.size());
  const std::vector<Vec3> normals = frame_normals(points, triangles);
  std::vector<SurfaceCurvature> curvatures(points.size());
  parallel::for_each_index(points.size(), 64, [&](std::size_t v) {
    const std::vector<std::uint32_t> about = vertices_about(neighbours, v, kRings, kMinNeighbours);
    if (!about.empty()) curvatures[v] = fitted_curvature(points, normals, v, about);
  });
  return curvatures;
}

std::vector<SymTensor> metric_from_curvature(const TetMesh& mesh, const CurvatureOptions& options) {
  options.validate();
  LUMESH_ASSERT(mesh.is_compact());
  const double largest = options.largest_of(mesh.points());
  const double flat = 1 / (largest * largest);
  std::vector<SymTensor> metric(mesh.vertex_count(), SymTensor::diagonal(flat, flat, flat));
  const SmoothSurface surface = take_apart(mesh, options.feature_angle_deg);
  const std::vector<SurfaceCurvature> curvatures = fit_curvatures(surface.points, surface.triangles);
  for (std::size_t i = 0; i < curvatures.size(); ++i) {
    SymTensor& tensor = metric[surface.vertices[i]];
    const SymTensor wanted = metric_of_curvature(curvatures[i], options, largest);
    const bool is_first = i == 0 || surface.vertices[i] != surface.vertices[i - 1];
    tensor = is_first ? wanted : intersection(tensor, wanted);
  }
  return metric;
}

}  // namespace lumesh::metric
