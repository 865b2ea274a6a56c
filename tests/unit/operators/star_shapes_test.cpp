#include "../src/operators/star_shapes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "fixtures/mesh_walks.hpp"
#include "fixtures/metric_cubes.hpp"
#include "lumesh/metric/measures.hpp"
#include "lumesh/metric/metric_field.hpp"

namespace lumesh::operators {
namespace {

using metric::AnalyticKind;
using metric::MetricField;

/// Sum of 1 / mean ratio with the vertex at x, by the definition of the mean ratio, tetrahedron by
/// tetrahedron.
double sum_at(const TetMesh& mesh, VertexId v, const std::vector<TetId>& tets, const Vec3& x) {
  double sum = 0;
  for (const TetId t : tets) {
    const auto at = [&](int k) -> const Vec3& { return mesh.vertex(t, k) == v ? x : mesh.corner(t, k); };
    const auto log = [&](int k) -> const SymTensor& { return mesh.log_metric(mesh.vertex(t, k)); };
    sum += 1 / metric::mean_ratio(at(0), at(1), at(2), at(3), log(0), log(1), log(2), log(3));
  }
  return sum;
}

TEST(StarShapes, DerivativesAreThoseOfFiniteDifferences) {
  TetMesh mesh = fixtures::unit_cube(3);
  fixtures::assign_metric(mesh, MetricField::analytic(AnalyticKind::kPolar2, 3));
  StarShapes shapes;
  int tried = 0;
  for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) {
    const VertexId v(i);
    if (mesh.dimension(v) != VertexDimension::kVolume) continue;
    std::vector<TetId> tets;
    fixtures::for_each_tet_around(mesh, v, [&](TetId t) { tets.push_back(t); });
    const Vec3 x = mesh.point(v) + Vec3(0.02, -0.03, 0.01);
    const double size = 1 / std::sqrt(mesh.metric(v).trace()), h = 1e-4 * size;
    shapes.gather(mesh, v, tets);
    const ShapeSums sums = shapes.sums_at(x, mesh.log_metric(v));
    EXPECT_NEAR(sums.value, sum_at(mesh, v, tets, x), 1e-9 * sums.value);
    const Mat3 hessian = sums.hessian.matrix();
    for (int k = 0; k < 3; ++k) {
      const Vec3 step = h * Vec3::Unit(k);
      const double slope = (sum_at(mesh, v, tets, x + step) - sum_at(mesh, v, tets, x - step)) / (2 * h);
      EXPECT_NEAR(sums.gradient[k], slope, 1e-5 * sums.gradient.norm() + 1e-5 * sums.value / size);
      const Vec3 turn = (shapes.sums_at(x + step, mesh.log_metric(v)).gradient -
                         shapes.sums_at(x - step, mesh.log_metric(v)).gradient) /
                        (2 * h);
      EXPECT_LT((hessian.col(k) - turn).norm(), 1e-4 * hessian.norm());
    }
    ++tried;
  }
  EXPECT_EQ(tried, 8);
}

}  // namespace
}  // namespace lumesh::operators
