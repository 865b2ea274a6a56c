#include "lumesh/io/output_checks.hpp"

#include <unistd.h>

#include <filesystem>
#include <set>
#include <system_error>

#include "file_fault.hpp"
#include "lumesh/io/link_target.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh::io {

namespace fs = std::filesystem;

namespace {

/// Place that an output goes to: links are followed.
fs::path target_of(const fs::path& path) {
  std::error_code failed;
  const fs::path target = fs::weakly_canonical(link_target(path), failed);
  if (failed) fail(path, "cannot be written: " + failed.message());
  if (fs::is_regular_file(target, failed) && fs::is_symlink(path, failed) &&
      target.extension() != path.extension())
    fail(path, "is a link to " + target.string() +
                   ", a file of another kind, which would be replaced; remove the link");
  return target;
}

/// Whether an output is an input: of a folder, all files are, as of a DICOM series.
bool is_read(const fs::path& output, const fs::path& input) {
  std::error_code ignored;  // Of files that do not exist, which is told when they are read.
  if (fs::is_regular_file(input, ignored)) return fs::equivalent(output, input, ignored);
  return fs::is_directory(input, ignored) && fs::exists(output, ignored) &&
         fs::equivalent(fs::absolute(output).parent_path(), input, ignored);
}

void check_output_folder(fs::path path) {
  check_mesh_folder(path);
  if (is_mesh_folder(path) && !path.has_filename()) path = path.parent_path();  // A slash at the end.
  path = link_target(path);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) fail(path, kNoFolder);
  const fs::file_status status = fs::status(path, ignored);
  if (fs::is_directory(status) && !is_mesh_folder(path)) fail(path, kIsFolder);
  const bool is_device = fs::exists(status) && !fs::is_regular_file(status);
  if (!is_device && ::access(folder.c_str(), W_OK | X_OK) != 0)
    fail(path, "cannot be written; its folder is read-only");
}

}  // namespace

void check_output_folders(const std::vector<std::string>& outputs, ErrorKind twice) {
  std::set<fs::path> named;
  for (const fs::path path : outputs)
    if (!named.insert(target_of(fs::absolute(path).lexically_normal())).second)
      fail(path, "is named for two outputs; give each its own file", twice);
  for (const fs::path path : outputs) check_output_folder(path);
}

void check_inputs_stay(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs,
                       ErrorKind kind) {
  for (const fs::path output : outputs)
    for (const fs::path input : inputs)
      if (!input.empty() && is_read(output, input))
        fail(output, "is read as input and would be replaced; name another output", kind);
}

}  // namespace lumesh::io
