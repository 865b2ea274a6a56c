#include "lumesh/adapt/boundary.hpp"

#include "lumesh/operators/creases.hpp"

namespace lumesh {

AdaptedBoundary::AdaptedBoundary(TetMesh& mesh, const BoundaryOptions& options, Context& context) {
  constexpr double kNoCreases = 180;
  origins_ = context.phase("creases", [&] {
    return operators::cut_patches_at_creases(mesh,
                                             options.is_frozen ? kNoCreases : options.feature_angle_deg);
  });
  shapes_ = context.phase("surfaces", [&] {
    return options.is_frozen ? operators::all_frozen(mesh) : operators::shapes_of_patches(mesh);
  });
  if (options.is_frozen || !options.image) return;
  patches_on_image_ =
      context.phase("surfaces", [&] { return operators::follow_image(mesh, options.image, shapes_); });
}

void AdaptedBoundary::restore_patches(TetMesh& mesh) const {
  operators::join_patches(mesh, origins_);
}

}  // namespace lumesh
