#pragma once
/// @file The stage that makes synthetic images with what is known of them, for every front end.

#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/image/phantom.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/mesh/polylines.hpp"

namespace lumesh {

/// Files to write; an empty path is not wanted.
struct PhantomRequest {
  PhantomSpec spec;
  std::string image;
  std::string parameters;  ///< Empty: beside the image, see parameters_path().
  std::string centerline;  ///< Axes with their radii.
  std::string velocity;    ///< Streamlines.

  /// "case1.phantom.json" for the image "case1.nrrd"; a double extension such as .nii.gz goes as a whole.
  [[nodiscard]] std::string parameters_path() const;
};

struct PhantomMade {
  Phantom phantom;
  std::vector<LabelTopology> labels;  ///< What the voxels of each label amount to.
  std::vector<double> volumes_mm3;    ///< Exact volumes of these labels.
  Polylines centerline, velocity;     ///< Without lines where the phantom has none.
};

/// Makes the image and writes all files.
/// @throws Error{kUsage} as Phantom, and for lines that the phantom does not have, before anything is
/// written.
[[nodiscard]] PhantomMade make_phantom(const PhantomRequest& request, Context& context);

}  // namespace lumesh
