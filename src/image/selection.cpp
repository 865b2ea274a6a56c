#include "lumesh/image/selection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh {

namespace {

std::string list_present(const LabelImage& image, const std::vector<std::uint64_t>& counts) {
  constexpr int kMaxListed = 40;
  std::string text;
  int listed = 0;
  for (std::size_t i = 1; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    if (++listed > kMaxListed) return text + ", …";
    text += fmt::format("{}{}", text.empty() ? "" : ", ", image.values()[i]);
  }
  return text.empty() ? "none" : text;
}

/// The whole row is read, which is quicker than to stop early.
bool is_background(const LabelImage::Index* row, int width) {
  unsigned any = 0;
  for (int i = 0; i < width; ++i) any |= row[i];
  return any == 0;
}

}  // namespace

std::vector<std::uint64_t> voxel_counts(const LabelImage& image) {
  constexpr std::size_t kVoxelsPerBlock = std::size_t{1} << 22;
  return parallel::reduce(
      image.voxels().size(), kVoxelsPerBlock, std::vector<std::uint64_t>(image.values().size(), 0),
      [&](std::vector<std::uint64_t>& counts, std::size_t v) { ++counts[image.voxels()[v]]; },
      parallel::AddEach());
}

void select_labels(LabelImage& image, std::span<const Label> labels) {
  const std::vector<std::uint64_t> counts = voxel_counts(image);
  if (labels.empty())
    throw Error(ErrorKind::kBadInput, "no label selected; the image has " + list_present(image, counts));
  std::vector<char> wanted(image.values().size(), 0);
  for (const Label label : labels) {
    const auto found = std::lower_bound(image.values().begin() + 1, image.values().end(), label);
    const auto index = static_cast<std::size_t>(found - image.values().begin());
    if (label == kBackground || found == image.values().end() || *found != label || counts[index] == 0)
      throw Error(ErrorKind::kBadInput,
                  fmt::format("image has no label {}; it has {}", label, list_present(image, counts)));
    wanted[index] = 1;
  }
  std::vector<LabelImage::Index> new_index(wanted.size(), 0);
  std::vector<Label> values = {kBackground};
  for (std::size_t i = 1; i < wanted.size(); ++i) {
    if (wanted[i] == 0) continue;
    new_index[i] = static_cast<LabelImage::Index>(values.size());
    values.push_back(image.values()[i]);
  }
  parallel::for_each_index(image.voxels().size(), 1 << 16,
                           [&](std::size_t v) { image.voxels()[v] = new_index[image.voxels()[v]]; });
  image.values() = std::move(values);
}

VoxelBox object_box(const LabelImage& image) {
  const Index3& size = image.frame().size;
  constexpr std::size_t kRowsPerBlock = 512;
  return parallel::reduce(
      grid_row_count(size), kRowsPerBlock, VoxelBox{size, Index3::Zero()},
      [&](VoxelBox& box, std::size_t row) {
        const Index3 place = grid_row(size, row);
        const LabelImage::Index* const labels = &image.voxels()[image.frame().offset(place)];
        if (is_background(labels, size.x())) return;
        int first = 0, end = size.x();
        while (labels[first] == 0) ++first;
        while (labels[end - 1] == 0) --end;
        box.add(place + first * Index3::UnitX(), place + Index3(end, 1, 1));
      },
      [](VoxelBox all, const VoxelBox& more) {
        all.add(more.low, more.high);
        return all;
      });
}

ObjectSample sample_object(const LabelImage& image, std::size_t most) {
  const ImageFrame& frame = image.frame();
  ObjectSample sample;
  sample.voxels = image.voxels().size() - voxel_counts(image)[0];
  const std::size_t stride = std::max<std::size_t>(1, sample.voxels / most);
  std::size_t seen = 0;
  for (std::size_t v = 0; v < image.voxels().size(); ++v)
    if (image.voxels()[v] != 0 && seen++ % stride == 0)
      sample.places.push_back(frame.to_physical(frame.voxel_at(v).cast<double>()));
  return sample;
}

}  // namespace lumesh
