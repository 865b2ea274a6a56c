#include "segment_grid.hpp"

#include <algorithm>
#include <bit>

#include "lumesh/parallel/loops.hpp"

namespace lumesh::field {

SegmentGrid::SegmentGrid(int x, int y, int z) : x_(x), y_(y), z_(z), words_in_row_((x + 63) / 64) {
  words_.assign(row_words() * static_cast<std::size_t>(y) * static_cast<std::size_t>(z), 0);
}

void SegmentGrid::grow_along_x() {
  const auto rows = static_cast<std::size_t>(y_) * static_cast<std::size_t>(z_);
  const unsigned rest = static_cast<unsigned>(x_) % 64U;
  parallel::for_each_index(rows, [&](std::size_t row) {
    std::uint64_t* const words = &words_[row * row_words()];
    std::uint64_t before = 0;  // the word before, as it was
    for (std::size_t w = 0; w < row_words(); ++w) {
      const std::uint64_t own = words[w];
      const std::uint64_t after = w + 1 < row_words() ? words[w + 1] : 0;
      words[w] = own | own << 1U | own >> 1U | before >> 63U | after << 63U;
      before = own;
    }
    if (rest != 0) words[row_words() - 1] &= (std::uint64_t{1} << rest) - 1;
  });
}

void SegmentGrid::grow_rows(std::size_t first, std::size_t stride, int count, int reach) {
  std::vector<std::uint64_t> old(static_cast<std::size_t>(count));
  for (std::size_t w = 0; w < row_words(); ++w) {
    std::uint64_t any = 0;
    for (int i = 0; i < count; ++i)
      any |= old[static_cast<std::size_t>(i)] = words_[first + w + stride * static_cast<std::size_t>(i)];
    if (any == 0) continue;
    for (int i = 0; i < count; ++i) {
      std::uint64_t sum = 0;
      for (int j = std::max(0, i - reach); j <= std::min(count - 1, i + reach); ++j)
        sum |= old[static_cast<std::size_t>(j)];
      words_[first + w + stride * static_cast<std::size_t>(i)] = sum;
    }
  }
}

void SegmentGrid::grow_along_y(int reach) {
  const std::size_t plane = row_words() * static_cast<std::size_t>(y_);
  parallel::for_each_index(static_cast<std::size_t>(z_), 4,
                           [&](std::size_t z) { grow_rows(z * plane, row_words(), y_, reach); });
}

void SegmentGrid::grow_along_z(int reach) {
  const std::size_t plane = row_words() * static_cast<std::size_t>(y_);
  parallel::for_each_index(static_cast<std::size_t>(y_), 4,
                           [&](std::size_t y) { grow_rows(y * row_words(), plane, z_, reach); });
}

void SegmentGrid::number() {
  first_.resize(words_.size());
  int next = 1;
  for (std::size_t w = 0; w < words_.size(); ++w) {
    first_[w] = next;
    next += count_bits(words_[w]);
  }
  places_.resize(static_cast<std::size_t>(next));
  parallel::for_each_index(words_.size(), [&](std::size_t w) {
    const std::size_t row = w / row_words();
    const auto y = static_cast<int>(row % static_cast<std::size_t>(y_));
    const auto z = static_cast<int>(row / static_cast<std::size_t>(y_));
    auto at = static_cast<std::size_t>(first_[w]);
    for (std::uint64_t bits = words_[w]; bits != 0; bits &= bits - 1)
      places_[at++] = {static_cast<int>(w % row_words()) * 64 + std::countr_zero(bits), y, z};
  });
}

void SegmentGrid::renumber(std::vector<std::int32_t> numbers, int end) {
  std::vector<SegmentPlace> places(static_cast<std::size_t>(end), {-1, -1, -1});
  for (std::size_t rank = 1; rank < places_.size(); ++rank)
    places[static_cast<std::size_t>(numbers[rank])] = places_[rank];
  places_ = std::move(places);
  numbers_ = std::move(numbers);
}

}  // namespace lumesh::field
