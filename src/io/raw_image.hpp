#pragma once
/// @file Voxels as they stand in a file, before their labels are numbered.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/image/crossings.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/mesh/length_unit.hpp"

namespace lumesh::io {

/// The boundary runs where the probability of the object is this.
inline constexpr double kEvenProbability = 0.5;

enum class VoxelType : std::uint8_t {
  kUInt8,
  kInt8,
  kUInt16,
  kInt16,
  kUInt32,
  kInt32,
  kUInt64,
  kInt64,
  kFloat,
  kDouble
};

/// Names of each type in NRRD, NIfTI and MetaImage, in its order.
struct VoxelTypeNames {
  VoxelType type;
  const char* nrrd;
  int nifti;
  const char* meta;
};
inline constexpr std::array<VoxelTypeNames, 10> kVoxelTypes = {
    {{VoxelType::kUInt8, "unsigned char", 2, "MET_UCHAR"},
     {VoxelType::kInt8, "signed char", 256, "MET_CHAR"},
     {VoxelType::kUInt16, "unsigned short", 512, "MET_USHORT"},
     {VoxelType::kInt16, "short", 4, "MET_SHORT"},
     {VoxelType::kUInt32, "unsigned int", 768, "MET_UINT"},
     {VoxelType::kInt32, "int", 8, "MET_INT"},
     {VoxelType::kUInt64, "unsigned long long", 1280, "MET_ULONG_LONG"},
     {VoxelType::kInt64, "long long", 1024, "MET_LONG_LONG"},
     {VoxelType::kFloat, "float", 16, "MET_FLOAT"},
     {VoxelType::kDouble, "double", 64, "MET_DOUBLE"}}};
[[nodiscard]] constexpr const VoxelTypeNames& names_of(VoxelType type) {
  return kVoxelTypes[static_cast<std::size_t>(type)];
}

/// Choice of what is taken of an image file.
struct FileChoice {
  std::optional<std::size_t> frame = {};  ///< Of several volumes; none: all.
  std::optional<double> unit_mm = {};     ///< Of the header's lengths, whatever it says itself.

  /// Unit of the header's lengths in mm, by what it states itself; 1 where neither is known.
  [[nodiscard]] double unit_or_stated_mm(std::string_view stated) const {
    const double stated_mm = unit_in_mm(stated);
    return unit_mm.value_or(stated_mm > 0 ? stated_mm : 1);
  }
};

inline constexpr std::array<bool, 3> kAllAxes = {true, true, true};
inline constexpr std::array<bool, 3> kNoAxis = {false, false, false};

/// Contents of the header of an image file; nothing of it is checked.
struct ImageHeader {
  std::array<std::int64_t, 3> size = {0, 0, 0};
  std::size_t volumes = 1;       ///< Frames of a 4-D image, or values of each voxel.
  bool unit_is_given = false;    ///< By who asks for the image.
  std::string stated_unit = {};  ///< By the file: a word of length_units(); empty: none.
  Vec3 spacing_mm = Vec3::Ones();
  std::array<bool, 3> has_spacing = kAllAxes;  ///< Along each axis; false where the file says nothing of it.
  Vec3 origin_mm = Vec3::Zero();
  Mat3 direction = Mat3::Identity();  ///< Columns of about unit length, not yet orthonormal.
  VoxelType type = VoxelType::kUInt8;
};

struct RawImage {
  ImageFrame frame;
  VoxelType type = VoxelType::kUInt8;
  std::unique_ptr<std::byte[]> voxels;            ///< In this machine's byte order; volume after volume.
  std::map<Label, std::string> label_names = {};  ///< What the file calls its labels.
  std::size_t volumes = 1;

  [[nodiscard]] std::size_t value_count() const { return frame.voxel_count() * volumes; }
};

/// Calls `visit` with a value of the type, and returns what it returns: auto visit(auto example).
template <class Visit>
decltype(auto) visit_voxel_type(VoxelType type, Visit&& visit) {
  switch (type) {
    case VoxelType::kUInt8:
      return visit(std::uint8_t{});
    case VoxelType::kInt8:
      return visit(std::int8_t{});
    case VoxelType::kUInt16:
      return visit(std::uint16_t{});
    case VoxelType::kInt16:
      return visit(std::int16_t{});
    case VoxelType::kUInt32:
      return visit(std::uint32_t{});
    case VoxelType::kInt32:
      return visit(std::int32_t{});
    case VoxelType::kUInt64:
      return visit(std::uint64_t{});
    case VoxelType::kInt64:
      return visit(std::int64_t{});
    case VoxelType::kFloat:
      return visit(float{});
    default:
      return visit(double{});
  }
}

/// Calls `visit` with the values of all volumes in their own type: visit(std::span<const Voxel>).
template <class Visit>
decltype(auto) visit_voxels(const RawImage& image, Visit&& visit) {
  return visit_voxel_type(image.type, [&](auto example) -> decltype(auto) {
    const auto* voxels = reinterpret_cast<const decltype(example)*>(image.voxels.get());
    return visit(std::span(voxels, image.value_count()));
  });
}

[[nodiscard]] inline std::size_t voxel_bytes(VoxelType type) {
  return visit_voxel_type(type, [](auto example) { return sizeof(example); });
}

/// A frame that keeps ImageFrame's promises, or Error. Repairs directions that are slightly off, with a
/// warning; warns of images without spacing, and of those so small or large that it is not in mm.
[[nodiscard]] ImageFrame checked_frame(const std::filesystem::path& path, const ImageHeader& header,
                                       Context& context);

/// Buffer for the voxels of a checked frame; throws Error if the file is too short to hold them even if
/// packed as tightly as gzip can, or if memory is short. `file_bytes` 0 skips the first check.
[[nodiscard]] std::unique_ptr<std::byte[]> allocate_voxels(const std::filesystem::path& path,
                                                           const ImageFrame& frame, VoxelType type,
                                                           std::uintmax_t file_bytes,
                                                           std::size_t volumes = 1);

/// The product of the sizes of a header beyond the third. @throws Error{kBadInput} for more than there can
/// be.
[[nodiscard]] std::size_t product_of_sizes(const std::filesystem::path& path,
                                           std::span<const std::int64_t> sizes);

/// Consecutive volumes of a file.
struct VolumeRange {
  std::size_t first = 0, count = 1;
};
/// Volumes that are read: the frame that is asked for, or all, which only probabilities may be.
/// @throws Error{kBadInput} if there is no such frame, or one has to be asked for.
[[nodiscard]] VolumeRange chosen_volumes(const std::filesystem::path& path, const ImageHeader& header,
                                         const FileChoice& choice);
/// Message for a file with several volumes of which one is to be chosen.
[[nodiscard]] std::string several_volumes_text(std::size_t volumes);

/// Voxels with their values side by side in the file, sorted into volumes. @param kept  Of these volumes.
void sort_into_volumes(const VolumeRange& kept, RawImage& image);
/// Drops all volumes but these.
void keep_volumes(const VolumeRange& kept, RawImage& image);

/// Any format.
[[nodiscard]] RawImage read_raw(const std::filesystem::path& path, const FileChoice& choice,
                                Context& context);

/// Through ITK: NRRD, GIPL, DICOM.
[[nodiscard]] RawImage read_with_itk(const std::filesystem::path& path, const FileChoice& choice,
                                     Context& context);
[[nodiscard]] std::size_t volumes_by_itk(const std::filesystem::path& path);

/// Reads the voxels of an NRRD file in which they follow the header as one gzip stream, all in memory, three
/// times as fast as ITK. False, with any bytes in `voxels`, if the file is not such or does not hold as many:
/// ITK then reads it, or says what is wrong.
[[nodiscard]] bool unpack_nrrd(const std::filesystem::path& path, std::size_t voxel_bytes,
                               std::span<std::byte> voxels);
/// Looks at checksum and length of every gzip stream of an NRRD file, which ITK does not.
/// @throws Error{kBadInput} if one is wrong.
void require_sound_nrrd(const std::filesystem::path& path);

/// Fields of an NRRD header that ITK does not look at.
struct NrrdNotes {
  std::array<bool, 3> has_spacing = kNoAxis;  ///< ITK takes 1 where it is missing, or nan.
  std::string unit = {};  ///< By "space units" or "units", also one that is not known; empty: none.
  std::string space_without_sides = {};  ///< Such as "scanner-xyz"; empty: a space that says which is left.
  std::vector<Vec3> axes =
      {};                      ///< "Space directions", in the file's space; empty if that has no known sides.
  Vec3 to_lps = Vec3::Ones();  ///< Factors of its coordinates.
};
/// @throws Error{kBadInput} for headers that the library behind ITK reads beyond its memory: lines of more
/// than 8,000 characters, and lists of data files by a pattern.
[[nodiscard]] NrrdNotes nrrd_notes(const std::filesystem::path& path);

/// NIfTI 1 and 2 in one file, plain or gzip. Read here because ITK 5.2 refuses images whose direction cosines
/// are not orthonormal, and copies the voxels once more.
[[nodiscard]] RawImage read_nifti(const std::filesystem::path& path, const FileChoice& choice,
                                  Context& context);
[[nodiscard]] std::size_t volumes_of_nifti(const std::filesystem::path& path);
/// True if the file begins as a NIfTI file, whatever its name.
[[nodiscard]] bool is_nifti(const std::filesystem::path& path);

/// MetaImage, with its voxels in the same file or in another one.
[[nodiscard]] RawImage read_meta_image(const std::filesystem::path& path, const FileChoice& choice,
                                       Context& context);
[[nodiscard]] std::size_t volumes_of_meta_image(const std::filesystem::path& path);
/// By its name: the format has no mark of its own.
[[nodiscard]] bool is_meta_image(const std::filesystem::path& path);

/// Turns the byte order of every voxel.
void swap_bytes(RawImage& image);

/// Voxels that are not numbers: a warning with their count and a place, and 0 in their place if they are not
/// to stay.
enum class NanVoxels : std::uint8_t { kStay, kBecomeZero };
void warn_of_nan(NanVoxels what, const std::filesystem::path& path, const Context& context, RawImage& raw);

/// Finds the labels and numbers the voxels.
/// @param wanted  Of the labels; all if empty.
[[nodiscard]] LabelImage number_labels(const RawImage& raw, const std::filesystem::path& path,
                                       const std::vector<Label>& wanted);

/// Label 1 where the values are the object's.
/// @throws Error{kBadInput} with their range if none is.
[[nodiscard]] LabelImage label_values(const RawImage& raw, const ObjectValues& object,
                                      const std::filesystem::path& path);

/// The values as the image's type stores them: 0.7 is no number of single precision.
template <class Voxel>
[[nodiscard]] ObjectValues as_stored(const ObjectValues& object) {
  if constexpr (!std::is_same_v<Voxel, float>) return object;
  return {static_cast<double>(static_cast<float>(object.low)),
          static_cast<double>(static_cast<float>(object.high))};
}

/// Refuses what is neither labels nor values that explain themselves, with a threshold.
[[noreturn]] void fail_as_grey(const RawImage& raw, const std::filesystem::path& path,
                               const std::string& why);

/// @throws Error{kBadInput} if an image does not lie on the grid of another, to a hundredth of a voxel.
void require_same_grid(const ImageFrame& frame, const ImageFrame& wanted, const std::filesystem::path& path);

/// Whether the voxels are fractions from 0 to 1, to rounding. NaN may be among them.
[[nodiscard]] bool are_probabilities(const RawImage& raw);
/// Sets the crossings of an image where its own values enter the range that it was made with.
void place_by_values(const RawImage& raw, const ObjectValues& object, Interpolation interpolation,
                     LabelImage& image);
/// The same by the probabilities of another file; warns of what makes them doubtful.
/// @throws Error{kBadInput} if they are none, or of another grid.
void place_by_probabilities(const RawImage& probabilities, const std::filesystem::path& path,
                            const Context& context, LabelImage& image);

/// Whether the voxels are those of a level set, by their values alone: fractions that change sign, with
/// slopes there that are all about the same, and about one per mm or voxel.
[[nodiscard]] bool is_level_set(const RawImage& raw);
/// @throws Error{kBadInput} if no value is below 0, or none above.
void require_both_signs(const RawImage& raw, const std::filesystem::path& path);
/// The side of a level set that is the inside: the one with fewer voxels, inside of the image as well as at
/// its border. None if these disagree.
[[nodiscard]] std::optional<LevelSetSide> inside_of(const RawImage& raw);

/// Labels of several volumes of probabilities.
/// @throws Error{kBadInput} if they are none.
[[nodiscard]] LabelImage label_classes(const RawImage& raw, const std::filesystem::path& path,
                                       const std::vector<Label>& wanted, const Context& context);
/// Adds masks and probabilities of other files; says where they overlap.
/// @throws Error{kBadInput} for files of another grid.
void add_label_images(std::span<const LabelledFile> files, const ImageReadOptions& options,
                      const std::filesystem::path& path, Context& context, LabelImage& image);

}  // namespace lumesh::io
