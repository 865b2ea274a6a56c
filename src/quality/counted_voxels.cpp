#include "counted_voxels.hpp"

#include <algorithm>

#include "lumesh/core/grid.hpp"

namespace lumesh::quality {

namespace {

using image::Run;
using image::RunImage;

/// Sorts runs and joins those that overlap or touch; labels are dropped.
void join_runs(std::vector<Run>& runs) {
  std::ranges::sort(runs, [](const Run& a, const Run& b) { return a.begin < b.begin; });
  std::size_t last = 0;
  for (std::size_t r = 1; r < runs.size(); ++r) {
    if (runs[r].begin <= runs[last].end)
      runs[last].end = std::max(runs[last].end, runs[r].end);
    else
      runs[++last] = runs[r];
  }
  if (!runs.empty()) runs.resize(last + 1);
}

/// The runs widened by the margin along i and taken from all rows within the margin along one other axis (1
/// or 2). Doing so along 1 and then along 2 makes a block around each voxel.
RunImage widened(const RunImage& image, int axis) {
  const int along_i = axis == 1 ? kCountedMargin : 0;
  return image::make_runs(image.size, [&](std::size_t row, std::vector<Run>& out) {
    const Index3 at = grid_row(image.size, row);
    std::vector<Run> runs;
    for (int step = -kCountedMargin; step <= kCountedMargin; ++step) {
      Index3 beside = at;
      beside[axis] += step;
      if (beside[axis] < 0 || beside[axis] >= image.size[axis]) continue;
      for (const Run& run : image.of_row(image.row(beside.y(), beside.z())))
        runs.push_back({std::max(0, run.begin - along_i), std::min(image.size.x(), run.end + along_i), 0});
    }
    join_runs(runs);
    out.insert(out.end(), runs.begin(), runs.end());
  });
}

/// Appends the object's runs of one row and, with label 0, what else of `near` is in [low, high).
void append_row(std::span<const Run> object, std::span<const Run> near, std::int32_t low, std::int32_t high,
                std::vector<Run>& out) {
  std::size_t next = 0;  // Run of the object.
  for (const Run& run : near) {
    std::int32_t at = run.begin;
    const auto add_background = [&](std::int32_t end) {
      const Run background = {std::max(at, low), std::min(end, high), 0};
      if (background.begin < background.end) out.push_back(background);
    };
    for (; next < object.size() && object[next].begin < run.end; ++next) {
      add_background(object[next].begin);
      out.push_back(object[next]);
      at = object[next].end;
    }
    add_background(run.end);
  }
}

}  // namespace

CountedVoxels::CountedVoxels(const LabelImage& image, const VoxelBox& box) {
  const RunImage object = image::find_runs(image, image::RunLabels::kEach);
  const RunImage near = widened(widened(object, 1), 2);
  runs_ = image::make_runs(object.size, [&](std::size_t row, std::vector<Run>& out) {
    if (near.of_row(row).empty()) return;
    const Index3 at = grid_row(object.size, row);
    const int j = at.y(), k = at.z();
    const bool in_box = j >= box.low.y() && j < box.high.y() && k >= box.low.z() && k < box.high.z();
    append_row(object.of_row(row), near.of_row(row), box.low.x(), in_box ? box.high.x() : box.low.x(), out);
  });
  numbers_ = image::voxel_starts(runs_);
}

}  // namespace lumesh::quality
