#include "voxel_faces.hpp"

#include <algorithm>
#include <cstring>

#include "lumesh/core/grid.hpp"
#include "lumesh/core/spread_bits.hpp"
#include "lumesh/image/selection.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::quality {

namespace {

using Voxel = LabelImage::Index;

struct OwnedFace {
  VoxelFace face;
  Voxel owner;
};

/// Appends the face between two neighbours along an axis, once for each that is not background.
void add_pair(const Index3& low_voxel, int axis, Voxel low, Voxel high, std::vector<OwnedFace>& out) {
  VoxelFace face;
  for (int d = 0; d < 3; ++d) face.twice_centre[d] = 2 * low_voxel[d];
  ++face.twice_centre[axis];
  face.axis = static_cast<std::uint8_t>(axis);
  if (low != 0) {
    face.side = 1;
    face.other = high;
    out.push_back({face, low});
  }
  if (high != 0) {
    face.side = -1;
    face.other = low;
    out.push_back({face, high});
  }
}

/// Calls visit(i) for every i where the two rows differ; equal stretches cost one memory comparison.
template <class Visit>
void for_each_difference(const Voxel* a, const Voxel* b, int count, const Visit& visit) {
  constexpr int kStretch = 64;
  for (int begin = 0; begin < count; begin += kStretch) {
    const int end = std::min(count, begin + kStretch);
    if (std::memcmp(a + begin, b + begin, sizeof(Voxel) * static_cast<std::size_t>(end - begin)) == 0)
      continue;
    for (int i = begin; i < end; ++i)
      if (a[i] != b[i]) visit(i);
  }
}

/// Faces of the row (j, k) along i, and those to the rows before it (and behind it at the border).
void scan_row(const LabelImage& image, const std::vector<Voxel>& empty_row, int j, int k,
              std::vector<OwnedFace>& out) {
  const Index3& size = image.frame().size;
  const auto row_at = [&](int y, int z) {
    const bool inside = y >= 0 && y < size.y() && z >= 0 && z < size.z();
    return inside ? image.voxels().data() + image.frame().offset({0, y, z}) : empty_row.data();
  };
  const Voxel* row = row_at(j, k);
  if (row[0] != 0) add_pair({-1, j, k}, 0, 0, row[0], out);
  for_each_difference(row, row + 1, size.x() - 1, [&](int i) {
    add_pair({i, j, k}, 0, row[i], row[i + 1], out);
  });
  if (row[size.x() - 1] != 0) add_pair({size.x() - 1, j, k}, 0, row[size.x() - 1], 0, out);
  const auto compare = [&](int axis, const Voxel* low, const Voxel* high, int y, int z) {
    for_each_difference(low, high, size.x(), [&](int i) { add_pair({i, y, z}, axis, low[i], high[i], out); });
  };
  compare(1, row_at(j - 1, k), row, j - 1, k);
  if (j + 1 == size.y()) compare(1, row, empty_row.data(), j, k);
  compare(2, row_at(j, k - 1), row, j, k - 1);
  if (k + 1 == size.z()) compare(2, row, empty_row.data(), j, k);
}

std::uint64_t morton_code(const VoxelFace& face) {
  std::uint64_t code = 0;
  for (int d = 0; d < 3; ++d)
    code |= spread_bits(static_cast<std::uint64_t>(face.twice_centre[d] + 1)) << d;  // The border is -1.
  return code;
}

}  // namespace

std::vector<LabelFaces> collect_voxel_faces(const LabelImage& image) {
  const Index3& size = image.frame().size;
  const std::vector<Voxel> empty_row(static_cast<std::size_t>(size.x()), 0);
  const std::vector<OwnedFace> all = parallel::collect<OwnedFace>(
      grid_row_count(size), 256, [&](std::size_t row, std::vector<OwnedFace>& out) {
        const Index3 place = grid_row(size, row);
        scan_row(image, empty_row, place.y(), place.z(), out);
      });
  const std::vector<std::uint64_t> voxels = voxel_counts(image);
  std::vector<std::size_t> face_counts(image.values().size(), 0);
  for (const OwnedFace& item : all) ++face_counts[item.owner];
  std::vector<LabelFaces> labels;
  for (std::size_t i = 1; i < image.values().size(); ++i) {
    labels.push_back({image.values()[i], voxels[i], {}});
    labels.back().faces.reserve(face_counts[i]);
  }
  for (const OwnedFace& item : all) labels[item.owner - 1u].faces.push_back(item.face);
  std::erase_if(labels, [](const LabelFaces& label) { return label.voxels == 0; });
  return labels;
}

std::vector<VoxelFace> boundary_voxels(std::span<const VoxelFace> faces) {
  std::vector<std::array<std::int32_t, 3>> centres(faces.size());
  parallel::for_each_index(faces.size(), [&](std::size_t i) {
    const Index3 v = faces[i].voxel();
    centres[i] = {2 * v.x(), 2 * v.y(), 2 * v.z()};
  });
  parallel::sort_unique(centres);
  std::vector<VoxelFace> points;
  points.reserve(centres.size());
  for (const auto& centre : centres) points.push_back({centre, 3, 0, 0});
  return points;
}

FaceTree::FaceTree(std::vector<VoxelFace> faces, const Vec3& spacing_mm) : half_spacing_(spacing_mm / 2) {
  struct Item {
    std::uint64_t code;
    VoxelFace face;
  };
  std::vector<Item> items(faces.size());
  parallel::for_each_index(faces.size(), [&](std::size_t i) {
    items[i] = {morton_code(faces[i]), faces[i]};
  });
  // Different faces have different codes, up to the two sides of one square; those are at the same place.
  parallel::sort(items.begin(), items.end(), [](const Item& a, const Item& b) {
    return a.code != b.code ? a.code < b.code : a.face.side < b.face.side;
  });
  faces_ = std::move(faces);
  parallel::for_each_index(faces_.size(), [&](std::size_t i) { faces_[i] = items[i].face; });
  constexpr std::size_t kLeafSize = 8;
  heap_ = BoxHeap(faces_.size(), kLeafSize);
  parallel::for_each_index(heap_.leaves(), [&](std::size_t leaf) {
    BoxHeap::Box& box = heap_.box_of_leaf(leaf);
    for (std::size_t i = heap_.first_item(leaf); i < heap_.first_item(leaf + 1); ++i) {
      const BoxHeap::Box face = box_of(faces_[i]);
      box.extend(face.low);
      box.extend(face.high);
    }
  });
  heap_.close();
}

BoxHeap::Box FaceTree::box_of(const VoxelFace& face) const {
  const Vec3 centre =
      Vec3(face.twice_centre[0], face.twice_centre[1], face.twice_centre[2]).cwiseProduct(half_spacing_);
  Vec3 half = face.axis < 3 ? half_spacing_ : Vec3(Vec3::Zero());
  if (face.axis < 3) half[face.axis] = 0;
  return {centre - half, centre + half};
}

double FaceTree::distance(const Vec3& point, double upper_bound) const {
  if (faces_.empty()) return upper_bound;
  double best = upper_bound * upper_bound;
  heap_.visit_near(point, best, [&](std::size_t leaf) {
    for (std::size_t i = heap_.first_item(leaf); i < heap_.first_item(leaf + 1); ++i)
      best = std::min(best, box_of(faces_[i]).squared_distance(point));
  });
  return std::sqrt(best);
}

}  // namespace lumesh::quality
