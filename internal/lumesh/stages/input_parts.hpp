#pragma once
/// @file Parts of what front ends begin with: units, edits of voxels, frames, and phantoms as inputs.

#include <filesystem>
#include <span>
#include <string>

#include "lumesh/core/context.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/domain/surface_domain.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/image/phantom.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/metric/sources.hpp"
#include "lumesh/stages/input.hpp"

namespace lumesh {

class OptionList;

/// The unit of lengths in a file that is read, and in one that is written. @param may_stay  Or that of the
/// file that is read.
void describe_unit(OptionList& list, std::string& unit);
void describe_out_unit(OptionList& list, std::string& unit, bool may_stay = false);

/// Changes that the selection asks for of voxels that are there, each with a warning that says how many.
void edit_image(const ImageSelection& selection, Context& context, LabelImage& image);

/// Factors by which coordinates of one mesh come to the frame and unit of another.
[[nodiscard]] Vec3 frame_factors(const MeshInfo& from, const MeshInfo& to);
/// The metric of coordinates that were multiplied by such factors, of the same edge lengths; it is per square
/// of the coordinates' unit.
[[nodiscard]] SymTensor in_frame(const SymTensor& metric, const Vec3& factors);

/// The remedy of commands that take no unit.
inline constexpr char kConvertSaysUnit[] = "lumesh convert --unit";
/// Warns of a unit and of a frame that are not known. @param info  Of the file, or with the unit that the
/// user says. @param remedy  Who says the right unit.
void warn_of_unknown_words(const MeshInfo& info, const std::filesystem::path& path, const std::string& remedy,
                           const Context& context);
/// Warns of patches that a file of several labels without faces has got from its cells, if they are several.
/// @param found  Those patches.
void warn_of_found_patches(const std::string& path, std::span<const Patch> found, const Context& context);
/// Warns that places are told in LPS where the file's are RAS.
void warn_of_ras(const MeshInfo& info, const std::filesystem::path& path, const Context& context);
/// read_mesh() for commands that take no unit; warns of one, and of a frame, that are not known.
[[nodiscard]] MixedMesh read_told_mesh(const std::filesystem::path& path, const Context& context);

/// Doubt about a surface so small, large or thin that its coordinates are hardly mm; empty otherwise.
/// @param given_mm  Around what was read, before cuts and extensions.
[[nodiscard]] std::string unit_doubt(const MixedMesh& surface, std::span<const Opening> openings,
                                     const Box3& given_mm);
/// Doubt about a surface as it was read.
[[nodiscard]] std::string unit_doubt(const MixedMesh& surface, std::span<const Opening> openings = {});
/// Warns of it, unless the unit is given.
void warn_of_unit(const SurfaceInput& surface, std::span<const Opening> openings, const std::string& unit,
                  const std::filesystem::path& path, const Context& context);

/// Triangles and patches of a surface. @param resolution_mm  As in SurfaceView; 0: of its edges.
[[nodiscard]] SurfaceView surface_view(const MixedMesh& surface, double resolution_mm = 0);

/// Axes of a phantom's vessels, with the arrays `radius` (mm) and `branch`.
[[nodiscard]] Polylines centerline_of(const Phantom& phantom);
/// Streamlines of a phantom's flow, with the array `velocity` (m/s).
[[nodiscard]] Polylines velocity_of(const Phantom& phantom);
/// The points of these streamlines as samples.
[[nodiscard]] metric::Flow flow_of(const Phantom& phantom);

}  // namespace lumesh
