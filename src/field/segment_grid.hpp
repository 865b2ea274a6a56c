#pragma once
// Which segments of eight voxels exist, of a box of rows: a bit for each, numbered row by row.

#include <cstdint>
#include <vector>

namespace lumesh::field {

/// A segment's place: `x` counts segments along the row, `y` and `z` rows.
struct SegmentPlace {
  int x = 0, y = 0, z = 0;
};

/// Number of bits set, as by std::popcount(), for which compilers call a library.
[[nodiscard]] constexpr int count_bits(std::uint64_t bits) {
  bits -= bits >> 1U & 0x5555555555555555U;
  bits = (bits & 0x3333333333333333U) + (bits >> 2U & 0x3333333333333333U);
  bits = (bits + (bits >> 4U)) & 0x0F0F0F0F0F0F0F0FU;
  return static_cast<int>(bits * 0x0101010101010101U >> 56U);
}

/// Segments have numbers from 1; 0 is the null segment, which stands for all that do not exist.
class SegmentGrid {
 public:
  SegmentGrid() = default;
  SegmentGrid(int x, int y, int z);

  [[nodiscard]] int size_x() const { return x_; }
  [[nodiscard]] int size_y() const { return y_; }
  [[nodiscard]] int size_z() const { return z_; }

  void insert(const SegmentPlace& p) {
    words_[word_of(p)] |= std::uint64_t{1} << (static_cast<unsigned>(p.x) % 64U);
  }
  [[nodiscard]] bool contains(const SegmentPlace& p) const {
    return is_inside(p) && (words_[word_of(p)] >> (static_cast<unsigned>(p.x) % 64U) & 1U) != 0;
  }
  /// Adds the segments before and after along the rows.
  void grow_along_x();
  /// Adds the same segments of up to `reach` rows to both sides.
  void grow_along_y(int reach);
  void grow_along_z(int reach);

  /// Gives numbers in row order. No insert() afterwards.
  void number();
  /// Makes room between numbers: the n-th segment in row order gets numbers[n]; `end` is one more than the
  /// last.
  void renumber(std::vector<std::int32_t> numbers, int end);
  /// One more than the last number; 1 if there is none.
  [[nodiscard]] int end() const { return static_cast<int>(places_.size()); }
  /// 0 if there is no such segment.
  [[nodiscard]] int find(const SegmentPlace& p) const {
    if (!is_inside(p)) return 0;
    const std::size_t w = word_of(p);
    const unsigned bit = static_cast<unsigned>(p.x) % 64U;
    if ((words_[w] >> bit & 1U) == 0) return 0;
    const int rank = first_[w] + count_bits(words_[w] & ((std::uint64_t{1} << bit) - 1));
    return numbers_.empty() ? rank : numbers_[static_cast<std::size_t>(rank)];
  }
  [[nodiscard]] const SegmentPlace& place(int segment) const {
    return places_[static_cast<std::size_t>(segment)];
  }
  /// False for the null segment and numbers that renumber() left out.
  [[nodiscard]] bool exists(int segment) const { return places_[static_cast<std::size_t>(segment)].x >= 0; }

 private:
  [[nodiscard]] bool is_inside(const SegmentPlace& p) const {
    return static_cast<unsigned>(p.x) < static_cast<unsigned>(x_) &&
           static_cast<unsigned>(p.y) < static_cast<unsigned>(y_) &&
           static_cast<unsigned>(p.z) < static_cast<unsigned>(z_);
  }
  [[nodiscard]] std::size_t row_words() const { return static_cast<std::size_t>(words_in_row_); }
  [[nodiscard]] std::size_t word_of(const SegmentPlace& p) const {
    return (static_cast<std::size_t>(p.y) + static_cast<std::size_t>(y_) * static_cast<std::size_t>(p.z)) *
               row_words() +
           static_cast<std::size_t>(p.x) / 64;
  }
  /// ORs each of `count` groups of words, `stride` words apart, into those up to `reach` groups away.
  void grow_rows(std::size_t first, std::size_t stride, int count, int reach);

  int x_ = 0, y_ = 0, z_ = 0, words_in_row_ = 0;
  std::vector<std::uint64_t> words_;   // a bit for each segment
  std::vector<std::int32_t> first_;    // rank of each word's first segment
  std::vector<std::int32_t> numbers_;  // by rank; empty: the rank itself
  std::vector<SegmentPlace> places_ = std::vector<SegmentPlace>(1, SegmentPlace{-1, -1, -1});
};

}  // namespace lumesh::field
