#pragma once
/// @file Results of stages in a few lines for the terminal, each ending with a line break. Where there is
/// one, `path` is the name of the file that was made.

#include <string>

#include "lumesh/core/context.hpp"
#include "lumesh/stages/centerline_stage.hpp"
#include "lumesh/stages/check_stage.hpp"
#include "lumesh/stages/conversion.hpp"
#include "lumesh/stages/first_mesh.hpp"
#include "lumesh/stages/improve_stage.hpp"
#include "lumesh/stages/merge_stage.hpp"
#include "lumesh/stages/mesh_adaptation.hpp"
#include "lumesh/stages/phantom_stage.hpp"
#include "lumesh/stages/repair_stage.hpp"

namespace lumesh::report {

/// @param context  Whose phases are told. @param seconds  Wall time.
[[nodiscard]] std::string lattice_text(const std::string& path, const LatticeMesh& made,
                                       const OpeningsCompared& openings, const Context& context,
                                       double seconds);
[[nodiscard]] std::string delaunay_text(const std::string& path, DelaunayFileMesh& made,
                                        const OpeningsCompared& openings, const Context& context,
                                        double seconds);
[[nodiscard]] std::string adapt_text(const std::string& path, const AdaptedMesh& made, double seconds);
[[nodiscard]] std::string improve_text(const std::string& path, const ImprovedMesh& made,
                                       const ImproveRequest& request, double seconds);
[[nodiscard]] std::string centerline_text(const std::string& path, const CenterlineMade& made,
                                          double seconds);
[[nodiscard]] std::string phantom_text(const PhantomRequest& request, const PhantomMade& made);
[[nodiscard]] std::string conversion_text(const MeshOutput& output, const MixedMesh& mesh);
[[nodiscard]] std::string renaming_text(const std::string& path, const RenamedMesh& made);
[[nodiscard]] std::string repair_text(const std::string& path, const RepairOutcome& outcome);
/// @param inputs  Names of the meshes that were merged.
[[nodiscard]] std::string merge_text(const std::string& path, const MergeResult& merged,
                                     const std::vector<std::string>& inputs);
/// @param path  Name of the file that was checked.
[[nodiscard]] std::string check_text(const std::string& path, const CheckReport& report);

}  // namespace lumesh::report
