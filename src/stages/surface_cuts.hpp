#pragma once
// What of a surface is cut off before it is meshed, and how far it goes on beyond its ends.

#include "lumesh/core/context.hpp"
#include "lumesh/stages/input_cuts.hpp"
#include "lumesh/stages/surface_input.hpp"

namespace lumesh {

class PatchedSurface;

/// Cuts a closed surface by the planes, then its vessels at the places, then their ends, as cut_off() does
/// with images, and caps what was cut; then extends it from its flat ends. Caps are patches of
/// PatchKind::kOpening without a name; where the surface is extended, all patches are those of its domain.
/// @param surface  Openings that are cut away leave the list of what was closed.
/// @throws Error{kBadInput} as cut_off_beyond(), cut_off_end(), extract_centerline() and extrude_openings()
/// do, and if there is no flat end to extend.
void cut_and_extend(SurfaceInput& surface, const InputCuts& cuts, const SurfaceDomainOptions& options,
                    const Context& context);

/// Replaces the patches of a surface by those of its parts, among them its flat ends.
void take_patches_of(const PatchedSurface& surface, MixedMesh& mesh);

}  // namespace lumesh
