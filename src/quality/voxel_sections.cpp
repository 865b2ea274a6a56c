#include <Eigen/Geometry>
#include <cmath>
#include <unordered_set>

#include "lumesh/core/grid.hpp"
#include "plane_sections.hpp"

namespace lumesh::quality {

namespace {

constexpr double kOffSides = 1e-6;  // In voxels.

/// A plane in the image's axes, in mm from the centre of voxel (0, 0, 0).
struct ImagePlane {
  Vec3 normal;
  double offset;
  Vec3 spacing;

  ImagePlane(const ImageFrame& frame, const SectionPlane& plane)
      : normal(frame.direction.transpose() * plane.normal),
        offset(normal.dot(frame.direction.transpose() * (plane.origin_mm - frame.origin_mm)) +
               kOffSides * frame.spacing_mm.minCoeff()),
        spacing(frame.spacing_mm) {}

  /// Height of a place given as index.
  [[nodiscard]] double height(const Vec3& index) const {
    return normal.dot(index.cwiseProduct(spacing)) - offset;
  }
  [[nodiscard]] bool crosses_voxel(const Index3& voxel) const {
    return std::abs(height(voxel.cast<double>())) < normal.cwiseAbs().dot(spacing) / 2;
  }
  /// The side of a voxel towards `sign` along an axis.
  [[nodiscard]] bool crosses_side(const Index3& voxel, int axis, int sign) const {
    Vec3 centre = voxel.cast<double>();
    centre[axis] += 0.5 * sign;
    Vec3 half = normal.cwiseAbs().cwiseProduct(spacing) / 2;
    half[axis] = 0;
    return std::abs(height(centre)) < half.sum();
  }
};

/// A convex polygon of at most eight corners.
struct SmallPolygon {
  std::array<PlanePoint, 8> corners;
  std::size_t count = 0;

  /// Part of it that has normal . p <= bound.
  [[nodiscard]] SmallPolygon below(const PlanePoint& normal, double bound) const {
    SmallPolygon kept;
    for (std::size_t i = 0; i < count; ++i) {
      const PlanePoint &a = corners[i], &b = corners[(i + 1) % count];
      const double at_a = normal.dot(a) - bound, at_b = normal.dot(b) - bound;
      if (at_a <= 0) kept.corners[kept.count++] = a;
      if ((at_a < 0 && at_b > 0) || (at_a > 0 && at_b < 0))
        kept.corners[kept.count++] = a + at_a / (at_a - at_b) * (b - a);
    }
    return kept;
  }
  [[nodiscard]] double area() const {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const PlanePoint &a = corners[i], &b = corners[(i + 1) % count];
      sum += a.x() * b.y() - a.y() * b.x();
    }
    return std::abs(sum) / 2;
  }
};

/// Area of what a plane has in one voxel: its shadow along the axis that it is most square to is the voxel's
/// rectangle between two lines.
double area_in_voxel(const ImagePlane& plane, const Index3& voxel) {
  int along = 0;
  plane.normal.cwiseAbs().maxCoeff(&along);
  const int s = (along + 1) % 3, t = (along + 2) % 3;
  const Vec3 half = plane.spacing / 2;
  const double height = plane.height(voxel.cast<double>());
  const PlanePoint slope(plane.normal[s], plane.normal[t]);
  const double reach = std::abs(plane.normal[along]) * half[along];
  const SmallPolygon rectangle = {{PlanePoint(-half[s], -half[t]), PlanePoint(half[s], -half[t]),
                                   PlanePoint(half[s], half[t]), PlanePoint(-half[s], half[t])},
                                  4};
  const SmallPolygon inside = rectangle.below(slope, reach - height).below(-slope, reach + height);
  return inside.area() / std::abs(plane.normal[along]);
}

/// The voxel of the object to begin with.
std::optional<Index3> first_voxel(const LabelImage& image, const ImagePlane& plane, const Vec3& origin_mm) {
  const Vec3 index = image.frame().to_index(origin_mm);
  const Index3 own = index.array().round().cast<int>();
  std::optional<Index3> best;
  double smallest = std::numeric_limits<double>::infinity();
  for_each_place(own - Index3::Ones(), own + Index3::Ones(), [&](const Index3& voxel) {
    if (!image.frame().contains(voxel) || image.at(voxel) == 0 || !plane.crosses_voxel(voxel)) return;
    const double distance = (voxel.cast<double>() - index).cwiseProduct(plane.spacing).norm();
    if (distance >= smallest) return;
    smallest = distance;
    best = voxel;
  });
  return best;
}

}  // namespace

std::optional<VoxelSection> voxel_section(const LabelImage& image, const CutPlanes& cuts,
                                          const SectionPlane& plane, double limit_mm) {
  const ImageFrame& frame = image.frame();
  const ImagePlane in_image(frame, plane);
  const std::optional<Index3> first = first_voxel(image, in_image, plane.origin_mm);
  if (!first) return std::nullopt;
  VoxelSection section;
  std::unordered_set<std::size_t> seen = {frame.offset(*first)};
  std::vector<Index3> found = {*first};  // In an order that hangs on nothing but the plane.
  for (std::size_t next = 0; next < found.size() && section.is_whole; ++next) {
    const Index3 voxel = found[next];
    const Vec3 centre_mm = frame.to_physical(voxel.cast<double>());
    const Vec3 from_origin = centre_mm - plane.origin_mm;
    if (from_origin.norm() > limit_mm || cuts.beyond(centre_mm)) section.is_whole = false;
    section.parts.push_back(
        {{from_origin.dot(plane.u), from_origin.dot(plane.v)}, area_in_voxel(in_image, voxel)});
    for (int side = 0; side < 6; ++side) {
      const int axis = side / 2, sign = side % 2 == 0 ? 1 : -1;
      if (!in_image.crosses_side(voxel, axis, sign)) continue;
      Index3 beside = voxel;
      beside[axis] += sign;
      if (!frame.contains(beside))
        section.is_whole = false;
      else if (image.at(beside) != 0 && seen.insert(frame.offset(beside)).second)
        found.push_back(beside);
    }
  }
  return section;
}

}  // namespace lumesh::quality
