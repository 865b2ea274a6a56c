#include "lumesh/image/runs.hpp"

#include <cstring>

namespace lumesh::image {

namespace {

/// First voxel from `i` on that is not background, or `count`; eight bytes at a time.
std::int32_t skip_background(const LabelImage::Index* row, std::int32_t i, std::int32_t count) {
  for (; i + 4 <= count; i += 4) {
    std::uint64_t four = 0;
    std::memcpy(&four, row + i, sizeof four);
    if (four != 0) break;
  }
  while (i < count && row[i] == 0) ++i;
  return i;
}

/// Past the last voxel of the run that starts at `i`; eight bytes at a time.
std::int32_t skip_equal(const LabelImage::Index* row, std::int32_t i, std::int32_t count) {
  const LabelImage::Index label = row[i];
  const std::uint64_t pattern = 0x0001000100010001ULL * label;
  for (; i + 4 <= count; i += 4) {
    std::uint64_t four = 0;
    std::memcpy(&four, row + i, sizeof four);
    if (four != pattern) break;
  }
  while (i < count && row[i] == label) ++i;
  return i;
}

void append_row(const LabelImage::Index* row, std::int32_t count, RunLabels labels, std::vector<Run>& runs) {
  for (std::int32_t i = skip_background(row, 0, count); i < count; i = skip_background(row, i, count)) {
    const std::int32_t begin = i;
    const LabelImage::Index label = labels == RunLabels::kEach ? row[i] : LabelImage::Index{1};
    i = skip_equal(row, i, count);
    if (!runs.empty() && labels == RunLabels::kUnion && begin > 0 && row[begin - 1] != 0) {
      runs.back().end = i;  // another label follows on without a gap
    } else {
      runs.push_back({begin, i, label});
    }
  }
}

}  // namespace

RunImage find_runs(const LabelImage& image, RunLabels labels) {
  const Index3& size = image.frame().size;
  const auto width = static_cast<std::size_t>(size.x());
  return make_runs(size, [&](std::size_t row, std::vector<Run>& runs) {
    append_row(image.voxels().data() + row * width, size.x(), labels, runs);
  });
}

std::vector<std::size_t> voxel_starts(const RunImage& runs) {
  std::vector<std::size_t> starts = {0};
  starts.reserve(runs.runs.size() + 1);
  for (const Run& run : runs.runs)
    starts.push_back(starts.back() + static_cast<std::size_t>(run.end - run.begin));
  return starts;
}

DisjointSets connected(const RunImage& runs) {
  DisjointSets sets(runs.runs.size());
  const auto join_rows = [&](std::size_t a, std::size_t b) {
    for_each_overlap(runs.of_row(a), runs.of_row(b), [&](std::size_t x, std::size_t y, const Run&) {
      sets.merge(runs.first[a] + static_cast<std::uint32_t>(x),
                 runs.first[b] + static_cast<std::uint32_t>(y));
    });
  };
  for (int k = 0; k < runs.size.z(); ++k) {
    for (int j = 0; j < runs.size.y(); ++j) {
      if (j > 0) join_rows(runs.row(j - 1, k), runs.row(j, k));
      if (k > 0) join_rows(runs.row(j, k - 1), runs.row(j, k));
    }
  }
  return sets;
}

}  // namespace lumesh::image
