#pragma once
/// @file Voxels as they stand in a file, before their labels are numbered.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>

#include "lumesh/core/context.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/io/image_file.hpp"

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

/// What the header of an image file says; nothing of it is checked.
struct ImageHeader {
  std::array<std::int64_t, 3> size = {0, 0, 0};
  Vec3 spacing_mm = Vec3::Ones();
  bool has_spacing = true;  ///< False where the file says nothing of it.
  Vec3 origin_mm = Vec3::Zero();
  Mat3 direction = Mat3::Identity();  ///< Columns of about unit length, not yet orthonormal.
  VoxelType type = VoxelType::kUInt8;
};

struct RawImage {
  ImageFrame frame;
  VoxelType type = VoxelType::kUInt8;
  std::unique_ptr<std::byte[]> voxels;            ///< In this machine's byte order.
  std::map<Label, std::string> label_names = {};  ///< What the file calls its labels.
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

/// Calls `visit` with the voxels in their own type: visit(std::span<const Voxel>).
template <class Visit>
decltype(auto) visit_voxels(const RawImage& image, Visit&& visit) {
  return visit_voxel_type(image.type, [&](auto example) -> decltype(auto) {
    const auto* voxels = reinterpret_cast<const decltype(example)*>(image.voxels.get());
    return visit(std::span(voxels, image.frame.voxel_count()));
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
                                                           std::uintmax_t file_bytes);

/// Through ITK: NRRD, GIPL, DICOM.
[[nodiscard]] RawImage read_with_itk(const std::filesystem::path& path, Context& context);

/// Reads the voxels of an NRRD file in which they follow the header as one gzip stream, all in memory, three
/// times as fast as ITK. False, with any bytes in `voxels`, if the file is not such or does not hold as many:
/// ITK then reads it, or says what is wrong.
[[nodiscard]] bool unpack_nrrd(const std::filesystem::path& path, std::size_t voxel_bytes,
                               std::span<std::byte> voxels);

/// What the header of an NRRD file says that ITK does not look at.
struct NrrdNotes {
  bool has_spacing = false;  ///< ITK takes 1 mm where it is missing.
  double unit_mm = 1;        ///< By "space units".
};
/// @throws Error{kBadInput} for headers that the library behind ITK reads beyond its memory: lines of more
/// than 8,000 characters, and lists of data files by a pattern.
[[nodiscard]] NrrdNotes nrrd_notes(const std::filesystem::path& path);

/// NIfTI 1 and 2 in one file, plain or gzip. Read here because ITK 5.2 refuses images whose direction cosines
/// are not orthonormal, and copies the voxels once more.
[[nodiscard]] RawImage read_nifti(const std::filesystem::path& path, Context& context);
/// True if the file begins as a NIfTI file, whatever its name.
[[nodiscard]] bool is_nifti(const std::filesystem::path& path);

/// MetaImage, with its voxels in the same file or in another one.
[[nodiscard]] RawImage read_meta_image(const std::filesystem::path& path, Context& context);
/// By its name: the format has no mark of its own.
[[nodiscard]] bool is_meta_image(const std::filesystem::path& path);

/// Turns the byte order of every voxel.
void swap_bytes(RawImage& image);

/// Finds the labels, applies the options but for the file of probabilities, and numbers the voxels.
[[nodiscard]] LabelImage number_labels(const RawImage& raw, const std::filesystem::path& path,
                                       const ImageReadOptions& options);

/// Whether the voxels are fractions from 0 to 1, to rounding. NaN may be among them.
[[nodiscard]] bool are_probabilities(const RawImage& raw);
/// Sets the crossings of an image where its own values reach the threshold that it was made with.
void place_by_threshold(const RawImage& raw, double threshold, LabelImage& image);
/// The same by the probabilities of another file; warns of what makes them doubtful.
/// @throws Error{kBadInput} if they are none, or of another grid.
void place_by_probabilities(const RawImage& probabilities, const std::filesystem::path& path,
                            const Context& context, LabelImage& image);

}  // namespace lumesh::io
