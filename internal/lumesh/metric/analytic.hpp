#pragma once
/// @file Metrics given by formulas: the benchmark of the Unstructured Grid Adaptation Working Group (UGAWG).

#include "lumesh/metric/metric_field.hpp"

namespace lumesh::metric {

/// The metric at `point` with all sizes multiplied by `size_factor`.
[[nodiscard]] MetricPair analytic_metric(AnalyticKind kind, const Vec3& point, double size_factor = 1);

}  // namespace lumesh::metric
