#include "tubes.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

namespace lumesh::report {

namespace {

constexpr std::size_t kSides = 10;
using Ring = std::array<Vec3, kSides>;  ///< Directions from the line's middle to the tube's side.

/// Directions across the tangent, turned as little as possible from those before.
Ring ring_across(const Vec3& tangent, Vec3& first_direction) {
  first_direction -= tangent * tangent.dot(first_direction);
  if (!(first_direction.norm() > 1e-6)) first_direction = tangent.unitOrthogonal();
  first_direction.normalize();
  const Vec3 second_direction = tangent.cross(first_direction);
  Ring ring;
  for (std::size_t i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / kSides;
    ring[i] = std::cos(angle) * first_direction + std::sin(angle) * second_direction;
  }
  return ring;
}

void add_facet(const Camera& camera, const std::array<Vec3, 3>& corners, const Vec3& normal, Colour colour,
               std::vector<ScreenTriangle>& out) {
  if (normal.dot(camera.toward) <= 0) return;
  ScreenTriangle triangle;
  for (std::size_t i = 0; i < 3; ++i) triangle.corners[i] = camera.project(corners[i]);
  triangle.normal = camera.direction(normal);
  triangle.colour = colour;
  out.push_back(triangle);
}

/// A band of facets from one ring to the next.
void add_band(const Camera& camera, const std::array<Vec3, 2>& centres, const std::array<Ring, 2>& rings,
              const std::array<double, 2>& radii_mm, Colour colour, std::vector<ScreenTriangle>& out) {
  for (std::size_t i = 0; i < kSides; ++i) {
    const std::size_t j = (i + 1) % kSides;
    const Vec3 a = centres[0] + radii_mm[0] * rings[0][i], b = centres[0] + radii_mm[0] * rings[0][j],
               c = centres[1] + radii_mm[1] * rings[1][j], d = centres[1] + radii_mm[1] * rings[1][i];
    const Vec3 normal = (rings[0][i] + rings[0][j] + rings[1][i] + rings[1][j]).normalized();
    add_facet(camera, {a, b, c}, normal, colour, out);
    add_facet(camera, {a, c, d}, normal, colour, out);
  }
}

/// A ball as bands of latitude.
void add_ball(const Camera& camera, const Vec3& centre, double radius_mm, Colour colour,
              std::vector<ScreenTriangle>& out) {
  constexpr int kBands = 8;
  Vec3 start = camera.right;
  const Ring equator = ring_across(camera.toward, start);
  for (int band = 0; band < kBands; ++band) {
    std::array<Vec3, 2> centres;
    std::array<Ring, 2> normals;
    std::array<double, 2> radii;
    for (std::size_t end = 0; end < 2; ++end) {
      // From the equator to the pole that faces the viewer; the other half is hidden.
      const double angle =
          std::numbers::pi / 2 * (band + static_cast<double>(end)) / static_cast<double>(kBands);
      centres[end] = centre + radius_mm * std::sin(angle) * camera.toward;
      radii[end] = radius_mm * std::cos(angle);
      for (std::size_t i = 0; i < kSides; ++i)
        normals[end][i] = std::cos(angle) * equator[i] + std::sin(angle) * camera.toward;
    }
    // Corners lie on the circles of latitude, normals stand on the ball.
    for (std::size_t i = 0; i < kSides; ++i) {
      const std::size_t j = (i + 1) % kSides;
      const Vec3 a = centres[0] + radii[0] * equator[i], b = centres[0] + radii[0] * equator[j],
                 c = centres[1] + radii[1] * equator[j], d = centres[1] + radii[1] * equator[i];
      const Vec3 normal = (normals[0][i] + normals[0][j] + normals[1][i] + normals[1][j]).normalized();
      add_facet(camera, {a, b, c}, normal, colour, out);
      add_facet(camera, {a, c, d}, normal, colour, out);
    }
  }
}

}  // namespace

void add_tube(const Camera& camera, std::span<const Vec3> points, std::span<const std::uint32_t> line,
              double radius_pixels, const std::function<Colour(std::uint32_t)>& colour_of,
              std::vector<ScreenTriangle>& out) {
  if (line.empty()) return;
  const double radius_mm = radius_pixels / camera.pixels_per_mm;
  Vec3 first_direction = camera.up;
  Ring before;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vec3 &last = points[line[i > 0 ? i - 1 : 0]],
               &next = points[line[std::min(i + 1, line.size() - 1)]];
    const Vec3 along = next - last;
    const Vec3 tangent = along.norm() > 0 ? Vec3(along.normalized()) : camera.right;
    const Ring ring = ring_across(tangent, first_direction);
    if (i > 0)
      add_band(camera, {points[line[i - 1]], points[line[i]]}, {before, ring}, {radius_mm, radius_mm},
               colour_of(line[i - 1]), out);
    before = ring;
  }
  add_ball(camera, points[line.front()], 1.4 * radius_mm, colour_of(line.front()), out);
  add_ball(camera, points[line.back()], 1.4 * radius_mm, colour_of(line.back()), out);
}

}  // namespace lumesh::report
