#pragma once
/// @file The domain oracle of shapes given by formulas, against which meshes can be compared exactly.

#include <functional>
#include <optional>
#include <vector>

#include "lumesh/domain/cut_plane.hpp"
#include "lumesh/domain/domain.hpp"

namespace lumesh {

/// A function of space that says how far inside a shape a point is.
using ShapeFunction = std::function<FieldSample(const Vec3& point_mm)>;

/// Signed distance to a ball, a torus, a cylinder without ends: mm, > 0 inside.
[[nodiscard]] ShapeFunction ball_shape(const Vec3& centre_mm, double radius_mm);
/// @param ring_radius_mm  Of the circle in the middle of the tube. @param axis  Not zero.
[[nodiscard]] ShapeFunction torus_shape(const Vec3& centre_mm, const Vec3& axis, double ring_radius_mm,
                                        double tube_radius_mm);
[[nodiscard]] ShapeFunction cylinder_shape(const Vec3& on_axis_mm, const Vec3& axis, double radius_mm);
/// All of space, for bodies that planes alone cut out.
[[nodiscard]] ShapeFunction everywhere_shape();
/// What is in the first but not in the second shape.
[[nodiscard]] ShapeFunction without(ShapeFunction shape, ShapeFunction hole);

struct AnalyticBody {
  Label label;          ///< > 0; one body for each.
  ShapeFunction shape;  ///< Its slope is about 1 near the zero, and nowhere more.
};

struct AnalyticDomainOptions {
  Box3 bounds_mm;                    ///< Around all that is meshed.
  double resolution_mm = 0;          ///< > 0: a length well below all features.
  std::vector<CutPlane> cut_planes;  ///< Each an opening of its own.
};

/// At a point the body wins whose function is largest there, and the background where none is positive; what
/// a plane cuts off is outside. Bodies that overlap therefore share a boundary where their functions are
/// equal.
class AnalyticDomain final : public Domain {
 public:
  /// @throws Error{kUsage} if there are no bodies, labels are not positive or not different, or for options.
  AnalyticDomain(std::vector<AnalyticBody> bodies, AnalyticDomainOptions options);

  [[nodiscard]] Surroundings surroundings(const Vec3& point_mm) const override;
  [[nodiscard]] double clearance_limit_mm() const override;
  [[nodiscard]] MaterialSet materials_near(const Vec3& point_mm, double reach_mm) const override;
  [[nodiscard]] std::optional<Vec3> project(const Vec3& start_mm, const MaterialSet& set,
                                            double reach_mm) const override;
  [[nodiscard]] FieldSample separation(const Vec3& point_mm, Material first, Material second) const override;
  [[nodiscard]] bool may_hold_object(const Vec3& low_mm, const Vec3& high_mm) const override;
  [[nodiscard]] Box3 bounds_mm() const override { return options_.bounds_mm; }
  [[nodiscard]] double resolution_mm() const override { return options_.resolution_mm; }
  [[nodiscard]] std::span<const CutPlane> cut_planes() const override { return options_.cut_planes; }
  [[nodiscard]] Label label_of(Material m) const override {
    return is_meshed(m) ? bodies_[m - 1].label : kBackground;
  }
  [[nodiscard]] Material label_count() const override { return static_cast<Material>(bodies_.size() + 1); }
  [[nodiscard]] Material material_count() const override {
    return static_cast<Material>(bodies_.size() + 1 + options_.cut_planes.size());
  }

 private:
  /// How far inside a label, the background (always 0), or beyond a plane.
  [[nodiscard]] FieldSample depth(const Vec3& x, Material m) const;
  [[nodiscard]] MaterialSet labels_near(const Vec3& point_mm, double reach_mm) const;

  std::vector<AnalyticBody> bodies_;
  AnalyticDomainOptions options_;  // Unit normals.
};

/// A box with edges along the axes, cut out by its six faces, in the order -x, +x, -y, …
[[nodiscard]] AnalyticDomain analytic_box(const Box3& box_mm);
[[nodiscard]] AnalyticDomain analytic_ball(const Vec3& centre_mm, double radius_mm);
[[nodiscard]] AnalyticDomain analytic_torus(const Vec3& centre_mm, const Vec3& axis, double ring_radius_mm,
                                            double tube_radius_mm);
/// A piece of a cylinder whose two ends are openings.
[[nodiscard]] AnalyticDomain analytic_cylinder(const Vec3& from_mm, const Vec3& to_mm, double radius_mm);
/// Label 2 in the middle of label 1.
[[nodiscard]] AnalyticDomain analytic_nested_balls(const Vec3& centre_mm, double inner_radius_mm,
                                                   double outer_radius_mm);
/// Labels 1 and 2; where the balls overlap, the flat disc between them divides them.
[[nodiscard]] AnalyticDomain analytic_two_balls(const Vec3& centre_1_mm, double radius_1_mm,
                                                const Vec3& centre_2_mm, double radius_2_mm);

}  // namespace lumesh
