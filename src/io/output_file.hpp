#pragma once
/// @file A file that appears under its name only when it is complete.

#include <fmt/format.h>

#include <cstddef>
#include <filesystem>
#include <iterator>
#include <string>
#include <string_view>

namespace lumesh::io {

/// Buffered writer to a temporary file beside the target; commit() renames it, the destructor removes it
/// otherwise. Devices and pipes are written directly. Every failure throws Error{kBadInput} that names the
/// target.
class OutputFile {
 public:
  explicit OutputFile(const std::filesystem::path& target);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(const void* data, std::size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }
  template <class... Args>
  void print(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(buffer_), format, std::forward<Args>(args)...);
    if (buffer_.size() >= kBufferBytes) flush();
  }
  /// Bytes written so far.
  [[nodiscard]] std::size_t position() const { return flushed_ + buffer_.size(); }
  /// Writes what is still held back, so that of several files none is renamed before all have found room.
  void flush();
  void commit();

 private:
  static constexpr std::size_t kBufferBytes = std::size_t{1} << 20;

  void write_through(const char* data, std::size_t bytes);
  [[noreturn]] void fail(std::string_view action, int error_number) const;

  std::filesystem::path target_;
  std::string temporary_;  ///< Empty when writing directly.
  int descriptor_ = -1;
  fmt::memory_buffer buffer_;
  std::size_t flushed_ = 0;
};

}  // namespace lumesh::io
