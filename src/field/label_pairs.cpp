#include "label_pairs.hpp"

#include <algorithm>

#include "lumesh/core/wide.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::field {

namespace {

struct KeyedFace {
  std::uint32_t pair = 0;  // first << 16 | second, 0 for the outer wall
  std::uint32_t axis = 0;
  std::uint64_t voxel = 0;  // offset in the image
};

constexpr std::size_t kRun = 32;  // voxels that are compared at once

/// Whether a label changes between a row and the next ones within a run of voxels.
LUMESH_WIDE_LOOPS bool changes(const LabelIndex* row, const LabelIndex* next_y, const LabelIndex* next_z,
                               std::size_t begin, std::size_t count) {
  unsigned any = 0;
  for (std::size_t i = begin; i < begin + count; ++i)
    any |= static_cast<unsigned>((row[i] ^ next_y[i]) | (row[i] ^ next_z[i]));
  for (std::size_t i = begin; i + 1 < begin + count; ++i) any |= static_cast<unsigned>(row[i] ^ row[i + 1]);
  return any != 0;
}

class FaceScan {
 public:
  explicit FaceScan(const LabelImage& image)
      : voxels_(image.voxels().data()), size_(image.frame().size.cast<std::size_t>()) {}

  void scan_row(std::size_t row, std::vector<KeyedFace>& out) const {
    const std::size_t y = row % size_.y(), z = row / size_.y();
    const std::size_t plane = size_.x() * size_.y();
    const LabelIndex* const at = voxels_ + row * size_.x();
    const LabelIndex* const next_y = y + 1 < size_.y() ? at + size_.x() : at;
    const LabelIndex* const next_z = z + 1 < size_.z() ? at + plane : at;
    if (!changes(at, next_y, next_z, 0, size_.x())) return;  // Most rows of most images.
    for (std::size_t begin = 0; begin < size_.x(); begin += kRun) {
      const std::size_t count = std::min(kRun, size_.x() - begin);
      const bool last = begin + count == size_.x();
      if (!changes(at, next_y, next_z, begin, count) && (last || at[begin + count - 1] == at[begin + count]))
        continue;
      for (std::size_t i = begin; i < begin + count; ++i) {
        const std::size_t voxel = row * size_.x() + i;
        if (i + 1 < size_.x()) add(at[i], at[i + 1], 0, voxel, out);
        add(at[i], next_y[i], 1, voxel, out);
        add(at[i], next_z[i], 2, voxel, out);
      }
    }
  }

 private:
  static void add(LabelIndex a, LabelIndex b, std::uint32_t axis, std::size_t voxel,
                  std::vector<KeyedFace>& out) {
    if (a == b) return;
    const LabelIndex first = std::min(a, b), second = std::max(a, b);
    out.push_back({first == 0 ? 0U : static_cast<std::uint32_t>(first) << 16U | second, axis, voxel});
  }

  const LabelIndex* voxels_;
  Eigen::Matrix<std::size_t, 3, 1> size_;
};

/// Crossings of the outer wall's faces; both are in the order of voxels, then axes.
std::vector<float> crossings_of(const std::vector<Face>& faces, const LabelImage& image) {
  std::vector<float> crossings(faces.size(), 0.0F);
  auto next = image.crossings().begin();
  const auto end = image.crossings().end();
  for (std::size_t f = 0; f < faces.size() && next != end; ++f) {
    const std::pair<std::uint64_t, int> face(image.frame().offset(faces[f].voxel), faces[f].axis);
    while (next != end && std::pair<std::uint64_t, int>(next->voxel, next->axis) < face) ++next;
    if (next != end && next->voxel == face.first && next->axis == face.second) crossings[f] = next->fraction;
  }
  return crossings;
}

}  // namespace

std::vector<PairFaces> touching_pairs(const LabelImage& image) {
  const FaceScan scan(image);
  std::vector<KeyedFace> all = parallel::collect<KeyedFace>(
      grid_row_count(image.frame().size), 256,
      [&](std::size_t row, std::vector<KeyedFace>& out) { scan.scan_row(row, out); });
  const bool has_one_pair = image.values().size() <= 2;
  if (!has_one_pair) {
    parallel::sort(all.begin(), all.end(), [](const KeyedFace& a, const KeyedFace& b) {
      return std::tie(a.pair, a.voxel, a.axis) < std::tie(b.pair, b.voxel, b.axis);
    });
  }
  std::vector<PairFaces> pairs;
  std::uint32_t key = ~0U;
  for (const KeyedFace& f : all) {
    if (f.pair != key) {
      key = f.pair;
      pairs.push_back(
          {{static_cast<LabelIndex>(key >> 16U), static_cast<LabelIndex>(key & 0xFFFFU)}, {}, {}});
    }
    pairs.back().faces.push_back({image.frame().voxel_at(f.voxel), static_cast<int>(f.axis)});
  }
  if (!image.crossings().empty() && !pairs.empty() && pairs.front().pair.is_outer_wall())
    pairs.front().crossings = crossings_of(pairs.front().faces, image);
  return pairs;
}

std::vector<LabelIndex> labels_in(const LabelImage& image, const IndexBox& box) {
  std::vector<LabelIndex> labels;
  LabelIndex last = 0;
  for_each_place(box.low, box.high, [&](const Index3& voxel) {
    const LabelIndex label = image.at_nearest(voxel);
    if (!labels.empty() && label == last) return;
    last = label;
    if (std::ranges::find(labels, label) == labels.end()) labels.push_back(label);
  });
  std::ranges::sort(labels);
  return labels;
}

void copy_labels(const LabelImage& image, const Index3& first, int edge, LabelIndex* out) {
  for_each_place(first, first + Index3::Constant(edge - 1),
                 [&](const Index3& voxel) { *out++ = image.at_nearest(voxel); });
}

}  // namespace lumesh::field
