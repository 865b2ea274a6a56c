#pragma once
/// @file What layers achieved as JSON, both ways.

#include <nlohmann/json.hpp>

#include "lumesh/report/layers_report.hpp"

namespace lumesh::report {

/// Without the surface.
[[nodiscard]] nlohmann::ordered_json coverage_json(const LayerReport& report);
/// It with the measures of both parts.
[[nodiscard]] nlohmann::ordered_json layers_of_mesh_json(const LayersOfMesh& layers);

/// All of the report, which layer_report_of() gives back bit by bit.
[[nodiscard]] nlohmann::ordered_json whole_report_json(const LayerReport& report);
/// @throws nlohmann::json::exception if it is something else.
[[nodiscard]] LayerReport layer_report_of(const nlohmann::ordered_json& json);

}  // namespace lumesh::report
