#pragma once
/// @file Counts of operators as JSON.

#include <nlohmann/json.hpp>

#include "lumesh/operators/operators.hpp"

namespace lumesh::cli {

/// Per operator: applied, rejected, contended.
[[nodiscard]] nlohmann::ordered_json counts_json(const operators::OperatorCounts& counts);

}  // namespace lumesh::cli
