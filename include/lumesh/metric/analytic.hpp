#pragma once
/// @file Metrics given by formulas: the benchmark of the Unstructured Grid Adaptation Working Group (UGAWG).

#include <cstdint>
#include <optional>
#include <string_view>

#include "lumesh/geometry/sym_tensor.hpp"

namespace lumesh::metric {

/// The metric of a point with its logarithm.
struct MetricPair {
  SymTensor metric, log;
};

/// Sizes in the unit of the points, made for the unit cube. r and t are polar coordinates around the z axis.
/// - linear: 0.1 along x and y, 0.001 + 0.198 |z - 0.5| along z.
/// - polar-1: 0.001 + 0.198 |r - 0.5| along r, 0.1 along t and z.
/// - polar-2: as polar-1, but 0.1 d + 0.025 (1 - d) along t with d = min(1, 10 |r - 0.5|), as published codes
///   use it; the benchmark's own page misprints it.
/// Source: https://github.com/UGAWG/adapt-benchmarks.
enum class AnalyticKind : std::uint8_t { kLinear, kPolar1, kPolar2 };

/// linear, polar-1, polar-2.
[[nodiscard]] std::optional<AnalyticKind> analytic_kind_from(std::string_view name);

/// The metric at `point` with all sizes multiplied by `size_factor`.
[[nodiscard]] MetricPair analytic_metric(AnalyticKind kind, const Vec3& point, double size_factor = 1);

}  // namespace lumesh::metric
