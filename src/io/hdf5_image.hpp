#pragma once
/// @file An HDF5 file put together in memory. HDF5's headers stay in one .cpp.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace lumesh::io {

/// A file of plain arrays with two dimensions, rows of `columns` values. It holds no times, so the same
/// arrays give the same bytes. HDF5 itself must not be entered by two threads at once: neither may this
/// class.
/// @throws Error{kMemory} if HDF5 has no room; nothing else can fail, since no file is touched.
class Hdf5Image {
 public:
  Hdf5Image();
  ~Hdf5Image();
  Hdf5Image(const Hdf5Image&) = delete;
  Hdf5Image& operator=(const Hdf5Image&) = delete;

  void add(const std::string& name, std::span<const double> values, std::size_t columns);
  void add(const std::string& name, std::span<const std::int32_t> values, std::size_t columns);
  /// The bytes of the file, once. Memory: they and the arrays again, while it runs.
  [[nodiscard]] std::vector<std::byte> finish();

 private:
  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace lumesh::io
