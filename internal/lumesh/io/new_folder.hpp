#pragma once
/// @file Folders that go away again if nothing stays in them.

#include <filesystem>
#include <vector>

namespace lumesh::io {

/// A folder and those above it, made if need be. At the end those that are new and empty are removed.
class NewFolder {
 public:
  /// @throws Error{kBadInput} if it cannot be made.
  explicit NewFolder(std::filesystem::path path);
  ~NewFolder();
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  std::vector<std::filesystem::path> new_;  // The innermost first.
};

}  // namespace lumesh::io
