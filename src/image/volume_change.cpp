// What smoothing does to the volume, from the voxels next to boundaries.
#include <algorithm>

#include "lumesh/image/label_field.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

constexpr int kCube = LabelField::kBrick;

/// Voxels of the object, before and after.
struct Volumes {
  double before = 0, after = 0;
};

class VolumeCount {
 public:
  VolumeCount(const LabelField& field, const LabelImage& image) : field_(field), image_(image) {}

  [[nodiscard]] Volumes of_brick(const Index3& low) const {
    const Index3 high = (low + Index3::Constant(kCube)).cwiseMin(image_.frame().size);
    const Vec3 middle = 0.5 * (low + high - Index3::Ones()).cast<double>();
    Volumes volumes;
    if (!field_.near_boundary(middle)) {
      if (field_.label_at(middle) != 0) volumes.before = volumes.after = (high - low).prod();
      return volumes;
    }
    for (int k = low.z(); k < high.z(); ++k)
      for (int j = low.y(); j < high.y(); ++j)
        for (int i = low.x(); i < high.x(); ++i) {
          const Index3 voxel(i, j, k);
          const double whole = is_object(voxel) ? 1 : 0;
          volumes.before += whole;
          volumes.after += is_at_border(voxel) ? share_of_object(voxel.cast<double>()) : whole;
        }
    return volumes;
  }

 private:
  [[nodiscard]] bool is_object(const Index3& voxel) const { return image_.at(voxel) != 0; }
  /// Whether one of six neighbours is object and the voxel not, or the other way round.
  [[nodiscard]] bool is_at_border(const Index3& voxel) const {
    const bool own = is_object(voxel);
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1}) {
        Index3 next = voxel;
        next[axis] = std::clamp(next[axis] + side, 0, image_.frame().size[axis] - 1);
        if (is_object(next) != own) return true;
      }
    return false;
  }
  /// Of a voxel that a smooth boundary passes through at some distance from its centre.
  [[nodiscard]] double share_of_object(const Vec3& index) const {
    double object = -LabelField::kFieldLimit;
    for (const LabelField::LabelIndex label : field_.labels_near(index))
      if (label != 0) object = std::max(object, field_.value(index, label));
    const double depth = 0.5 * (object - field_.value(index, 0));
    return std::clamp(0.5 + depth, 0.0, 1.0);
  }

  const LabelField& field_;
  const LabelImage& image_;
};

}  // namespace

double volume_change(const LabelField& field, const LabelImage& image) {
  const Index3 bricks = (image.frame().size + Index3::Constant(kCube - 1)) / kCube;
  const VolumeCount count(field, image);
  const Volumes all = parallel::reduce_blocks(
      static_cast<std::size_t>(bricks.y()) * static_cast<std::size_t>(bricks.z()), 4, Volumes{},
      [&](std::size_t begin, std::size_t end) {
        Volumes sum;
        for (std::size_t row = begin; row < end; ++row)
          for (int i = 0; i < bricks.x(); ++i) {
            const auto j = static_cast<int>(row % static_cast<std::size_t>(bricks.y())),
                       k = static_cast<int>(row / static_cast<std::size_t>(bricks.y()));
            const Volumes here = count.of_brick(kCube * Index3(i, j, k));
            sum.before += here.before;
            sum.after += here.after;
          }
        return sum;
      },
      [](const Volumes& a, const Volumes& b) {
        return Volumes{a.before + b.before, a.after + b.after};
      });
  return all.before > 0 ? all.after / all.before - 1 : 0;
}

}  // namespace lumesh
