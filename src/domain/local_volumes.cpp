#include "lumesh/domain/local_volumes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/field/label_field.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

constexpr int kStep = 4;  // Voxels along the edge of a block; a cube has two blocks along each axis.

/// Contents of a block of voxels, in voxels; by addition, those of a cube.
struct Block {
  double object = 0, more = 0;
  Vec3 faces = Vec3::Zero();   // By axes that they are square to.
  Vec3 places = Vec3::Zero();  // Sum over the object's voxels, as indices.

  void add(const Block& other) {
    object += other.object, more += other.more;
    faces += other.faces, places += other.places;
  }
};

class VolumeComparison {
 public:
  VolumeComparison(const LabelImage& image, const ImageDomain& domain)
      : image_(image),
        domain_(domain),
        frame_(image.frame()),
        edges_(frame_.spacing_mm / frame_.spacing_mm.minCoeff()),
        blocks_((frame_.size.array() + kStep - 1) / kStep) {}

  std::vector<LocalVolume> find() {
    fill();
    std::vector<LocalVolume> found;
    const Index3 cubes = blocks_.array().max(2) - 1;
    for (int k = 0; k < cubes.z(); ++k)
      for (int j = 0; j < cubes.y(); ++j)
        for (int i = 0; i < cubes.x(); ++i) add_if_changed({i, j, k}, found);
    std::ranges::stable_sort(found, [](const LocalVolume& a, const LocalVolume& b) {
      return std::abs(a.change()) > std::abs(b.change());
    });
    return without_overlaps(found);
  }

 private:
  void fill() {
    all_.resize(static_cast<std::size_t>(blocks_.prod()));
    parallel::for_each_index(all_.size(), 16,
                             [&](std::size_t at) { all_[at] = block_at(grid_place(blocks_, at)); });
  }

  [[nodiscard]] Block block_at(const Index3& block) const {
    const Index3 low = kStep * block, end = (low + Index3::Constant(kStep)).cwiseMin(frame_.size);
    Block result;
    const bool is_near = domain_.field().near_boundary(field_index(low), field_index(end - Index3::Ones()));
    if (!is_near && image_.at(low) == 0) return result;
    for (int k = low.z(); k < end.z(); ++k)
      for (int j = low.y(); j < end.y(); ++j)
        for (int i = low.x(); i < end.x(); ++i) add_voxel({i, j, k}, is_near, result);
    return result;
  }

  void add_voxel(const Index3& v, bool is_near, Block& block) const {
    if (is_cut_off(v)) return;
    const bool inside = image_.at(v) != 0;
    if (inside) {
      block.object += 1;
      block.places += v.cast<double>();
    }
    if (!is_near) return;
    Vec3 faces = Vec3::Zero();
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1}) {
        const Index3 next = v + side * Index3::Unit(axis);
        faces[axis] += static_cast<int>(frame_.contains(next) && (image_.at(next) != 0) != inside);
      }
    if (faces.sum() == 0) return;
    block.faces += 0.5 * faces;  // Each has two voxels.
    block.more += share_of(v) - static_cast<double>(inside);
  }

  /// How much of a voxel lies within the boundary, taken for a plane.
  [[nodiscard]] double share_of(const Index3& v) const {
    const FieldSample at = domain_.field().difference(field_index(v), 1, 0);
    const double slope = at.gradient.cwiseQuotient(edges_).norm();
    if (!(slope > 0)) return at.value > 0 ? 1 : 0;
    const double width = at.gradient.cwiseAbs().sum() / slope;  // Of the voxel across the boundary.
    return std::clamp(0.5 + at.value / slope / width, 0.0, 1.0);
  }

  [[nodiscard]] bool is_cut_off(const Index3& v) const {
    return !domain_.cut_planes().empty() && domain_.beyond_cut(frame_.to_physical(v.cast<double>()));
  }
  [[nodiscard]] Vec3 field_index(const Index3& v) const {
    return domain_.field().frame().to_index(frame_.to_physical(v.cast<double>()));
  }

  void add_if_changed(const Index3& first, std::vector<LocalVolume>& found) const {
    constexpr double kMinChange = 0.15, kDeviations = 3;
    Block cube;
    for (int c = 0; c < 8; ++c) {
      const Index3 block = first + Index3(c & 1, c >> 1 & 1, c >> 2 & 1);
      if ((block.array() < blocks_.array()).all()) cube.add(all_[grid_offset(blocks_, block)]);
    }
    if (!(cube.object > 0) || std::abs(cube.more) < kMinChange * cube.object ||
        std::abs(cube.more) < kDeviations * deviation(cube.faces))
      return;
    // A wall's sliver in a corner of the cube says nothing: where it runs along the voxels, all faces are off
    // alike.
    constexpr double kOffCentre = kStep / 2.0;
    const Vec3 centre = (kStep * (first + Index3::Ones())).cast<double>() - Vec3::Constant(0.5);
    if (((cube.places / cube.object - centre).array().abs() > kOffCentre).any()) return;
    const double voxel_mm3 = frame_.voxel_volume_mm3();
    found.push_back({frame_.to_physical(cube.places / cube.object), cube.object * voxel_mm3,
                     (cube.object + cube.more) * voxel_mm3});
  }

  /// The standard deviation of a sum over faces, of which each is off by up to half a voxel, evenly. Sections
  /// of a vessel along an axis are alike, and off alike; steps, which are square to that axis, tell of
  /// others.
  [[nodiscard]] static double deviation(const Vec3& faces) {
    constexpr double kOfFace = 1.0 / 12, kStepsOfSection = 4, kSections = 2 * kStep;
    const double unlike = std::min(1 + faces.minCoeff() / kStepsOfSection, kSections);
    return std::sqrt(kOfFace * faces.sum() * kSections / unlike);
  }

  [[nodiscard]] std::vector<LocalVolume> without_overlaps(const std::vector<LocalVolume>& all) const {
    const double reach_mm = 2 * kStep * frame_.spacing_mm.maxCoeff();
    std::vector<LocalVolume> kept;
    for (const LocalVolume& volume : all)
      if (std::ranges::none_of(kept, [&](const LocalVolume& other) {
            return (other.place_mm - volume.place_mm).norm() < reach_mm;
          }))
        kept.push_back(volume);
    return kept;
  }

  const LabelImage& image_;
  const ImageDomain& domain_;
  const ImageFrame& frame_;
  Vec3 edges_;  // Of a voxel, in units of the smallest.
  Index3 blocks_;
  std::vector<Block> all_;
};

}  // namespace

std::vector<LocalVolume> find_changed_volumes(const LabelImage& image, const ImageDomain& domain) {
  if (!image.crossings().empty()) return {};
  return VolumeComparison(image, domain).find();
}

std::string doubt_about_volumes(const LabelImage& image, const ImageDomain& domain) {
  const std::vector<LocalVolume> changed = find_changed_volumes(image, domain);
  if (changed.empty()) return "";
  const LocalVolume& most = changed.front();
  return fmt::format(
      "the volume within the boundary is off that of the voxels by 15 % or more in {}, most at {}: {:.3g} of "
      "{:.3g} "
      "mm3, {:+.0f} %, such as in short throats, at thin ends and where voxels are noisy; a finer image, or "
      "its grey "
      "values with `threshold`, place it better",
      counted(changed.size(), "place"), place_text(most.place_mm), most.smooth_mm3, most.voxels_mm3,
      100 * most.change());
}

}  // namespace lumesh
