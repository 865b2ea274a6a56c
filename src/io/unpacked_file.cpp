#include "unpacked_file.hpp"

#include <zlib.h>

#include <vector>

#include "file_fault.hpp"
#include "lumesh/core/memory.hpp"

namespace lumesh::io {

std::string unpacked_file(const std::filesystem::path& path) {
  constexpr std::size_t kLarge = std::size_t{64} << 20U;
  gzFile file = gzopen(path.c_str(), "rb");  // reads plain files too
  if (file == nullptr) fail(path, "cannot be opened for reading; check the path");
  std::string content;
  std::vector<char> buffer(1U << 20);
  int got = 0;
  bool is_too_large = false;
  while (!is_too_large && (got = gzread(file, buffer.data(), static_cast<unsigned>(buffer.size()))) > 0) {
    const std::size_t size = content.size() + static_cast<std::size_t>(got);
    if (size > content.capacity() && size > kLarge) is_too_large = 2 * size > available_memory_bytes();
    if (!is_too_large) content.append(buffer.data(), static_cast<std::size_t>(got));
  }
  gzclose(file);
  if (is_too_large) fail(path, "unpacking it needs more memory than there is", ErrorKind::kMemory);
  if (got < 0) fail(path, "its compressed data are cut off or damaged");
  return content;
}

}  // namespace lumesh::io
