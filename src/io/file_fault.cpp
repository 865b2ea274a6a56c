#include "file_fault.hpp"

#include <fmt/format.h>

#include <fstream>

namespace lumesh::io {

void fail(const std::filesystem::path& path, std::string_view what, ErrorKind kind) {
  throw Error(kind, fmt::format("{}: {}", path.string(), what));
}

void fail_at_patch(const std::filesystem::path& path, std::string_view array, std::int64_t number,
                   std::int64_t end) {
  fail(path,
       fmt::format("a boundary face has no valid patch: its number in the array \"{}\" is {}, not from 0 to "
                   "{}; number the faces anew",
                   array, number, end - 1));
}

void fail_at_line(const std::filesystem::path& path, std::size_t line, std::string_view what) {
  fail(path, fmt::format("line {}: {}; write the file again", line, what));
}

void check_file(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (!fs::exists(status)) fail(path, "no such file; check the path");
  if (fs::is_directory(status)) fail(path, kIsFolder);
  if (!fs::is_regular_file(status)) fail(path, "is not a regular file");
  if (!std::ifstream(path, std::ios::binary)) fail(path, kNoPermission);
}

}  // namespace lumesh::io
