#include "camera.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lumesh/core/angles.hpp"

namespace lumesh::report {

Camera look_from(double azimuth_deg, double elevation_deg) {
  const double azimuth = radians(azimuth_deg), elevation = radians(elevation_deg);
  Camera camera;
  // LPS: x to the patient's left, y to the back, z to the head. Azimuth 0 stands in front of the patient.
  camera.toward = Vec3(std::sin(azimuth) * std::cos(elevation), -std::cos(azimuth) * std::cos(elevation),
                       std::sin(elevation));
  camera.right = Vec3(std::cos(azimuth), std::sin(azimuth), 0);
  camera.up = camera.toward.cross(camera.right);
  return camera;
}

namespace {

struct Extent {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());
};

/// Bounds in screen axes.
Extent extent_on_screen(const Camera& camera, std::span<const Vec3> points) {
  Extent extent;
  for (const Vec3& p : points) {
    const Vec3 q(p.dot(camera.right), p.dot(camera.up), p.dot(camera.toward));
    extent.low = extent.low.cwiseMin(q);
    extent.high = extent.high.cwiseMax(q);
  }
  return extent;
}

/// Cells of a coarse screen grid with a point in them, in units that compare between views.
double covered_area(const Camera& camera, std::span<const Vec3> points, double cell) {
  const Extent extent = extent_on_screen(camera, points);
  const auto columns = static_cast<std::size_t>((extent.high.x() - extent.low.x()) / cell) + 1;
  const auto rows = static_cast<std::size_t>((extent.high.y() - extent.low.y()) / cell) + 1;
  std::vector<char> covered(columns * rows, 0);
  for (const Vec3& p : points) {
    const auto column = static_cast<std::size_t>((p.dot(camera.right) - extent.low.x()) / cell);
    const auto row = static_cast<std::size_t>((p.dot(camera.up) - extent.low.y()) / cell);
    covered[std::min(row, rows - 1) * columns + std::min(column, columns - 1)] = 1;
  }
  return static_cast<double>(std::ranges::count(covered, 1));
}

}  // namespace

ViewAngles best_view(std::span<const Vec3> points) {
  std::vector<Vec3> some;
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / 20000) some.push_back(points[i]);
  const Extent box = extent_on_screen(Camera(), some);
  const double cell = std::max((box.high - box.low).norm() / 60, 1e-9);
  ViewAngles best;
  double best_score = -1;
  for (const double elevation : {15.0, 40.0, 65.0})
    for (int step = 0; step < 24; ++step) {
      const double azimuth = (step % 2 == 0 ? step / 2 : -(step + 1) / 2) * 15.0;  // Near the front first.
      const double score = covered_area(look_from(azimuth, elevation), some, cell) * (1.06 - elevation / 300);
      if (score <= best_score * 1.001) continue;
      best_score = score;
      best = {azimuth, elevation};
    }
  return best;
}

void frame_points(Camera& camera, std::span<const Vec3> points, int width, const Margins& margins) {
  const Extent extent = extent_on_screen(camera, points);
  const Vec3 size = (extent.high - extent.low).cwiseMax(1e-9), middle = (extent.low + extent.high) / 2;
  camera.width = width;
  camera.height = static_cast<int>(std::clamp(size.y() / size.x(), 0.45, 1.0) * width);
  const double widest = std::min(0.92 * camera.width, camera.width - 2 * margins.beside),
               highest = std::min(0.92 * camera.height, camera.height - 2 * margins.above);
  camera.pixels_per_mm = std::min(widest / size.x(), highest / size.y());
  camera.centre_mm = middle.x() * camera.right + middle.y() * camera.up + middle.z() * camera.toward;
}

}  // namespace lumesh::report
