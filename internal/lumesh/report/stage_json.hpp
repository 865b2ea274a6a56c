#pragma once
/// @file Results of stages as JSON for programs; the pages of the stages describe the fields.

#include <span>
#include <string>
#include <vector>

#include "lumesh/adapt/improve.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/mesh/merge.hpp"
#include "lumesh/stages/adapt_stage.hpp"
#include "lumesh/stages/check_stage.hpp"
#include "lumesh/stages/delaunay_stage.hpp"
#include "lumesh/stages/mesh_cut.hpp"
#include "lumesh/stages/repair_stage.hpp"
#include "lumesh/surface/reports.hpp"

namespace lumesh::report {

/// @param context  Times of its phases are the report's, too. @param seconds  Whole time.
[[nodiscard]] std::string adapt_json(const AdaptResult& result, const Context& context, double seconds);

/// @param closed  Rims that were closed of a surface. @param differences  Of the mesh from the image.
[[nodiscard]] std::string delaunay_json(const DelaunayMesh& made, const OpeningsCompared& openings,
                                        std::span<const surfaces::ClosedRim> closed,
                                        const std::vector<std::string>& differences, const Context& context);

/// @param options  Whose targets count. @param cut  What was cut off before.
[[nodiscard]] std::string improve_json(const ImproveReport& report, const ImproveOptions& options,
                                       const CutMesh& cut, double seconds);

/// @param report  Its remedies are taken as they are.
[[nodiscard]] std::string check_json(const std::string& path, const CheckReport& report);

[[nodiscard]] std::string repair_json(const RepairOutcome& outcome);

/// @param paths  Of the meshes that were merged.
[[nodiscard]] std::string merge_json(const MergeReport& report, const std::vector<std::string>& paths);

}  // namespace lumesh::report
