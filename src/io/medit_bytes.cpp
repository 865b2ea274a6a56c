#include "medit_bytes.hpp"

#include <fmt/format.h>

#include <bit>

#include "file_fault.hpp"
#include "text_scanner.hpp"

namespace lumesh::io {

static_assert(std::endian::native == std::endian::little, "files are written in the machine's byte order");

MeditByteWriter::MeditByteWriter(const std::filesystem::path& path, std::size_t max_bytes)
    : file_(path), version_(max_bytes > std::numeric_limits<std::int32_t>::max() ? 3 : 2) {
  put(std::int32_t{1});
  put(version_);
  begin_section(kMeditDimension, sizeof(std::int32_t));
  put(std::int32_t{3});
}

void MeditByteWriter::begin_section(std::int32_t keyword, std::size_t bytes) {
  const std::size_t header =
      sizeof(std::int32_t) + (version_ == 2 ? sizeof(std::int32_t) : sizeof(std::int64_t));
  const std::size_t next = file_.position() + header + bytes;
  put(keyword);
  put_position(next);
}

void MeditByteWriter::commit() {
  put(kMeditEnd);
  put_position(0);
  file_.commit();
}

void MeditByteWriter::put_position(std::size_t position) {
  if (version_ == 2) return put(static_cast<std::int32_t>(position));
  const auto wide = static_cast<std::int64_t>(position);
  file_.write(&wide, sizeof(wide));
}

MeditByteReader::MeditByteReader(const std::filesystem::path& path)
    : path_(path), bytes_(read_whole_file(path)), end_(bytes_.size()) {
  const std::int32_t order = small_integer();
  swapped_ = order == 1 << 24;
  if (order != 1 && !swapped_) fail("this is no binary Medit file");
  version_ = small_integer();
  if (version_ < 1 || version_ > 4) fail(fmt::format("unknown version {} of the format", version_));
}

std::int32_t MeditByteReader::enter_section() {
  while (true) {
    const std::int32_t keyword = small_integer();
    if (keyword == kMeditEnd) return keyword;
    const std::int64_t next = version_ >= 3 ? number<std::int64_t>() : small_integer();
    if (next < static_cast<std::int64_t>(position_) || next > static_cast<std::int64_t>(bytes_.size()))
      fail(fmt::format("section {} ends outside of the file, which is damaged or cut off", keyword));
    end_ = static_cast<std::size_t>(next);
    if (keyword != kMeditDimension) return keyword;
    if (const std::int32_t dimension = small_integer(); dimension != 3)
      unsuitable(fmt::format("has dimension {}; only files of dimension 3 can be read", dimension));
    leave_section();
  }
}

void MeditByteReader::leave_section() {
  position_ = end_;
  end_ = bytes_.size();
}

std::size_t MeditByteReader::count(std::size_t row_bytes) {
  const std::int64_t rows = integer();
  const std::size_t most = (end_ - position_) / row_bytes;
  if (rows < 0 || static_cast<std::uint64_t>(rows) > most)
    fail(fmt::format("a section says it has {} rows, more than the file holds", rows));
  return static_cast<std::size_t>(rows);
}

void MeditByteReader::fail(std::string_view what) const {
  unsuitable(fmt::format("{}; write the file again", what));
}

void MeditByteReader::unsuitable(std::string_view what) const {
  io::fail(path_, std::string(what));
}

}  // namespace lumesh::io
