#pragma once
/// @file Whether a tensor is a metric.

#include <string_view>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// What keeps a tensor from being a metric, such as "is not finite"; empty if it is finite and positive
/// definite. Ratios of sizes up to about 10^7 between directions that are not the axes are told from rounding
/// in double precision.
[[nodiscard]] std::string_view metric_fault(const SymTensor& tensor);

/// True for a metric to work with: without fault, its sizes along the axes at most 10^15 apart.
[[nodiscard]] bool is_metric(const SymTensor& tensor);

}  // namespace lumesh
