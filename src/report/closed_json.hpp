#pragma once
// Rims of a surface that were closed, as JSON.

#include <nlohmann/json.hpp>
#include <span>

#include "lumesh/surface/reports.hpp"

namespace lumesh::report {

[[nodiscard]] nlohmann::ordered_json closed_json(std::span<const surfaces::ClosedRim> closed);

}  // namespace lumesh::report
