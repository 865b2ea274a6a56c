#pragma once
// Loops over the segments of a band or grid, in blocks of fixed size.

#include <cstddef>
#include <functional>

#include "lumesh/parallel/loops.hpp"

namespace lumesh::field {

inline constexpr std::size_t kSegmentBlock = 512;
/// Below so many segments waking other threads takes longer than the work.
inline constexpr int kSegmentsForOneThread = 3000;

/// Calls body(begin, end) for all segments but the null one; `end` is one more than the last.
template <class Body>
void for_each_segment_block(int end, const Body& body) {
  if (end <= kSegmentsForOneThread) {
    if (end > 1) body(1, end);
    return;
  }
  parallel::for_each_block(static_cast<std::size_t>(end - 1), kSegmentBlock,
                           [&](std::size_t, std::size_t first, std::size_t last) {
                             body(static_cast<int>(first) + 1, static_cast<int>(last) + 1);
                           });
}

/// The sum of body(begin, end), in a fixed order.
template <class Body>
[[nodiscard]] double sum_over_segment_blocks(int end, const Body& body) {
  if (end <= kSegmentsForOneThread) return end > 1 ? body(1, end) : 0.0;
  return parallel::reduce_blocks(
      static_cast<std::size_t>(end - 1), kSegmentBlock, 0.0,
      [&](std::size_t first, std::size_t last) {
        return body(static_cast<int>(first) + 1, static_cast<int>(last) + 1);
      },
      std::plus<>());
}

}  // namespace lumesh::field
