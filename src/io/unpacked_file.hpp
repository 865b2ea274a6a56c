#pragma once
/// @file Files that may be gzipped.

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace lumesh::io {

/// zlib's reader, which passes files that are not compressed through.
class GzipInput {
 public:
  /// @param offset  Where in the file it begins. @throws Error{kBadInput} if the file cannot be opened.
  explicit GzipInput(const std::filesystem::path& path, std::int64_t offset = 0);
  ~GzipInput() { ::gzclose(file_); }
  GzipInput(const GzipInput&) = delete;
  GzipInput& operator=(const GzipInput&) = delete;

  /// Bytes read, fewer than asked at the end of the file or where it is damaged.
  std::size_t read(std::byte* out, std::size_t bytes);
  /// Reads on to the end, behind which checksum and length stand. Whether both are those of what was packed;
  /// true of files that are not compressed.
  [[nodiscard]] bool rest_is_sound();

 private:
  gzFile file_;
};

/// @throws Error{kBadInput}, with the name of `path`, unless the rest of what is packed is as it was written.
void require_sound_rest(GzipInput& input, const std::filesystem::path& path);

/// The bytes of a file, unpacked if it is gzipped.
/// @throws Error{kBadInput} if it cannot be read or is damaged, Error{kMemory} if it does not fit.
[[nodiscard]] std::string unpacked_file(const std::filesystem::path& path);

}  // namespace lumesh::io
