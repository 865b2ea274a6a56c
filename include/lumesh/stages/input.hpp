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
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/source_data.hpp"

namespace lumesh {

class OptionList;

/// Which voxels of an image count.
struct ImageSelection {
  std::vector<Label> labels;        ///< These only; all if empty.
  std::optional<double> threshold;  ///< Voxels at or above become label 1, the rest background.
  std::optional<double> below;      ///< The same for voxels at or below.
  std::string probabilities;        ///< Image that places the object's boundary between voxels; empty: none.
  bool largest_component = false;   ///< Only the largest connected piece of all labels together.

  [[nodiscard]] bool has_level() const { return threshold || below; }
  [[nodiscard]] bool takes_all() const {
    return labels.empty() && !has_level() && probabilities.empty() && !largest_component;
  }

  /// @param has_probabilities  Whether the boundary's place matters, not only the voxels.
  void describe(OptionList& list, bool has_probabilities = true);
};

/// @throws Error{kBadInput} that names the file.
[[nodiscard]] LabelImage read_selected_image(const std::filesystem::path& path,
                                             const ImageSelection& selection, Context& context);

/// Meshes may stand in another frame or unit than images do. Wanted edge lengths and those in the metric
/// stay.
void bring_to_lps_mm(MixedMesh& mesh);
/// The same for the frame and unit of another mesh.
void bring_to(MixedMesh& mesh, const MeshInfo& frame);

/// What the coordinates of one mesh are multiplied by to stand in the frame and unit of another.
[[nodiscard]] Vec3 frame_factors(const MeshInfo& from, const MeshInfo& to);

/// The points of a file in the frame and unit of a mesh.
/// @throws Error{kBadInput} that names the file.
[[nodiscard]] std::vector<Vec3> read_points_in(const MeshInfo& frame, const std::filesystem::path& path);

/// The same for points with a velocity each.
/// @param array  Name of the array; empty: "velocity", or the only one.
[[nodiscard]] metric::Flow read_flow_in(const MeshInfo& frame, const std::filesystem::path& path,
                                        const std::string& array);

/// Warns of a surface so small or large that its coordinates are hardly mm.
void warn_of_unit(const MixedMesh& surface, const std::filesystem::path& path, const Context& context);

/// Its inside. @throws Error{kBadInput}, Error{kUsage} as SurfaceDomain does.
[[nodiscard]] std::unique_ptr<SurfaceDomain> domain_of(const MixedMesh& surface,
                                                       const SurfaceDomainOptions& options);

/// Axes of a phantom's vessels, with the arrays `radius` (mm) and `branch`.
[[nodiscard]] Polylines centerline_of(const Phantom& phantom);
/// Streamlines of a phantom's flow, with the array `velocity` (m/s).
[[nodiscard]] Polylines velocity_of(const Phantom& phantom);
/// The points of these streamlines as samples.
[[nodiscard]] metric::Flow flow_of(const Phantom& phantom);

}  // namespace lumesh
