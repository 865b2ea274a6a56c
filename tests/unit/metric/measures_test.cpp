#include "lumesh/metric/measures.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/metric/tensor.hpp"

namespace lumesh::metric {
namespace {

struct Samples {
  std::mt19937 random{7};
  std::uniform_real_distribution<double> number{-1, 1};

  double operator()() { return number(random); }
  Vec3 point() { return {number(random), number(random), number(random)}; }
  SymTensor metric(double decades) {
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond((*this)(), (*this)(), (*this)(), (*this)()).normalized();
    const auto size = [&] { return std::pow(10, decades * (*this)()); };
    return from_sizes(turn.toRotationMatrix(), Vec3(size(), size(), size()));
  }
};

/// Alauzet 2010, doi:10.1016/j.finel.2009.06.028, page 185.
TEST(EdgeLength, IsExactForSizesThatGrowGeometrically) {
  // h(s) = h0 q^s along the edge, s in [0, 1]: the integral of length / h(s) over s.
  for (const double q : {1.0, 1.0001, 1.3, 1.49, 1.51, 4.0, 100.0}) {
    const double h0 = 0.2, length = 3;
    const double exact = q == 1 ? length / h0 : length / h0 * (1 - 1 / q) / std::log(q);
    const Vec3 a(1, 2, 3), b = a + Vec3(0, 0, length);
    const SymTensor ma = from_sizes(Mat3::Identity(), Vec3::Constant(h0));
    const SymTensor mb = from_sizes(Mat3::Identity(), Vec3::Constant(h0 * q));
    EXPECT_NEAR(edge_length(a, ma, b, mb), exact, 2e-8 * exact) << q;
    EXPECT_DOUBLE_EQ(edge_length(b, mb, a, ma), edge_length(a, ma, b, mb)) << q;
  }
}

TEST(EdgeLength, OfNoEdgeIsZero) {
  const SymTensor one = SymTensor::diagonal(1, 1, 1);
  const double length = edge_length(Vec3(1, 1, 1), one, Vec3(1, 1, 1), one);
  EXPECT_FALSE(length > 0);
}

TEST(TraceFreeExp, AgreesWithEigenvalues) {
  Samples sample;
  for (int i = 0; i < 300; ++i) {
    const SymTensor log_metric = log(sample.metric(i % 3 + 1.0));
    const double third = log_metric.trace() / 3;
    SymTensor expected = log_metric;
    expected.xx -= third, expected.yy -= third, expected.zz -= third;
    expected = exp(expected);
    const SymTensor fast = TraceFreeExp(log_metric).tensor();
    // Along each eigenvector, so that the small eigenvalues count as much as the large ones.
    const EigenSystem system = eigen_system(expected);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(fast.quadratic(system.axes.col(k)) / system.values[k], 1, 2e-3 * std::pow(10, i % 3 - 2.0));
    const SymTensor s = SymTensor::from(sample.point() * sample.point().transpose());
    EXPECT_NEAR(TraceFreeExp(log_metric).contraction_with(s), (fast.matrix() * s.matrix()).trace(),
                1e-12 * fast.matrix().norm());
  }
}

TEST(MeanRatio, IsOneForTheRegularTetrahedronOfTheMetric) {
  Samples sample;
  for (int i = 0; i < 100; ++i) {
    const SymTensor metric = sample.metric(1.5), log_metric = log(metric);
    // Columns of M^(-1/2) carry the unit regular tetrahedron into one of the metric.
    const SymTensor inverse_half = exp(-0.5 * log_metric);
    const std::array<Vec3, 4> regular = {Vec3(1, 1, 1), Vec3(-1, 1, -1), Vec3(1, -1, -1), Vec3(-1, -1, 1)};
    std::array<Vec3, 4> p;
    for (int k = 0; k < 4; ++k) p[k] = inverse_half.times(regular[k]);
    EXPECT_NEAR(mean_ratio(p[0], p[1], p[2], p[3], log_metric, log_metric, log_metric, log_metric), 1, 1e-6);
    EXPECT_LT(mean_ratio(p[1], p[0], p[2], p[3], log_metric, log_metric, log_metric, log_metric), 0);
  }
}

TEST(MeanRatio, IsTheEuclideanOneInTheIdentity) {
  Samples sample;
  const SymTensor zero;
  for (int i = 0; i < 100; ++i) {
    const Vec3 a = sample.point(), b = sample.point(), c = sample.point(), d = sample.point();
    const double expected = lumesh::mean_ratio(a, b, c, d);
    const double found = mean_ratio(a, b, c, d, zero, zero, zero, zero);
    if (expected > 0) {
      EXPECT_NEAR(found, expected, 1e-8);
    } else {
      EXPECT_LT(found, 0);
    }
  }
}

/// The mean of Alauzet 2010, doi:10.1016/j.finel.2009.06.028, section 2.3.2, eq. (3).
TEST(MeanRatio, TakesTheLogEuclideanMeanOfDifferentMetrics) {
  Samples sample;
  for (int i = 0; i < 100; ++i) {
    std::array<Vec3, 4> p = {sample.point(), sample.point(), sample.point(), sample.point()};
    if (tetrahedron_volume(p[0], p[1], p[2], p[3]) < 0) std::swap(p[0], p[1]);
    std::array<SymTensor, 4> logs;
    for (SymTensor& one : logs) one = log(sample.metric(0.5));
    // By the definition: the tetrahedron carried into the space where the mean metric is the identity.
    const SymTensor half = exp(0.5 * mean_of_logs(logs[0], logs[1], logs[2], logs[3]));
    const double expected =
        lumesh::mean_ratio(half.times(p[0]), half.times(p[1]), half.times(p[2]), half.times(p[3]));
    EXPECT_NEAR(mean_ratio(p[0], p[1], p[2], p[3], logs[0], logs[1], logs[2], logs[3]), expected, 1e-6);
  }
}

TEST(CubeRoot, IsExactToRounding) {
  for (double x = 1e-30; x < 1e30; x *= 1.37) EXPECT_NEAR(cube_root(x) / std::cbrt(x), 1, 1e-14) << x;
}

}  // namespace
}  // namespace lumesh::metric
