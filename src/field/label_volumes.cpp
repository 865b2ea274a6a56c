#include "label_volumes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::field {

namespace {

constexpr double kMinLabelVoxels = 100;
constexpr std::size_t kMaxLabelFaces = 5000;
constexpr double kMinVoxelsPerFace = 0.6;                        // sheets of one voxel have half a voxel
constexpr double kMinAxisShare = 0.1;                            // of the faces, along an axis
constexpr double kAllowedExcess = 0.0125, kLeftExcess = 0.0075;  // of the volume
constexpr double kMaxVolumeShift = 0.15;                         // voxels, in one round
constexpr int kSamples = 2;                                      // along each edge of a voxel
constexpr double kSampleWidth = 1.0 / kSamples;

/// Samples of one voxel: for each the label and the share within the outer wall, and
/// whether the wall passes through it.
struct VoxelShares {
  static constexpr int kCount = kSamples * kSamples * kSamples;
  std::array<LabelIndex, kCount> label = {};
  std::array<float, kCount> share = {};
  std::array<bool, kCount> is_cut = {};
};

VoxelShares shares_of(const LabelField& f, const Index3& voxel) {
  VoxelShares shares;
  std::size_t n = 0;
  for_each_place(Index3::Zero(), Index3::Constant(kSamples - 1), [&](const Index3& sample) {
    const Vec3 offset = (sample.cast<double>() + Vec3::Constant(0.5)) / kSamples - Vec3::Constant(0.5);
    const Vec3 place = voxel.cast<double>() + offset;
    const LabelIndex label = f.object_label_at(place);
    const double depth = label == 0 ? -1 : f.difference_value(place, label, 0);
    shares.label[n] = label;
    shares.share[n] = static_cast<float>(std::clamp(0.5 + depth / kSampleWidth, 0.0, 1.0));
    shares.is_cut[n] = std::abs(depth) < 0.5 * kSampleWidth;
    ++n;
  });
  return shares;
}

/// The outer wall's faces of a label.
struct LabelFaces {
  std::array<std::size_t, 3> along = {};  // How many, by axis.
  IndexBox voxels{Index3::Constant(std::numeric_limits<int>::max()), Index3::Constant(-1)};
};

std::vector<LabelFaces> outer_faces(const LabelImage& image, const PairFaces& wall) {
  std::vector<LabelFaces> result(image.values().size());
  for (const Face& face : wall.faces) {
    Index3 inside = face.voxel;
    if (image.at(inside) == 0) inside[face.axis] += 1;
    LabelFaces& of = result[image.at(inside)];
    ++of.along[static_cast<std::size_t>(face.axis)];
    of.voxels = {of.voxels.low.cwiseMin(inside), of.voxels.high.cwiseMax(inside)};
  }
  return result;
}

/// A test for labels whose slices along one axis, and no other, are much alike.
bool is_along_axis(const std::array<std::size_t, 3>& faces) {
  const auto all = static_cast<double>(faces[0] + faces[1] + faces[2]);
  return std::ranges::count_if(
             faces, [&](std::size_t n) { return static_cast<double>(n) < kMinAxisShare * all; }) == 1;
}

/// Number of a label's voxels; 0 if its volume is not to be kept.
double kept_voxels(const LabelImage& image, LabelIndex label, const LabelFaces& faces) {
  const std::size_t all = faces.along[0] + faces.along[1] + faces.along[2];
  if (all == 0 || all > kMaxLabelFaces || is_along_axis(faces.along)) return 0;
  double count = 0;
  for_each_place(faces.voxels.low, faces.voxels.high,
                 [&](const Index3& voxel) { count += image.at(voxel) == label ? 1 : 0; });
  return count >= std::max(kMinLabelVoxels, kMinVoxelsPerFace * static_cast<double>(all)) ? count : 0;
}

}  // namespace

LabelVolumes::LabelVolumes(const LabelImage& image, std::span<const PairFaces> pairs)
    : image_(image), count_(image.values().size(), 0) {
  if (pairs.empty() || !pairs.front().pair.is_outer_wall() || !pairs.front().crossings.empty()) return;
  const std::vector<LabelFaces> faces = outer_faces(image, pairs.front());
  for (std::size_t l = 1; l < faces.size(); ++l)
    count_[l] = kept_voxels(image, static_cast<LabelIndex>(l), faces[l]);
  find_voxels(pairs);
}

void LabelVolumes::find_voxels(std::span<const PairFaces> pairs) {
  const Index3 size = image_.frame().size, last = size - Index3::Ones();
  std::vector<std::size_t> offsets;
  for (const PairFaces& pair : pairs)
    for (const Face& face : pair.faces) {
      const Index3 next = face.voxel + Index3::Unit(face.axis);
      if (!(count_[image_.at(face.voxel)] > 0) && !(count_[image_.at(next)] > 0)) continue;
      for_each_place((face.voxel - Index3::Ones()).cwiseMax(0), (next + Index3::Ones()).cwiseMin(last),
                     [&](const Index3& voxel) { offsets.push_back(grid_offset(size, voxel)); });
    }
  sort_unique(offsets);
  voxels_.reserve(offsets.size());
  for (const std::size_t offset : offsets) voxels_.push_back(grid_place(size, offset));
}

std::vector<float> LabelVolumes::shifts(const LabelField& f) const {
  std::vector<VoxelShares> shares(voxels_.size());
  parallel::for_each_index(voxels_.size(), 64, [&](std::size_t i) { shares[i] = shares_of(f, voxels_[i]); });
  constexpr double kSampleVolume = 1.0 / VoxelShares::kCount;
  std::vector<double> excess(count_.size(), 0), area(count_.size(), 0);
  for (std::size_t i = 0; i < voxels_.size(); ++i) {
    excess[image_.at(voxels_[i])] -= 1;
    for (std::size_t n = 0; n < VoxelShares::kCount; ++n) {
      excess[shares[i].label[n]] += kSampleVolume * static_cast<double>(shares[i].share[n]);
      if (shares[i].is_cut[n]) area[shares[i].label[n]] += kSampleVolume / kSampleWidth;
    }
  }
  std::vector<float> result(count_.size(), 0);
  for (std::size_t l = 1; l < result.size(); ++l) {
    if (!(count_[l] > 0 && area[l] > 0) || std::abs(excess[l]) <= kAllowedExcess * count_[l]) continue;
    const double too_much = excess[l] - std::copysign(kLeftExcess * count_[l], excess[l]);
    result[l] = static_cast<float>(std::clamp(-too_much / area[l], -kMaxVolumeShift, kMaxVolumeShift));
  }
  return std::ranges::all_of(result, [](float shift) { return shift == 0; }) ? std::vector<float>() : result;
}

}  // namespace lumesh::field
