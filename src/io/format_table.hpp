#pragma once
/// @file The one table of file formats: extension, readers, writers, and what each holds.

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "lumesh/core/context.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/point_data_file.hpp"

namespace lumesh {
class LabelImage;
}

namespace lumesh::io {

template <class... Uses>
constexpr unsigned bits(Uses... uses) {
  return (0U | ... | (1U << static_cast<unsigned>(uses)));
}

/// One row. Of what is not used there is no code; lines, metrics and images that are read have theirs where
/// they are read, by content or by the one format that there is.
struct FileFormat {
  using Path = std::filesystem::path;
  struct Code {
    MixedMesh (*read)(const Path& path) = nullptr;
    void (*write)(const Path& path, const MeshView& mesh, const MeshWriteOptions& options) = nullptr;
    MixedMesh (*read_by_array)(const Path& path, const std::string& patch_array,
                               const Context& context) = nullptr;  ///< Instead of read(), if there is one.
    MixedMesh (*read_points)(const Path& path) = nullptr;          ///< None: those of read().
    PointData (*read_point_data)(const Path& path) = nullptr;
    void (*write_image)(const Path& path, const LabelImage& image,
                        const std::function<void()>& when_complete) = nullptr;
  };

  std::string_view extension;  ///< In small letters.
  std::string_view name;       ///< For help and messages; empty where it goes without saying.
  unsigned uses;               ///< Bits of FileUse.
  Code code = {};
  std::string_view parts = {};  ///< What is named in it, such as solids, by any text; patches have words.

  [[nodiscard]] constexpr bool serves(FileUse use) const { return (uses & bits(use)) != 0; }
};

/// Files for solvers, and what is said where one is to be read.
[[nodiscard]] bool is_written_only(const std::filesystem::path& path);
inline constexpr std::string_view kWrittenOnly =
    "is of a format that is written for solvers and not read; give the mesh that it was made from";

/// The format of a file name. @throws Error{kBadInput} as require_format().
[[nodiscard]] const FileFormat& format_of(const std::filesystem::path& path, FileUse use);

}  // namespace lumesh::io
