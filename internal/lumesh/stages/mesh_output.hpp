#pragma once
/// @file Finished meshes: where they are written, and whether they can be computed on.

#include <string>

#include "lumesh/core/context.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

class OptionList;

/// Files that a mesh goes to.
struct MeshOutput {
  std::string mesh = {};     ///< Path.
  std::string surface = {};  ///< Path of its boundary alone; empty: not written.
  std::string unit = "mm";   ///< Unit of lengths in both; empty: as they are.
  MeshWriteOptions options = {};
};
/// Faces between cells that the file has no place for are warned of.
void write_mesh(const MeshOutput& output, const MeshView& mesh, Context& context);
/// Writes the outer boundary as write_surface() of lumesh/io/mesh_file.hpp; faces that are left out are told.
void write_surface(const std::string& path, const MeshView& mesh, const Context& context,
                   const MeshWriteOptions& options = {});
/// The option for the path of a boundary alone.
void describe_surface_output(OptionList& list, std::string& path);

/// Warns of names of patches that the format of the file writes otherwise, as OpenFOAM and SimVascular need,
/// or has no place for.
void warn_of_names(const std::string& path, const MeshView& mesh, const Context& context);

/// A line if pieces of the mesh, of all labels together, have no opening while others have one, or if one of
/// several pieces has a single one; else empty.
/// @param least_share  Of the largest piece's volume: smaller pieces are not told. Cost: linear, on one
/// thread.
[[nodiscard]] std::string sealed_pieces_warning(const MeshView& mesh, double least_share = 0);
/// Warns of that.
void warn_of_sealed_pieces(const MeshView& mesh, const Context& context, double least_share = 0);

/// Looks at a mesh that was written, quickly.
/// @param besides  What else has to be said then. @param made_from  The mesh that it was made from, if any,
/// which may have had faults before.
/// @throws Error{kNotReached} if it has faults that no simulation survives (quality/faults.hpp).
void require_sound(const std::string& path, const MeshView& mesh, Context& context,
                   const std::string& besides = "", const MeshView* made_from = nullptr);

/// Warnings of such faults, of a mesh that is handed on as it is.
void warn_of_faults(const std::string& path, const MeshView& mesh, const Context& context);

}  // namespace lumesh
