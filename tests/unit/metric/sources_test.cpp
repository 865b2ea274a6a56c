#include "lumesh/metric/sources.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace lumesh::metric {
namespace {

TEST(MetricSources, AreAskedForByTheFirstOptionOfEach) {
  const std::vector<std::string> expected = {"analytic", "metric",  "points",
                                             "velocity", "hessian", "curvature"};
  EXPECT_EQ(MetricRequest::source_options(), expected);
}

TEST(MetricSources, AreHeldToTheUsualGrowthUnlessTheyAreTakenAsTheyAre) {
  const auto growth_of = [](const auto& ask) {
    MetricRequest request;
    ask(request);
    return request.limits_for(false).growth;
  };
  EXPECT_EQ(growth_of([](MetricRequest&) {}), 0);
  EXPECT_EQ(growth_of([](auto& r) { r.template source<AnalyticSource>().formula = AnalyticKind::kLinear; }),
            0);
  EXPECT_EQ(growth_of([](auto& r) { r.template source<TensorSource>().file = "a.sol"; }), 0);
  EXPECT_EQ(growth_of([](auto& r) { r.template source<PointSource>().points = "a.vtp"; }), 1.5);
  EXPECT_EQ(growth_of([](auto& r) { r.template source<VelocitySource>().velocity = "a.vtp"; }), 1.5);
  EXPECT_EQ(growth_of([](auto& r) { r.template source<HessianSource>().field = "pressure"; }), 1.5);
  EXPECT_EQ(growth_of([](auto& r) { r.template source<CurvatureSource>().curvature = true; }), 1.5);
  EXPECT_EQ(growth_of([](auto& r) {
              r.template source<TensorSource>().file = "a.sol";
              r.gradation = 1.2;
            }),
            1.2);
}

}  // namespace
}  // namespace lumesh::metric
