#include "lumesh/geometry/metric_fault.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace lumesh {
namespace {

TEST(MetricFault, OnlyPositiveDefiniteFiniteTensorsAreMetrics) {
  EXPECT_TRUE(is_metric(SymTensor::diagonal(1, 2, 3)));
  EXPECT_FALSE(is_metric(SymTensor::diagonal(1, 0, 3)));
  EXPECT_FALSE(is_metric(SymTensor::diagonal(1, -2, 3)));
  EXPECT_FALSE(is_metric(SymTensor{}));
  EXPECT_FALSE(is_metric(SymTensor{1, 2, 0, 1, 0, 1}));  // Positive diagonal, negative eigenvalue.
  const double nan = std::nan("");
  EXPECT_FALSE(is_metric(SymTensor{1, nan, 0, 1, 0, 1}));
  EXPECT_FALSE(is_metric(SymTensor::diagonal(1, 1, std::numeric_limits<double>::infinity())));
}

TEST(MetricFault, SizesOfMetricsToWorkWithAreAtMostTenToTheFifteenApart) {
  EXPECT_TRUE(is_metric(SymTensor::diagonal(1, 1e29, 1)));
  EXPECT_FALSE(is_metric(SymTensor::diagonal(1, 1e31, 1)));
  EXPECT_EQ(metric_fault(SymTensor::diagonal(1, 1e31, 1)), "") << "files may hold it";
}

}  // namespace
}  // namespace lumesh
