#pragma once
/// @file Parts of reading a surface: what is a surface, open ends closed, and what was closed told.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/surface/reports.hpp"

namespace lumesh {

/// Surface of what was read from a file, in mm (LPS), quadrilaterals as two triangles each. Warns of corners
/// that are joined (surfaces::join_torn_corners()).
/// @throws Error{kBadInput} that names the file if it holds a volume.
[[nodiscard]] MixedMesh as_surface(MixedMesh mesh, const std::filesystem::path& path, const Context& context);

/// Closes a surface as read_surface() does; one that is closed stays as it is.
[[nodiscard]] std::vector<surfaces::ClosedRim> close_open_ends(MixedMesh& surface,
                                                               const SurfaceInputOptions& options,
                                                               const Context& context);

/// What meshing makes of a surface before it begins.
struct ClosedForMeshing {
  std::vector<Opening> openings;          ///< Openings at flat ends and at what closes open ones.
  std::vector<surfaces::ClosedRim> rims;  ///< Closed rims, as what they became.
  std::string refusal;                    ///< Why it is not meshed; empty if it is.
};
[[nodiscard]] ClosedForMeshing closed_for_meshing(MixedMesh surface);

/// Gives openings without a name those that the domain of the surface has for their caps. What was filled as
/// a hole and is a flat end all the same, as that of a tube of six sides, is an opening then.
void name_closed(std::vector<surfaces::ClosedRim>& closed, std::span<const FlatEnd> ends);

/// Warns of wide holes that became wall; after name_closed(), where the ends are known.
void warn_of_filled_ends(std::span<const surfaces::ClosedRim> closed, const Context& context);

/// One line for each, the smallest holes together.
[[nodiscard]] std::vector<std::string> closing_lines(std::span<const surfaces::ClosedRim> closed);

}  // namespace lumesh
