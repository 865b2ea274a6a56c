#pragma once
/// @file Segmented images from and to files.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// Thrown for an image of grey values that is read as if they were labels.
class NotLabels : public Error {
 public:
  using Error::Error;
};

/// The sign that a level set, such as a signed distance, has inside of the object.
enum class LevelSetSide : std::uint8_t { kNegative, kPositive };

/// A mask, or an image of probabilities, and the label that it stands for.
struct LabelledFile {
  std::filesystem::path path;
  Label label = 1;
};

/// Selection from an image that is read.
struct ImageReadOptions {
  /// Keep these only, and those of the names, the rest becomes background; all if both are empty.
  std::vector<Label> labels = {};
  std::vector<std::string> label_names = {};  ///< Names that the file gives to labels.
  /// Voxels >= threshold become label 1, the rest background; excludes `labels`.
  std::optional<double> threshold = {};
  /// The same for voxels <= below; with `threshold` for those from that to this. Excludes `labels`.
  std::optional<double> below = {};
  std::optional<LevelSetSide> level_set = {};  ///< Label 1 is inside of the zero set; excludes the above.
  /// Image of the probability of the object (all labels together) on the same grid, which says where its
  /// boundary runs between the voxels; empty: none. Excludes `threshold`, `below`, `level_set` and
  /// `label_images`.
  std::filesystem::path probabilities = {};
  /// More labels on the same grid. Voxels of several files have the label of the first; the image itself
  /// comes before all.
  std::vector<LabelledFile> label_images = {};
  std::optional<std::size_t> frame = {};  ///< The one that counts of several volumes.
  std::optional<double> unit_mm = {};     ///< Unit of the image's lengths, whatever its header says.
};

/// Reads a label image: NIfTI (.nii, .nii.gz), NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), GIPL (.gipl,
/// .gipl.gz), or a DICOM series (its folder, or one file of it). Positions are millimetres in LPS whatever
/// the file's frame.
///
/// Integer voxels, or floats with integral values, of at most 65,535 different labels; or floats with
/// fractions: probabilities if all are from 0 to 1, which are taken as if the threshold were 0.5; a level set
/// if they change sign with one slope of about one, with a warning that says which side is taken for the
/// inside. Several volumes of floats from 0 to 1 are the probabilities of as many labels, the first of them
/// the background's if they add up to 1. Where there are values besides labels, they set the image's
/// crossings. Voxels that are not numbers (NaN) are background, with a warning. Direction cosines that are
/// not orthonormal are replaced by the nearest orthonormal ones: with a warning when no voxel axis turns by
/// more than 3 degrees, else refused. Labels have the names that 3D Slicer gives its segments (.seg.nrrd).
///
/// More than 32 different whole numbers of which neighbours mostly differ are grey values, unless
/// `labels` are given.
///
/// @throws NotLabels for grey values, with their range and a threshold; Error{kBadInput} for every fault of
/// the file (missing, truncated, 2-D, spacing, labels, no such frame); the message is one line with the file,
/// the fault and the remedy. Error{kMemory} if the voxels do not fit in memory; Error{kUsage} if options are
/// set that exclude each other. Memory: the file's voxels in their own type plus 2 bytes a voxel. Threads:
/// same result for every number of them.
[[nodiscard]] LabelImage read_image(const std::filesystem::path& path, const ImageReadOptions& options,
                                    Context& context);

/// How many volumes an image has: frames of a 4-D image, or values of each voxel. Cost: its header is read.
/// @throws Error{kBadInput} as read_image().
[[nodiscard]] std::size_t count_frames(const std::filesystem::path& path);

/// One number per voxel, such as a wanted size in mm.
struct NumberImage {
  ImageFrame frame;
  std::vector<float> values;  ///< frame.voxel_count(), i runs fastest.
};

/// Reads an image of numbers from the formats of read_image(), in the same frame; rescaled as the file says.
/// @param frame  Of several volumes.
/// @throws Error as read_image() for faults of the file; what the numbers are is not looked at. Memory: the
/// file's voxels in their own type plus 4 bytes a voxel.
[[nodiscard]] NumberImage read_number_image(const std::filesystem::path& path, Context& context,
                                            std::optional<std::size_t> frame = {});

/// Writes .nrrd (gzip), .nii or .nii.gz, in the smallest integer type that holds the labels. Written beside
/// the target and renamed when complete.
/// @param when_complete  Called before it is renamed; what it throws leaves the target as it was.
/// @throws Error{kBadInput} if the extension is unknown or the file cannot be written, and
///         parallel::Cancelled; nothing is left behind then.
void write_image(const std::filesystem::path& path, const LabelImage& image,
                 const std::function<void()>& when_complete = {});

}  // namespace lumesh
