#pragma once
/// @file How the boundary of a mesh takes part in its adaptation.

#include <cstddef>
#include <memory>
#include <vector>

#include "lumesh/adapt/adapt_options.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/operators/patch_shapes.hpp"

namespace lumesh {

/// The shapes and places that adapt() works with, and what is to be undone afterwards.
class AdaptedBoundary {
 public:
  /// Cuts the patches of `mesh` at their creases, unless they follow an image, and finds the shape of each.
  /// @throws Error{kBadInput} as operators::follow_image(), which speaks of the image without its name.
  AdaptedBoundary(TetMesh& mesh, const BoundaryOptions& options, Context& context);

  [[nodiscard]] const operators::PatchShapes& shapes() const { return shapes_; }
  /// Patches that follow the image.
  [[nodiscard]] std::size_t patches_on_image() const { return patches_on_image_; }
  /// Within the image, if there is one, else between the planes of openings that all of the mesh lies on one
  /// side of. Good as long as this is.
  [[nodiscard]] const operators::KeepWithin& keep_within() const { return keep_within_; }
  /// Joins what was cut at creases: `mesh` has the patches again that it had.
  void restore_patches(TetMesh& mesh) const;

 private:
  std::vector<PatchId> origins_;
  operators::PatchShapes shapes_;
  std::size_t patches_on_image_ = 0;
  std::shared_ptr<const ImageDomain> image_;
  operators::KeepWithin keep_within_;
};

}  // namespace lumesh
