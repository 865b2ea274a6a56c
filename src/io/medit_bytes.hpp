#pragma once
/// @file What binary Medit files (.meshb, .solb) have in common, as libMeshb defines it: an integer 1 that
/// tells the byte order, the version, then sections: keyword, position of the next section, count, rows.
/// Versions: 1 float; 2 double; 3 and 64-bit positions; 4 and 64-bit counts, vertex numbers and references.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>

#include "output_file.hpp"

namespace lumesh::io {

inline constexpr std::int32_t kMeditDimension = 3;
inline constexpr std::int32_t kMeditEnd = 54;
/// What counts of 32 bits, which all programs read, can say.
inline constexpr std::size_t kMaxMeditRows = std::numeric_limits<std::int32_t>::max();

/// Writes version 2, or 3 for files above 2 GiB, of dimension 3. Failures throw Error{kBadInput} with the
/// file.
class MeditByteWriter {
 public:
  /// @param max_bytes  Upper bound of the file's size.
  MeditByteWriter(const std::filesystem::path& path, std::size_t max_bytes);

  /// @param bytes  Of the section behind the position: count and rows.
  void begin_section(std::int32_t keyword, std::size_t bytes);
  void put(std::int32_t value) { file_.write(&value, sizeof(value)); }
  void write(const void* data, std::size_t bytes) { file_.write(data, bytes); }
  /// Ends and renames the file.
  void commit();

 private:
  void put_position(std::size_t position);

  OutputFile file_;
  std::int32_t version_;
};

/// Reads every version and both byte orders. Damage throws Error{kBadInput} with the file.
class MeditByteReader {
 public:
  explicit MeditByteReader(const std::filesystem::path& path);

  /// The keyword of the next section, behind whose position reading goes on; kMeditEnd at the end. Sections
  /// of the dimension are checked and passed over.
  std::int32_t enter_section();
  /// Goes to the section's end, whatever of it has been read.
  void leave_section();

  /// The number of rows of a section, of which as many must be in the file as it says.
  std::size_t count(std::size_t row_bytes);
  /// 32 bits in every version: keywords, kinds of fields.
  std::int32_t small_integer() { return number<std::int32_t>(); }
  /// As wide as the version has counts and references. Names of what is read are for texts, which say lines.
  std::int64_t integer(std::string_view /*what*/ = {}) {
    return version_ == 4 ? number<std::int64_t>() : number<std::int32_t>();
  }
  double real(std::string_view /*what*/ = {}) {
    return version_ == 1 ? static_cast<double>(number<float>()) : number<double>();
  }
  [[nodiscard]] std::size_t integer_bytes() const {
    return version_ == 4 ? sizeof(std::int64_t) : sizeof(std::int32_t);
  }
  [[nodiscard]] std::size_t real_bytes() const { return version_ == 1 ? sizeof(float) : sizeof(double); }

  [[noreturn]] void fail(std::string_view what) const;
  /// A fault of what well formed bytes hold, with its own cure if there is one.
  [[noreturn]] void unsuitable(std::string_view what) const;

 private:
  template <class T>
  T number() {
    if (position_ > end_ || end_ - position_ < sizeof(T)) fail("a section or the file is cut off");
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data() + position_, sizeof(T));
    if (swapped_) std::ranges::reverse(raw);
    position_ += sizeof(T);
    return std::bit_cast<T>(raw);
  }

  std::filesystem::path path_;
  std::string bytes_;
  std::size_t position_ = 0;
  std::size_t end_;  ///< Of the section being read.
  bool swapped_ = false;
  std::int32_t version_ = 0;
};

}  // namespace lumesh::io
