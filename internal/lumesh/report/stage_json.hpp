#pragma once
/// @file Results of stages as JSON for programs; the pages of the stages describe the fields.

#include <string>
#include <vector>

#include "lumesh/report/command_notes.hpp"
#include "lumesh/stages/centerline_stage.hpp"
#include "lumesh/stages/check_stage.hpp"
#include "lumesh/stages/conversion.hpp"
#include "lumesh/stages/first_mesh.hpp"
#include "lumesh/stages/improve_stage.hpp"
#include "lumesh/stages/merge_stage.hpp"
#include "lumesh/stages/mesh_adaptation.hpp"
#include "lumesh/stages/metric_stage.hpp"
#include "lumesh/stages/phantom_stage.hpp"
#include "lumesh/stages/repair_stage.hpp"

namespace lumesh::report {

[[nodiscard]] std::string lattice_json(const LatticeMesh& made, const FirstMeshComparison& compared,
                                       const CommandNotes& notes);
[[nodiscard]] std::string delaunay_json(const DelaunayFileMesh& made, const FirstMeshComparison& compared,
                                        const CommandNotes& notes);
[[nodiscard]] std::string metric_json(const MeshWithMetric& made, const CommandNotes& notes);
[[nodiscard]] std::string adapt_json(const AdaptedMesh& made, const CommandNotes& notes);
/// @param options  Whose targets count.
[[nodiscard]] std::string improve_json(const ImprovedMesh& made, const ImproveOptions& options,
                                       const CommandNotes& notes);
[[nodiscard]] std::string centerline_json(const CenterlineMade& made, const CommandNotes& notes);
[[nodiscard]] std::string phantom_json(const PhantomMade& made, const CommandNotes& notes);
[[nodiscard]] std::string conversion_json(const MixedMesh& mesh, const CommandNotes& notes);
[[nodiscard]] std::string renaming_json(const RenamedMesh& made, const CommandNotes& notes);

/// @param report  Its remedies are taken as they are.
[[nodiscard]] std::string check_json(const std::string& path, const CheckReport& report);

[[nodiscard]] std::string repair_json(const RepairOutcome& outcome, const CommandNotes& notes);

/// @param paths  Of the meshes that were merged.
[[nodiscard]] std::string merge_json(const MergeReport& report, const std::vector<std::string>& paths,
                                     const CommandNotes& notes);

}  // namespace lumesh::report
