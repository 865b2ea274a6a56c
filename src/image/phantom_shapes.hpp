#pragma once
/// @file Bodies with exact distance functions that phantoms are made of. Positions are the image's own
/// millimetres: spacing times voxel index, before rotation and shift.

#include <memory>
#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh::image {

class Shape {
 public:
  virtual ~Shape() = default;
  /// Signed distance to the surface, negative inside; Lipschitz constant 1.
  [[nodiscard]] virtual double distance(const Vec3& p) const = 0;
};

using ShapePointer = std::shared_ptr<const Shape>;

class Ball final : public Shape {
 public:
  Ball(const Vec3& centre, double radius) : centre_(centre), radius_(radius) {}
  [[nodiscard]] double distance(const Vec3& p) const override { return (p - centre_).norm() - radius_; }

 private:
  Vec3 centre_;
  double radius_;
};

/// Around the third axis.
class Torus final : public Shape {
 public:
  Torus(const Vec3& centre, double ring_radius, double tube_radius)
      : centre_(centre), ring_radius_(ring_radius), tube_radius_(tube_radius) {}
  [[nodiscard]] double distance(const Vec3& p) const override;

 private:
  Vec3 centre_;
  double ring_radius_;
  double tube_radius_;
};

/// A box grown by a ball: inner half widths plus the radius.
class RoundedBox final : public Shape {
 public:
  RoundedBox(const Vec3& centre, const Vec3& inner_half, double radius)
      : centre_(centre), inner_half_(inner_half), radius_(radius) {}
  [[nodiscard]] double distance(const Vec3& p) const override;

 private:
  Vec3 centre_;
  Vec3 inner_half_;
  double radius_;
};

class Union final : public Shape {
 public:
  explicit Union(std::vector<ShapePointer> parts) : parts_(std::move(parts)) {}
  [[nodiscard]] double distance(const Vec3& p) const override;

 private:
  std::vector<ShapePointer> parts_;
};

/// A point of a tube's axis with the radius there.
struct AxisPoint {
  Vec3 centre = Vec3::Zero();
  double radius = 0;
};

/// Union of the convex hulls of neighbouring balls along axes (round cones), in a tree of boxes. A query
/// visits a few dozen boxes and cones.
class TubeTree final : public Shape {
 public:
  explicit TubeTree(const std::vector<std::vector<AxisPoint>>& axes);
  [[nodiscard]] double distance(const Vec3& p) const override;

 private:
  static constexpr std::uint32_t kLeafCones = 4;
  struct Cone {
    Vec3 start;
    Vec3 axis;  ///< Unit.
    double length;
    double radius;       ///< At the start.
    double slope;        ///< Loss of radius per length, |slope| < 1.
    double slope_shift;  ///< slope / sqrt(1 - slope^2).
  };
  struct Node {
    Vec3 low;  ///< Box of the axis, without the radius.
    Vec3 high;
    double radius = 0;        ///< Largest.
    std::uint32_t first = 0;  ///< Cones [first, last).
    std::uint32_t last = 0;
    std::uint32_t second_child = 0;  ///< The first child follows its parent; 0 in leaves.
  };
  void add_axis(const std::vector<AxisPoint>& axis);
  std::uint32_t build(std::uint32_t first, std::uint32_t last);
  [[nodiscard]] static double cone_distance(const Cone& cone, const Vec3& p);
  [[nodiscard]] static double lower_bound(const Node& node, const Vec3& p);

  std::vector<Cone> cones_;
  std::vector<Node> nodes_;
};

/// Uniform cubic B-spline through control points (the first and last are approached, not met, unless repeated
/// thrice).
/// @return Points whose gaps are at most `step_mm`; radius as `radius_at(fraction of the length)`.
[[nodiscard]] std::vector<Vec3> sample_spline(const std::vector<Vec3>& controls, double step_mm);

/// Smooth deterministic noise in [-1, 1]: six plane waves with wavelengths of 16 to 32 units in random
/// directions.
class WaveNoise {
 public:
  static constexpr double kSlope = 0.4;  ///< Largest gradient per unit.
  WaveNoise(std::uint32_t seed, double unit_mm);
  [[nodiscard]] double at(const Vec3& p) const;

 private:
  struct Wave {
    Vec3 frequency;  ///< Radians per mm.
    double phase;
  };
  std::vector<Wave> waves_;
};

}  // namespace lumesh::image
