#pragma once
/// @file What the pipeline and the program's commands begin with: images, surfaces and phantoms, brought into
/// one form.

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/domain/surface_domain.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/image/phantom.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/polylines.hpp"

namespace lumesh {

/// Which voxels of an image count.
struct ImageSelection {
  std::vector<Label> labels;          ///< These only; all if empty.
  std::optional<double> threshold;    ///< Voxels at or above become label 1, the rest background.
  std::size_t largest_component = 0;  ///< Not 0: only the largest connected piece.
};

/// @throws Error{kBadInput} that names the file.
[[nodiscard]] LabelImage read_selected_image(const std::filesystem::path& path,
                                             const ImageSelection& selection, Context& context);

/// Meshes may stand in another frame or unit than images do. Wanted edge lengths and those in the metric
/// stay.
void bring_to_lps_mm(MixedMesh& mesh);

/// The inside of the closed surface of a file, in mm (LPS).
/// @throws Error{kBadInput} that names the file.
[[nodiscard]] std::unique_ptr<SurfaceDomain> read_surface_domain(const std::filesystem::path& path,
                                                                 const SurfaceDomainOptions& options,
                                                                 Context& context);

/// Axes of a phantom's vessels, with the arrays `radius` (mm) and `branch`.
[[nodiscard]] Polylines centerline_of(const Phantom& phantom);
/// Streamlines of a phantom's flow, with the array `velocity` (m/s).
[[nodiscard]] Polylines velocity_of(const Phantom& phantom);

}  // namespace lumesh
