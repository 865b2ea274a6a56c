#pragma once
/// @file Where a picture is taken from.

#include <span>

#include "lumesh/core/types.hpp"
#include "lumesh/report/picture.hpp"

namespace lumesh::report {

/// Parallel projection. Screen axes in the mesh's frame, unit vectors; `toward` points to the viewer.
struct Camera {
  Vec3 right = Vec3::UnitX();
  Vec3 up = Vec3::UnitZ();
  Vec3 toward = -Vec3::UnitY();
  Vec3 centre_mm = Vec3::Zero();
  double pixels_per_mm = 1;
  int width = 0;
  int height = 0;

  /// x right, y down in pixels, z towards the viewer in pixels.
  [[nodiscard]] std::array<float, 3> project(const Vec3& p) const {
    const Vec3 d = (p - centre_mm) * pixels_per_mm;
    return {static_cast<float>(d.dot(right) + width / 2.0), static_cast<float>(height / 2.0 - d.dot(up)),
            static_cast<float>(d.dot(toward))};
  }
  [[nodiscard]] std::array<float, 3> direction(const Vec3& v) const {
    return {static_cast<float>(v.dot(right)), static_cast<float>(v.dot(up)),
            static_cast<float>(v.dot(toward))};
  }
};

/// Viewing direction by azimuth (0: the patient's front, growing to the patient's left) and elevation; z
/// stays up.
[[nodiscard]] Camera look_from(double azimuth_deg, double elevation_deg);

/// Azimuth and elevation under which the points cover most of the screen: little hides behind something else.
struct ViewAngles {
  double azimuth_deg = 0;
  double elevation_deg = 0;
};
[[nodiscard]] ViewAngles best_view(std::span<const Vec3> points);

/// What stays empty at both sides of a picture, and above and below, in pixels.
struct Margins {
  double beside = 0;
  double above = 0;
};

/// Sets centre, scale and size so that the points fill the picture. Margins make the object smaller, not the
/// picture larger.
void frame_points(Camera& camera, std::span<const Vec3> points, int width, const Margins& margins = {});

}  // namespace lumesh::report
