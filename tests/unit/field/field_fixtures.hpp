#pragma once
// Label images of shapes that formulas describe.

#include <cmath>

#include "lumesh/image/label_image.hpp"

namespace lumesh {

inline ImageFrame frame_of(const Index3& size, const Vec3& spacing_mm) {
  ImageFrame frame;
  frame.size = size;
  frame.spacing_mm = spacing_mm;
  return frame;
}

/// Labels by a function of the place in mm; values 0 … `labels`.
template <class LabelAt>
LabelImage image_of(const ImageFrame& frame, int labels, const LabelAt& label_at) {
  std::vector<Label> values;
  for (int l = 0; l <= labels; ++l) values.push_back(static_cast<Label>(l));
  LabelImage image(frame, values);
  for (int k = 0; k < frame.size.z(); ++k)
    for (int j = 0; j < frame.size.y(); ++j)
      for (int i = 0; i < frame.size.x(); ++i)
        image.at({i, j, k}) = static_cast<LabelImage::Index>(label_at(frame.to_physical(Vec3(i, j, k))));
  return image;
}

struct TubeAxis {
  Vec3 point, direction;
  [[nodiscard]] double distance(const Vec3& p) const {
    const Vec3 d = p - point;
    return (d - d.dot(direction) * direction).norm();
  }
};

inline TubeAxis axis_through_middle(const ImageFrame& frame, const Vec3& direction) {
  const Vec3 middle = frame.to_physical(0.5 * (frame.size - Index3::Ones()).cast<double>());
  return {middle + Vec3(0.13, -0.21, 0.37), direction.normalized()};
}

/// A tube of the radius (mm) that leaves the image through several of its faces.
inline LabelImage oblique_tube(double radius_mm, const Vec3& spacing_mm) {
  const ImageFrame frame = frame_of({34, 30, 24}, spacing_mm);
  const TubeAxis axis = axis_through_middle(frame, {1, 0.82, 0.64});
  return image_of(frame, 1, [&](const Vec3& p) { return axis.distance(p) < radius_mm ? 1 : 0; });
}

}  // namespace lumesh
