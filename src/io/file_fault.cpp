#include "file_fault.hpp"

#include <fmt/format.h>

namespace lumesh::io {

void fail(const std::filesystem::path& path, std::string_view what, ErrorKind kind) {
  throw Error(kind, fmt::format("{}: {}", path.string(), what));
}

}  // namespace lumesh::io
