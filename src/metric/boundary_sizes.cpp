#include "boundary_sizes.hpp"

#include <Eigen/Geometry>
#include <array>
#include <limits>

#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {
namespace {

Vec3 sorted_sizes(const SymTensor& metric) {
  return eigen_system(metric).values.cwiseSqrt().cwiseInverse();
}

/// Sums over the triangles around a vertex.
struct TriangleSums {
  Mat3 edge_squares = Mat3::Zero();  // e e^T of all edges.
  Mat3 normals = Mat3::Zero();       // n n^T of the unit normals.
  int triangles = 0;
};

std::vector<TriangleSums> sums_at_vertices(const TetMesh& mesh, const BoundaryFaces& faces) {
  std::vector<TriangleSums> sums(mesh.vertex_count());
  for (const Cell<3>& triangle : faces.triangles) {
    std::array<Vec3, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) corner[k] = mesh.points()[triangle[k]];
    Mat3 squares = Mat3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 edge = corner[(k + 1) % 3] - corner[k];
      squares += edge * edge.transpose();
    }
    const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).stableNormalized();
    for (const std::uint32_t v : triangle) {
      sums[v].edge_squares += squares;
      sums[v].normals += normal * normal.transpose();
      ++sums[v].triangles;
    }
  }
  return sums;
}

}  // namespace

void BoundarySizes::measure_places(const TetMesh& mesh, const BoundaryFaces& faces) {
  // In the metric 3/2 (sum of e e^T)^-1 the triangle with the edges e is regular with unit edges.
  constexpr double kRegular = 1.5;
  // Of the triangles, how much they extend along a direction: less is across all of them.
  constexpr double kAcross = 0.1;
  const std::vector<TriangleSums> sums = sums_at_vertices(mesh, faces);
  places_.resize(sums.size());
  parallel::for_each_index(places_.size(), [&](std::size_t v) {
    if (sums[v].triangles == 0) return;
    const double share = 1.0 / sums[v].triangles;
    const EigenSystem system = eigen_system(SymTensor::from(share * sums[v].edge_squares));
    double smallest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
      const Vec3 axis = system.axes.col(i);
      // Triangles that lie across an axis, as at creases, say nothing of it.
      const double extent = 1 - share * axis.dot(sums[v].normals * axis);
      if (extent < kAcross || !(system.values[i] > 0)) {
        places_[v].across = axis;
        continue;
      }
      const double value = kRegular * extent / system.values[i];
      places_[v].imposed = places_[v].imposed + value * SymTensor::from(axis * axis.transpose());
      smallest = std::min(smallest, value);
    }
    places_[v].min_along = smallest;
  });
}

BoundarySizes::BoundarySizes(const TetMesh& mesh, const BoundaryFaces& faces, double growth)
    : growth_(growth) {
  constexpr std::size_t kGrain = 64;
  measure_places(mesh, faces);
  const TriangleTree tree(mesh.points(), faces.triangles);
  closest_.resize(mesh.vertex_count());
  parallel::for_each_index(closest_.size(), kGrain, [&](std::size_t v) {
    const Vec3& point = mesh.points()[v];
    const TriangleTree::Nearest nearest = tree.nearest(point);
    const Cell<3>& corners = faces.triangles[nearest.triangle];
    const auto distance_to = [&](std::uint32_t w) { return (mesh.points()[w] - point).squaredNorm(); };
    std::uint32_t closest = corners[0];
    for (const std::uint32_t w : corners)
      if (distance_to(w) < distance_to(closest)) closest = w;
    closest_[v] = {nearest.distance, closest};
  });
}

SymTensor BoundarySizes::met_at(VertexId v, const SymTensor& wanted) const {
  const ClosestPoint& closest = closest_[v.value];
  const Place& place = places_[closest.vertex];
  // Across the boundary as wanted, but no larger than along it.
  const double across = std::max(wanted.quadratic(place.across), place.min_along);
  const SymTensor imposed = place.imposed + across * SymTensor::from(place.across * place.across.transpose());
  const double change_mm = (sorted_sizes(imposed) - sorted_sizes(wanted)).cwiseAbs().maxCoeff();
  const double reach_mm = change_mm / (growth_ - 1);
  if (!(closest.distance < reach_mm)) return wanted;
  const double share = 1 - closest.distance / reach_mm;
  return exp(share * log(imposed) + (1 - share) * log(wanted));
}

}  // namespace lumesh::metric
