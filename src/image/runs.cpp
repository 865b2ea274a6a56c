#include "runs.hpp"

#include <cstring>

#include "lumesh/core/error.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::image {

namespace {

constexpr std::size_t kRowsPerBlock = 64;

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
  RunImage result;
  result.size = image.frame().size;
  const auto width = static_cast<std::size_t>(result.size.x());
  const std::size_t rows =
      static_cast<std::size_t>(result.size.y()) * static_cast<std::size_t>(result.size.z());
  result.first.assign(rows + 1, 0);
  std::vector<std::vector<Run>> parts((rows + kRowsPerBlock - 1) / kRowsPerBlock);
  parallel::for_each_block(rows, kRowsPerBlock, [&](std::size_t block, std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      const std::size_t before = parts[block].size();
      append_row(image.voxels().data() + row * width, result.size.x(), labels, parts[block]);
      result.first[row + 1] = static_cast<std::uint32_t>(parts[block].size() - before);
    }
  });
  std::size_t total = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    total += result.first[row + 1];
    if (total >= std::numeric_limits<std::uint32_t>::max())
      throw Error(ErrorKind::kMemory,
                  "image has more than 4 billion runs of labels; crop it or drop its noise");
    result.first[row + 1] = static_cast<std::uint32_t>(total);
  }
  result.runs.resize(total);
  parallel::for_each_index(
      parts.size(),
      [&](std::size_t block) {
        std::copy(parts[block].begin(), parts[block].end(),
                  result.runs.begin() + static_cast<std::ptrdiff_t>(result.first[block * kRowsPerBlock]));
      },
      1);
  return result;
}

}  // namespace lumesh::image
