#pragma once
/// @file Pages and pictures of single results, drawn and put together, for the file that a user names.

#include <string>

#include "lumesh/core/context.hpp"
#include "lumesh/quality/evaluation.hpp"
#include "lumesh/report/layers_report.hpp"
#include "lumesh/stages/check_stage.hpp"

namespace lumesh::report {

/// report_html() with its pictures. @param path  Name of the mesh, of which the page's title is the last
/// part.
[[nodiscard]] std::string evaluation_page(const std::string& path, const MeshView& mesh,
                                          const quality::Evaluation& evaluation, Context& context);
/// check_html() with its pictures. @param path  Name of the file that was checked.
[[nodiscard]] std::string check_page(const std::string& path, const CheckReport& report, Context& context);
/// layers_html() with its pictures. @param path, info  Name of the mesh with its layers, and what it says.
[[nodiscard]] std::string layers_page(const std::string& path, const LayersOfMesh& layers,
                                      const MeshInfo& info, Context& context);
/// The surface of a mesh with the names of its openings, as a PNG file.
[[nodiscard]] std::string surface_png(const MeshView& mesh);

}  // namespace lumesh::report
