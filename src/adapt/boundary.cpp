#include "lumesh/adapt/boundary.hpp"

#include <algorithm>

#include "lumesh/operators/creases.hpp"
#include "lumesh/operators/settling.hpp"

namespace lumesh {

AdaptedBoundary::AdaptedBoundary(TetMesh& mesh, const BoundaryOptions& options, Context& context)
    : image_(options.image) {
  constexpr double kNoCreases = 180, kTolerance = 1e-10;
  origins_ = context.phase("creases", [&] {
    return operators::cut_patches_at_creases(mesh,
                                             options.is_frozen ? kNoCreases : options.feature_angle_deg);
  });
  shapes_ = context.phase("surfaces", [&] {
    return options.is_frozen
               ? operators::all_frozen(mesh)
               : operators::shapes_of_patches(mesh, kTolerance, operators::SurfaceKeeps::kVolume);
  });
  for (std::size_t part = 0; part < origins_.size(); ++part)
    if (std::find(options.frozen_patches.begin(), options.frozen_patches.end(), origins_[part]) !=
        options.frozen_patches.end())
      shapes_[part] = {};
  if (options.is_frozen || !options.image) return;
  patches_on_image_ =
      context.phase("surfaces", [&] { return operators::follow_image(mesh, options.image, shapes_); });
}

operators::KeepWithin AdaptedBoundary::keep_within() const {
  return image_ ? operators::within_cuts_of(*image_) : operators::KeepWithin();
}

void AdaptedBoundary::restore_patches(TetMesh& mesh) const {
  operators::join_patches(mesh, origins_);
}

}  // namespace lumesh
