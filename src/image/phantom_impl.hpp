#pragma once
/// @file What a Phantom holds.

#include <optional>

#include "lumesh/image/phantom.hpp"
#include "phantom_kinds.hpp"

namespace lumesh {

struct Phantom::Impl {
  PhantomSpec spec;
  ImageFrame frame;
  image::PhantomGeometry geometry;
  std::optional<image::WaveNoise> noise;
  double noise_mm = 0;
  double lipschitz = 1;  ///< Of signed_distance().
  Vec3 box_low;          ///< Outer faces of the border voxels.
  Vec3 box_high;

  [[nodiscard]] Vec3 to_local(const Vec3& point_mm) const {
    return frame.direction.transpose() * (point_mm - frame.origin_mm);
  }
  [[nodiscard]] Vec3 to_physical(const Vec3& local) const {
    return frame.origin_mm + frame.direction * local;
  }
  [[nodiscard]] const image::Material& material(Label label) const;
  [[nodiscard]] double signed_distance(const Vec3& local, const image::Material& material) const;
  struct Sample {
    Label label = kBackground;
    double clearance = 0;  ///< Distance to the nearest surface of any label, times at most `lipschitz`.
  };
  [[nodiscard]] Sample sample(const Vec3& local) const;
  /// Signed distance to the outer faces of the image, negative inside.
  [[nodiscard]] double box_distance(const Vec3& local) const {
    const Vec3 beyond = (box_low - local).cwiseMax(local - box_high);
    return beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0);
  }
};

}  // namespace lumesh
