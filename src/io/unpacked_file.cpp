#include "unpacked_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <vector>

#include "file_fault.hpp"
#include "lumesh/core/memory.hpp"

namespace lumesh::io {

namespace {

/// Bytes that are unpacked at once.
constexpr std::size_t kPieceBytes = std::size_t{1} << 20;

/// Null if it cannot be opened there.
gzFile open_at(const std::filesystem::path& path, std::int64_t offset) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return nullptr;
  const gzFile packed = ::lseek(file, offset, SEEK_SET) == offset ? ::gzdopen(file, "rb") : nullptr;
  if (packed == nullptr) ::close(file);
  return packed;
}

}  // namespace

GzipInput::GzipInput(const std::filesystem::path& path, std::int64_t offset) : file_(open_at(path, offset)) {
  if (file_ == nullptr) fail(path, kNotThere);
  constexpr unsigned kBufferBytes = 1U << 18U;
  ::gzbuffer(file_, kBufferBytes);
}

std::size_t GzipInput::read(std::byte* out, std::size_t bytes) {
  std::size_t done = 0;
  while (done < bytes) {
    constexpr std::size_t kMaxAtOnce = std::size_t{1} << 30;
    const int got = ::gzread(file_, out + done, static_cast<unsigned>(std::min(kMaxAtOnce, bytes - done)));
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

bool GzipInput::rest_is_sound() {
  std::vector<std::byte> piece(kPieceBytes);
  while (read(piece.data(), piece.size()) == piece.size()) {
  }
  int code = Z_OK;
  static_cast<void>(::gzerror(file_, &code));
  return code == Z_OK || code == Z_STREAM_END;
}

void require_sound_rest(GzipInput& input, const std::filesystem::path& path) {
  if (!input.rest_is_sound())
    fail(path, "is damaged or cut off: its compressed data are not what was written; copy it again");
}

std::string unpacked_file(const std::filesystem::path& path) {
  constexpr std::size_t kLarge = std::size_t{64} << 20U;
  GzipInput input(path);
  std::string content;
  std::vector<std::byte> piece(kPieceBytes);
  for (std::size_t got = piece.size(); got == piece.size();) {
    got = input.read(piece.data(), piece.size());
    const std::size_t size = content.size() + got;
    if (size > content.capacity() && size > kLarge && 2 * size > available_memory_bytes())
      fail(path, "unpacking it needs more memory than there is", ErrorKind::kMemory);
    content.append(reinterpret_cast<const char*>(piece.data()), got);
  }
  require_sound_rest(input, path);
  return content;
}

}  // namespace lumesh::io
