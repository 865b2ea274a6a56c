#pragma once
/// @file How every reader and writer says what is wrong with a file.

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "lumesh/core/error.hpp"

namespace lumesh::io {

/// Throws Error: one line, "path: what"; `what` also says what to do.
[[noreturn]] void fail(const std::filesystem::path& path, std::string_view what,
                       ErrorKind kind = ErrorKind::kBadInput);

/// Fault of the number that an array gives as the patch of a face; patches have numbers from 0 on, below
/// `end`.
[[noreturn]] void fail_at_patch(const std::filesystem::path& path, std::string_view array,
                                std::int64_t number, std::int64_t end);

/// Fault of a line of a text file.
[[noreturn]] void fail_at_line(const std::filesystem::path& path, std::size_t line, std::string_view what);

/// @name What readers and writers of several formats say.
/// @{
inline constexpr char kNoPermission[] = "cannot be opened for reading; check its permissions";
inline constexpr char kNotThere[] = "cannot be opened for reading; check the path";
inline constexpr char kIsFolder[] = "is a folder; give the name of a file";
inline constexpr char kNoFolder[] = "its folder does not exist; create it first";
inline constexpr char kFlatImage[] = "is a {}-D image; lumesh needs a 3-D one";
inline constexpr char kVolumesOfVectors[] = "has several volumes of {} values per voxel; save one of them";
inline constexpr char kTruncated[] =
    "is truncated: it holds fewer voxels than its header says; copy it again";
inline constexpr char kDamagedVoxels[] =
    "is truncated or damaged: it holds fewer voxels than its header says; copy it again";
inline constexpr char kNoMaterial[] = "label {} cannot be meshed; labels are positive";
inline constexpr char kFewCorners[] = "a polygon has fewer than three corners";
inline constexpr char kWrongCorners[] = "a cell has a wrong number of corners";
inline constexpr char kNoFaces[] = "the mesh has no boundary faces to write";
inline constexpr char kBadOffsets[] = "its cell offsets are damaged";
inline constexpr char kFewPoints[] = "does not hold as many points as it says";
inline constexpr char kFewSizes[] = "does not hold as many sizes as points";
/// @}

/// @throws Error{kBadInput} unless it is a regular file that can be opened: devices never end, and pipes may
/// never begin.
void check_file(const std::filesystem::path& path);

}  // namespace lumesh::io
