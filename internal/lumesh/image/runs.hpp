#pragma once
/// @file Runs of equal label along i, from which counts, overlaps and components follow.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/parallel/adjacency.hpp"

namespace lumesh::image {

/// Voxels [begin, end) of one row, of one label that is not background.
struct Run {
  std::int32_t begin = 0;
  std::int32_t end = 0;
  LabelImage::Index label = 0;
};

/// Runs of an image, row by row (row = j + size.y * k), ascending in each row.
struct RunImage {
  Index3 size = Index3::Zero();
  UninitialisedVector<Run> runs;
  std::vector<std::uint32_t> first;  ///< Per row, plus one at the end.

  [[nodiscard]] std::size_t row(int j, int k) const {
    return static_cast<std::size_t>(j) + static_cast<std::size_t>(size.y()) * static_cast<std::size_t>(k);
  }
  [[nodiscard]] std::span<const Run> of_row(std::size_t row) const {
    return {runs.data() + first[row], runs.data() + first[row + 1]};
  }
};

/// Calls use(run index, j, k) for every run, in order.
template <class Use>
void for_each_run(const RunImage& runs, const Use& use) {
  for (std::size_t row = 0; row + 1 < runs.first.size(); ++row) {
    const Index3 place = grid_row(runs.size, row);
    for (std::uint32_t r = runs.first[row]; r < runs.first[row + 1]; ++r) use(r, place.y(), place.z());
  }
}

/// How labels are told apart.
enum class RunLabels : std::uint8_t { kEach, kUnion };

/// The runs of an image of this size, of which append(row, runs) appends those of one row. Rows are read in
/// parallel. Memory: 12 bytes a run and 4 a row, twice that while it works.
/// @throws Error{kMemory} if there are more than 2^32 - 2 runs.
template <class AppendRow>
[[nodiscard]] RunImage make_runs(const Index3& size, const AppendRow& append) {
  constexpr std::size_t kRowsPerBlock = 64;
  parallel::Lists<Run> rows = parallel::collect_lists<Run>(grid_row_count(size), kRowsPerBlock, append);
  if (rows.items.size() >= std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorKind::kMemory,
                "image has more than 4 billion runs of labels; crop it or drop its noise");
  return {size, std::move(rows.items), std::move(rows.starts)};
}

/// @throws Error{kMemory} if there are more than 2^32 - 2 runs.
[[nodiscard]] RunImage find_runs(const LabelImage& image, RunLabels labels);

/// Number of the first voxel of every run, counted over the runs, and of all voxels at the end.
[[nodiscard]] std::vector<std::size_t> voxel_starts(const RunImage& runs);

/// Sets of runs of one label that are connected through faces of voxels.
[[nodiscard]] DisjointSets connected(const RunImage& runs);

/// Calls use(a, b, overlap) for all runs of two rows that share a label and at least one i; a and b are
/// positions in the spans, overlap is the shared part.
template <class Use>
void for_each_overlap(std::span<const Run> first, std::span<const Run> second, const Use& use) {
  std::size_t a = 0;
  std::size_t b = 0;
  while (a < first.size() && b < second.size()) {
    const Run shared = {std::max(first[a].begin, second[b].begin), std::min(first[a].end, second[b].end),
                        first[a].label};
    if (shared.begin < shared.end && first[a].label == second[b].label) use(a, b, shared);
    if (first[a].end < second[b].end) {
      ++a;
    } else {
      ++b;
    }
  }
}

}  // namespace lumesh::image
