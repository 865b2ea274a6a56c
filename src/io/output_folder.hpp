#pragma once
/// @file A folder that appears under its name only when it is complete.

#include <filesystem>

namespace lumesh::io {

/// A temporary folder beside the target; commit() puts it in the place of a folder of that name, the
/// destructor removes it otherwise. Who uses it must make sure that nothing is lost by replacing the old one.
/// Every failure throws Error{kBadInput} that names the target.
class OutputFolder {
 public:
  /// @param target  Without a slash at its end.
  explicit OutputFolder(const std::filesystem::path& target);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where its files are written.
  [[nodiscard]] const std::filesystem::path& path() const { return temporary_; }
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;
};

}  // namespace lumesh::io
