#pragma once
/// @file What the pipeline and the program's commands begin with: images, surfaces and meshes, brought into
/// one form, and what is cut off or extended of them.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/domain/extension.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/domain/surface_domain.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/metric/sources.hpp"
#include "lumesh/surface/reports.hpp"

namespace lumesh {

class ImageDomain;
struct LabelFieldOptions;

/// Treatment of vessels side by side that touch, or are at most a voxel apart.
enum class TouchChoice : std::uint8_t {
  kKeep,
  kSeparate,  ///< A layer of voxels or two between them becomes background.
  kJoin,      ///< The cleft between them is filled.
};

/// Which voxels of an image count.
struct ImageSelection {
  std::vector<std::string> labels;        ///< These only, by their numbers or names; all if empty.
  std::optional<double> threshold;        ///< Voxels at or above become label 1, the rest background, …
  std::optional<double> threshold_up_to;  ///< … unless they are above this.
  std::optional<double> below;            ///< Threshold for voxels at or below it.
  std::optional<LevelSetSide> level_set;  ///< Label 1 is where a level set has this sign.
  std::string probabilities;    ///< Image that places the object's boundary between voxels; empty: none.
  LabelledFiles label_images;   ///< More labels on the same grid.
  std::optional<double> frame;  ///< A whole number: the one that counts of several volumes.
  bool all_frames = false;      ///< Each of them, one after the other.
  /// Openings of the frames before, whose names those at the same places get; null: names are by area.
  std::shared_ptr<std::vector<Opening>> openings_of_frames = nullptr;
  std::size_t drop_below = 0;                 ///< Pieces of fewer voxels become background.
  bool fill_cavities = false;                 ///< Background that the labels enclose gets a label.
  TouchChoice touching = TouchChoice::kKeep;  ///< Treatment of vessels side by side that touch.
  std::string unit;                ///< Unit of lengths in the file; empty: as it says. See describe_unit().
  bool largest_component = false;  ///< The largest connected piece of all labels, alone.

  /// Names of the options that are not as they are by default.
  [[nodiscard]] std::vector<std::string> given() const;
  /// @throws Error{kUsage} that names an option that is given, where the path of the image is empty.
  void require_image(const std::string& path) const;
  /// Paths of images beside the one that it is of.
  [[nodiscard]] std::vector<std::string> other_files() const;
  /// @throws Error{kUsage} if the frame is no whole number.
  [[nodiscard]] ImageReadOptions read_options() const;
  /// @throws Error{kUsage} if all frames are wanted, where one is needed.
  [[nodiscard]] std::optional<std::size_t> one_frame() const;

  /// @param has_probabilities  Whether the boundary's place matters, not only the voxels.
  void describe(OptionList& list, bool has_probabilities = true);
};

/// The labels of an image that the selection keeps, changed as it says, in LPS and mm. Warns of what it finds
/// doubtful. Threads: any number at the same time, each with a context of its own.
/// @throws Error{kBadInput} that names the file, where it cannot be read or holds nothing that is selected;
/// Error{kUsage} where the selection does not fit it.
[[nodiscard]] LabelImage read_selected_image(const std::filesystem::path& path,
                                             const ImageSelection& selection, Context& context);

/// Cuts of an image or a surface, and extensions beyond its openings.
struct InputCuts {
  std::vector<CutPlane> planes = {};     ///< Unbounded planes.
  std::vector<Vec3> places_mm = {};      ///< Each cuts the one vessel there, square to its axis.
  std::optional<LocalLength> ends = {};  ///< How far from each end it is cut; none: not.
  ExtensionOptions extension = {};       ///< Extension of what is left.

  [[nodiscard]] bool none() const { return planes.empty() && is_whole(); }
  /// True if nothing but planes, which phantoms may have too, cuts or extends.
  [[nodiscard]] bool is_whole() const { return places_mm.empty() && !ends && !extension.is_wanted(); }

  void describe(OptionList& list);
  /// @throws Error{kUsage} that names the option.
  void validate() const;
};

/// Cuts the vessels at the places, as cut_off_vessel() does, one after the other: each at the point of the
/// centerlines of its piece that is the fewest radii away. Then each end of the centerlines of the whole is
/// cut off, as far before it as `ends` says, in radii at that place; one that can't be stays, with a warning.
///
/// @param image  Loses what lies beyond.
/// @return Those and the whole planes, for ImageDomainOptions.
/// @throws Error{kBadInput} for a place without the object within three voxels, or more than two radii from
/// any axis, or beyond a cut before it; and as extract_centerline() and cut_off_vessel() do. Cost and
/// threads: for each place as these.
[[nodiscard]] std::vector<CutPlane> cut_off(LabelImage& image, const InputCuts& cuts, Context& context);

/// The domain of an image after cut_off(), extended as asked for. @param image, planes  Where it is extended:
/// become those of the result. @throws Error{kBadInput} as ImageDomain and extend_openings(), and if there is
/// no opening to extend.
[[nodiscard]] std::shared_ptr<const ImageDomain> domain_of_cut(LabelImage& image,
                                                               std::vector<CutPlane>& planes,
                                                               const InputCuts& cuts,
                                                               const LabelFieldOptions& field,
                                                               Context& context);

struct SurfaceInputOptions {
  SurfaceDomainOptions domain;
  std::string patch_array;  ///< Name of the array of a .vtp's cells that says the patches; empty: one known.
  bool keeps_open = false;  ///< Open surfaces stay so, and are refused by what needs closed ones.

  void describe(OptionList& list);
  void validate() const;  ///< @throws Error{kUsage}, naming the field.
};

/// A surface of triangles in mm (LPS), and what was closed of it.
struct SurfaceInput {
  MixedMesh mesh;  ///< Caps are patches of PatchKind::kOpening without a name, last.
  std::vector<surfaces::ClosedRim> closed;
  /// Resolution of what was read, where it was closed, cut or extended since, as sizes are taken from it; 0:
  /// that of `mesh`.
  double resolution_mm = 0;
  std::vector<Opening> beginnings = {};  ///< Openings before they were extended; none where none was.
  Box3 given_box_mm = {};                ///< Around what was read.

  /// The inside. @throws Error{kBadInput}, Error{kUsage} as SurfaceDomain does.
  [[nodiscard]] std::unique_ptr<SurfaceDomain> domain(const SurfaceDomainOptions& options) const;
};

/// Reads a surface, closes it where it is open, and cuts and extends it.
/// @param unit  Of its coordinates; empty: as the file says, or mm.
/// @throws Error{kBadInput} that names the file if it cannot be read or holds a volume, or cannot be cut.
[[nodiscard]] SurfaceInput read_surface(const std::filesystem::path& path, const std::string& unit,
                                        const SurfaceInputOptions& options, const InputCuts& cuts,
                                        const Context& context);

/// Meshes may stand in another frame or unit than images and options do. Wanted edge lengths and those in the
/// metric stay.
/// @return The frame and unit that the mesh had, with which bring_to() brings it back.
MeshInfo bring_to_lps_mm(MixedMesh& mesh);
/// The mesh in the frame and unit of another one.
void bring_to(MixedMesh& mesh, const MeshInfo& frame);
/// The points of a file in the frame and unit of a mesh.
/// @throws Error{kBadInput} that names the file.
[[nodiscard]] std::vector<Vec3> read_points_in(const MeshInfo& frame, const std::filesystem::path& path);

/// Points of a file with a velocity each, in that frame and unit.
/// @param array  Name of the array; empty: "velocity", or the only one.
/// @param unit  Of its coordinates; empty: as the file says, or mm.
[[nodiscard]] metric::Flow read_flow_in(const MeshInfo& frame, const std::filesystem::path& path,
                                        const std::string& array, const std::string& unit);

/// A mesh in the unit that is said of it; empty: as the file says, or mm. Warns of a unit, and of a frame,
/// that are not known.
[[nodiscard]] MixedMesh read_mesh_in(const std::filesystem::path& path, const std::string& unit,
                                     const Context& context);

}  // namespace lumesh
