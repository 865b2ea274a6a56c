#include "lumesh/metric/tensor.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <random>
#include <unsupported/Eigen/MatrixFunctions>

namespace lumesh::metric {
namespace {

/// Sizes between 10^-span and 10^span mm along random axes.
SymTensor random_metric(std::mt19937& random, double span) {
  std::uniform_real_distribution<double> number(-1, 1);
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond(number(random), number(random), number(random), number(random)).normalized();
  const auto size = [&] { return std::pow(10, span * number(random)); };
  return from_sizes(turn.toRotationMatrix(), Vec3(size(), size(), size()));
}

double difference(const SymTensor& a, const SymTensor& b) {
  return (a.matrix() - b.matrix()).norm() / b.matrix().norm();
}

TEST(Tensor, QuadraticAndTimesAgreeWithMatrices) {
  const SymTensor t{2, 0.5, -0.25, 3, 0.75, 4};
  const Vec3 v(1, -2, 3);
  EXPECT_DOUBLE_EQ(t.quadratic(v), v.dot(t.matrix() * v));
  EXPECT_TRUE(t.times(v).isApprox(t.matrix() * v, 1e-15));
  EXPECT_DOUBLE_EQ(t.determinant(), t.matrix().determinant());
  EXPECT_EQ(SymTensor::from(t.matrix()), t);
}

TEST(Tensor, FromSizesGivesEachAxisItsLength) {
  Mat3 axes;
  axes = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized());
  const SymTensor metric = from_sizes(axes, Vec3(0.1, 2, 30));
  EXPECT_NEAR(metric.quadratic(axes.col(0) * 0.1), 1, 1e-12);
  EXPECT_NEAR(metric.quadratic(axes.col(1) * 2), 1, 1e-12);
  EXPECT_NEAR(metric.quadratic(axes.col(2) * 30), 1, 1e-12);
}

TEST(Tensor, LogAndExpAreThoseOfEigenAndInverse) {
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    const SymTensor metric = random_metric(random, 2);
    const Mat3 expected = metric.matrix().log();
    EXPECT_LT(difference(log(metric), SymTensor::from(expected)), 1e-8);
    EXPECT_LT(difference(exp(log(metric)), metric), 1e-10);
  }
}

TEST(Tensor, IntersectionAsksForNoLargerSizesThanEither) {
  std::mt19937 random(2);
  for (int i = 0; i < 200; ++i) {
    const SymTensor a = random_metric(random, 1.5), b = random_metric(random, 1.5);
    const SymTensor both = intersection(a, b);
    const double scale = both.matrix().norm();
    for (const SymTensor& one : {a, b}) {
      const Vec3 values = eigen_system(SymTensor::from(both.matrix() - one.matrix())).values;
      EXPECT_GT(values[0], -1e-9 * scale);
    }
  }
}

TEST(Tensor, IntersectionOfSharedAxesTakesTheSmallerSizes) {
  const SymTensor a = from_sizes(Mat3::Identity(), Vec3(1, 10, 3));
  const SymTensor b = from_sizes(Mat3::Identity(), Vec3(5, 2, 3));
  EXPECT_LT(difference(intersection(a, b), from_sizes(Mat3::Identity(), Vec3(1, 2, 3))), 1e-12);
  EXPECT_LT(difference(intersection(a, a), a), 1e-12);
}

}  // namespace
}  // namespace lumesh::metric
