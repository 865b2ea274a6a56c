#include "lumesh/image/selection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

namespace {

constexpr std::size_t kVoxelsPerBlock = std::size_t{1} << 22;

/// Per compact label: 1 if a voxel has it.
std::vector<char> find_present(const LabelImage& image) {
  using Flags = std::vector<char>;
  const auto mark = [&](std::size_t begin, std::size_t end) {
    Flags present(image.values().size(), 0);
    for (std::size_t v = begin; v < end; ++v) present[image.voxels()[v]] = 1;
    return present;
  };
  return parallel::reduce_blocks(image.voxels().size(), kVoxelsPerBlock, Flags(image.values().size(), 0),
                                 mark, [](Flags a, const Flags& b) {
                                   for (std::size_t i = 0; i < a.size(); ++i) a[i] |= b[i];
                                   return a;
                                 });
}

std::string list_present(const LabelImage& image, const std::vector<char>& present) {
  constexpr int kMaxListed = 40;
  std::string text;
  int listed = 0;
  for (std::size_t i = 1; i < present.size(); ++i) {
    if (present[i] == 0) continue;
    if (++listed > kMaxListed) return text + ", …";
    text += fmt::format("{}{}", text.empty() ? "" : ", ", image.values()[i]);
  }
  return text.empty() ? "none" : text;
}

}  // namespace

void select_labels(LabelImage& image, std::span<const Label> labels) {
  const std::vector<char> present = find_present(image);
  if (labels.empty())
    throw Error(ErrorKind::kBadInput, "no label selected; the image has " + list_present(image, present));
  std::vector<char> wanted(image.values().size(), 0);
  for (const Label label : labels) {
    const auto found = std::lower_bound(image.values().begin() + 1, image.values().end(), label);
    const auto index = static_cast<std::size_t>(found - image.values().begin());
    if (label == kBackground || found == image.values().end() || *found != label || present[index] == 0)
      throw Error(ErrorKind::kBadInput,
                  fmt::format("image has no label {}; it has {}", label, list_present(image, present)));
    wanted[index] = 1;
  }
  std::vector<LabelImage::Index> new_index(wanted.size(), 0);
  std::vector<Label> values = {kBackground};
  for (std::size_t i = 1; i < wanted.size(); ++i) {
    if (wanted[i] == 0) continue;
    new_index[i] = static_cast<LabelImage::Index>(values.size());
    values.push_back(image.values()[i]);
  }
  parallel::for_each_index(
      image.voxels().size(), [&](std::size_t v) { image.voxels()[v] = new_index[image.voxels()[v]]; },
      1 << 16);
  image.values() = std::move(values);
}

ObjectSample sample_object(const LabelImage& image, std::size_t most) {
  const ImageFrame& frame = image.frame();
  ObjectSample sample;
  sample.voxels = static_cast<std::size_t>(std::count_if(image.voxels().begin(), image.voxels().end(),
                                                         [](LabelImage::Index label) { return label != 0; }));
  const std::size_t stride = std::max<std::size_t>(1, sample.voxels / most);
  std::size_t seen = 0;
  for (int k = 0; k < frame.size.z(); ++k)
    for (int j = 0; j < frame.size.y(); ++j)
      for (int i = 0; i < frame.size.x(); ++i)
        if (const Index3 voxel(i, j, k); image.at(voxel) != 0 && seen++ % stride == 0)
          sample.places.push_back(frame.to_physical(voxel.cast<double>()));
  return sample;
}

}  // namespace lumesh
