#pragma once
/// @file How surfaces enter: read, closed where they are open, and what was closed told.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/domain/surface_domain.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/stages/input_cuts.hpp"
#include "lumesh/surface/closing.hpp"

namespace lumesh {

class OptionList;

struct SurfaceInputOptions {
  SurfaceDomainOptions domain;
  std::string patch_array;  ///< Of .vtp: the array of cells that says the patches; empty: one known.
  bool keeps_open = false;  ///< Open surfaces stay so, and are refused by what needs closed ones.

  void describe(OptionList& list);
  void validate() const;  ///< @throws Error{kUsage}, naming the field.
};

/// A surface of triangles in mm (LPS), and what was closed of it.
struct SurfaceInput {
  MixedMesh mesh;  ///< Caps are patches of PatchKind::kOpening without a name, last.
  std::vector<surfaces::ClosedRim> closed;
  /// Of what was read, where it was cut or extended since, as sizes are taken from it; 0: of `mesh`.
  double resolution_mm = 0;

  /// The inside. @throws Error{kBadInput}, Error{kUsage} as SurfaceDomain does.
  [[nodiscard]] std::unique_ptr<SurfaceDomain> domain(const SurfaceDomainOptions& options) const;
};

/// What was read from a file, in mm (LPS), quadrilaterals as two triangles each.
/// @throws Error{kBadInput} that names the file if it holds a volume.
[[nodiscard]] MixedMesh as_surface(MixedMesh mesh, const std::filesystem::path& path);

/// Reads a surface, closes it where it is open, and cuts and extends it.
/// @param unit  Of its coordinates; empty: as the file says, or mm.
/// @throws Error{kBadInput} that names the file if it cannot be read or holds a volume, or cannot be cut.
[[nodiscard]] SurfaceInput read_surface(const std::filesystem::path& path, const std::string& unit,
                                        const SurfaceInputOptions& options, const InputCuts& cuts,
                                        const Context& context);

/// Closes a surface as read_surface() does; one that is closed stays as it is. Warns of wide holes that
/// became wall.
[[nodiscard]] std::vector<surfaces::ClosedRim> close_open_ends(MixedMesh& surface,
                                                               const SurfaceInputOptions& options,
                                                               const Context& context);

/// Gives openings without a name those that the domain of the surface has for their caps.
void name_closed(std::vector<surfaces::ClosedRim>& closed, std::span<const FlatEnd> ends);

/// One line for each, the smallest holes together.
[[nodiscard]] std::vector<std::string> closing_lines(std::span<const surfaces::ClosedRim> closed);

}  // namespace lumesh
