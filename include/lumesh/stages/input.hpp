#pragma once
/// @file What the pipeline and the program's commands begin with: images, surfaces and phantoms, brought into
/// one form.

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/domain/surface_domain.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/image/phantom.hpp"
#include "lumesh/image/touching.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/source_data.hpp"

namespace lumesh {

/// Which voxels of an image count.
struct ImageSelection {
  std::vector<Label> labels;              ///< These only; all if empty.
  std::optional<double> threshold;        ///< Voxels at or above become label 1, the rest background, …
  std::optional<double> threshold_up_to;  ///< … unless they are above this.
  std::optional<double> below;            ///< The same for voxels at or below.
  std::optional<LevelSetSide> level_set;  ///< Label 1 is where a level set has this sign.
  std::string probabilities;    ///< Image that places the object's boundary between voxels; empty: none.
  LabelledFiles label_images;   ///< More labels on the same grid.
  std::optional<double> frame;  ///< A whole number: the one that counts of several volumes.
  bool all_frames = false;      ///< Each of them, one after the other.
  std::size_t drop_below = 0;   ///< Pieces of fewer voxels become background.
  bool fill_cavities = false;   ///< Background that the labels enclose gets a label.
  TouchChoice touching = TouchChoice::kKeep;  ///< What becomes of vessels side by side that touch.
  std::string unit;                ///< Of lengths in the file; empty: as it says. See describe_unit().
  bool largest_component = false;  ///< Only the largest connected piece of all labels together.

  /// Names of the options that are not as they are by default.
  [[nodiscard]] std::vector<std::string> given() const;
  /// Paths of images beside the one that it is of.
  [[nodiscard]] std::vector<std::string> other_files() const;
  /// @throws Error{kUsage} if the frame is no whole number.
  [[nodiscard]] ImageReadOptions read_options() const;
  /// @throws Error{kUsage} if all frames are wanted, where one is needed.
  [[nodiscard]] std::optional<std::size_t> one_frame() const;

  /// @param has_probabilities  Whether the boundary's place matters, not only the voxels.
  void describe(OptionList& list, bool has_probabilities = true);
};

/// The unit of lengths in a file that is read, and in one that is written.
void describe_unit(OptionList& list, std::string& unit);
void describe_out_unit(OptionList& list, std::string& unit);

/// Changes that the selection asks for of voxels that are there, each with a warning that says how many.
void edit_image(const ImageSelection& selection, Context& context, LabelImage& image);

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

/// A mesh in the unit that is said of it; empty: as the file says, or mm.
[[nodiscard]] MixedMesh read_mesh_in(const std::filesystem::path& path, const std::string& unit);

/// What to say of a surface so small, large or thin that its coordinates are hardly mm; empty otherwise.
[[nodiscard]] std::string unit_doubt(const MixedMesh& surface, std::span<const Opening> openings);
/// Warns of it, unless the unit is given.
void warn_of_unit(const MixedMesh& surface, std::span<const Opening> openings, const std::string& unit,
                  const std::filesystem::path& path, const Context& context);

/// Triangles and patches of a surface. @param resolution_mm  As in SurfaceView; 0: of its edges.
[[nodiscard]] SurfaceView surface_view(const MixedMesh& surface, double resolution_mm = 0);

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
