#pragma once
/// @file Cards with what layers achieved.

#include <string>

#include "lumesh/report/layers_report.hpp"

namespace lumesh::report {

/// Patch by patch: thickness, shares of the area, reasons, and worst places.
[[nodiscard]] std::string coverage_section(const LayerReport& report);
/// How much of the thickness the columns have, as a histogram.
[[nodiscard]] std::string shares_section(const LayerShares& surface);
/// Shapes of the core and of the layers' cells, beside each other.
[[nodiscard]] std::string parts_section(const LayersOfMesh& layers);

}  // namespace lumesh::report
