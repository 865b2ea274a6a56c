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

/// A ring of corners, and the normals of the surface there.
struct BandEnd {
  Vec3 centre;
  double radius_mm;
  Ring directions, normals;
};

/// A band of facets from one ring to the next.
void add_band(const Camera& camera, const BandEnd& from, const BandEnd& to, Colour colour,
              std::vector<ScreenTriangle>& out) {
  const auto corner = [](const BandEnd& end, std::size_t i) {
    return Vec3(end.centre + end.radius_mm * end.directions[i]);
  };
  for (std::size_t i = 0; i < kSides; ++i) {
    const std::size_t j = (i + 1) % kSides;
    const Vec3 a = corner(from, i), b = corner(from, j), c = corner(to, j), d = corner(to, i);
    const Vec3 normal = (from.normals[i] + from.normals[j] + to.normals[i] + to.normals[j]).normalized();
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
  // Corners lie on the circles of latitude, normals stand on the ball.
  const auto latitude = [&](int band) {
    const double angle = std::numbers::pi / 2 * band / static_cast<double>(kBands);
    BandEnd end{
        centre + radius_mm * std::sin(angle) * camera.toward, radius_mm * std::cos(angle), equator, {}};
    for (std::size_t i = 0; i < kSides; ++i)
      end.normals[i] = std::cos(angle) * equator[i] + std::sin(angle) * camera.toward;
    return end;
  };
  // From the equator to the pole that faces the viewer; the other half is hidden.
  for (int band = 0; band < kBands; ++band) add_band(camera, latitude(band), latitude(band + 1), colour, out);
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
      add_band(camera, {points[line[i - 1]], radius_mm, before, before},
               {points[line[i]], radius_mm, ring, ring}, colour_of(line[i - 1]), out);
    before = ring;
  }
  add_ball(camera, points[line.front()], 1.4 * radius_mm, colour_of(line.front()), out);
  add_ball(camera, points[line.back()], 1.4 * radius_mm, colour_of(line.back()), out);
}

}  // namespace lumesh::report
