#pragma once
// A vessel that goes on straight beyond an opening, as functions of space.

#include <algorithm>
#include <memory>

#include "lumesh/core/smoothstep.hpp"
#include "lumesh/domain/carried_section.hpp"
#include "lumesh/field/label_field.hpp"
#include "lumesh/geometry/wall_ramp.hpp"

namespace lumesh {

struct Circle {
  Vec3 centre_mm = Vec3::Zero();
  double radius_mm = 0;
};

/// The section of an opening carried along a direction, at first along the walls before it. Functions are
/// those of the field it is carried from, in its units.
struct VesselTube {
  using LabelIndex = LabelField::LabelIndex;

  std::shared_ptr<const CarriedSection> section;
  std::shared_ptr<const CarriedSection> of_cut;  ///< With less air: what the end's plane cuts.
  std::shared_ptr<const CarriedSection> bare;    ///< The same without air: negative by the distance from it.
  WallRamp ramp = {Vec3::UnitZ(), 1};            ///< Level where walls do not tell a direction.
  Vec3 end_mm = Vec3::Zero();                    ///< On the end's plane, on the axis.
  Vec3 end_normal = Vec3::UnitZ();               ///< Unit.
  double stump_mm = 0;                           ///< Beyond the end's plane it goes on by this.
  bool stays = false;                            ///< Without length: as the field has it.
  double transition_mm = -1;                     ///< To circles; negative: the section is kept.
  Circle outer;                                  ///< Of all labels.
  Circle lumen;                                  ///< Where there is a wall around one.
  LabelIndex wall_label = 0, lumen_label = 0;
  Box3 box_mm;  ///< Around it with its air.

  [[nodiscard]] bool has_lumen() const { return lumen_label != 0; }
  /// Behind the opening's plane and before the end of the stump.
  [[nodiscard]] bool is_along(const Vec3& x) const {
    return (x - section->centre_mm).dot(section->normal) > 0 && (x - end_mm).dot(end_normal) <= stump_mm;
  }
  /// Whether it may reach into a ball, with its air.
  [[nodiscard]] bool may_meet(const Vec3& middle, double radius_mm) const {
    const CarriedSection& s = *section;
    radius_mm += ramp.max_displacement_mm();
    if ((middle - s.centre_mm).dot(s.normal) < -radius_mm) return false;
    if ((middle - end_mm).dot(end_normal) > stump_mm + radius_mm) return false;
    if (s.off_axis_mm(middle) <= s.circle_mm + radius_mm) return true;
    const Vec3 off = s.carried_back(middle) - s.first_mm;
    const double margin_mm = radius_mm / s.direction.dot(s.normal);
    const auto is_beside = [&](double at_mm, int squares) {
      return at_mm < -margin_mm || at_mm > (squares - 1) * s.step_mm + margin_mm;
    };
    return !is_beside(off.dot(s.u), s.columns) && !is_beside(off.dot(s.v), s.rows);
  }

  /// Positive inside of the object.
  [[nodiscard]] double outer_value(const LabelField& field, const Vec3& x) const {
    if (!box_mm.contains(x) || !is_along(x)) return -LabelField::kStoredLimit;
    return blended(field, x, outer, section_value(field, x));
  }
  /// Positive in the second.
  [[nodiscard]] double pair_value(const LabelField& field, const Vec3& x, LabelIndex first,
                                  LabelIndex second) const {
    const double value = field.difference_value(field.frame().to_index(source_of(x)), second, first);
    if (first == wall_label && second == lumen_label) return blended(field, x, lumen, value);
    if (second == wall_label && first == lumen_label) return -blended(field, x, lumen, -value);
    return value;
  }
  /// Label of the object at a place where outer_value() is positive.
  [[nodiscard]] LabelIndex label_at(const LabelField& field, const Vec3& x) const {
    const LabelIndex label = field.object_label_at(field.frame().to_index(source_of(x)));
    if (transition_mm < 0 || !has_lumen() || (label != wall_label && label != lumen_label)) return label;
    return pair_value(field, x, wall_label, lumen_label) > 0 ? lumen_label : wall_label;
  }

 private:
  /// Where the field knows what is there.
  [[nodiscard]] Vec3 source_of(const Vec3& x) const { return stays ? x : place_before(x); }
  /// The place of the plane that is carried to x.
  [[nodiscard]] Vec3 place_before(const Vec3& x) const {
    constexpr int kSteps = 2;  // Of a fixed point, whose error the first one leaves squared.
    Vec3 place = section->carried_back(x);
    for (int step = 0; step < kSteps; ++step) {
      const double along_mm = (x - place).dot(section->direction);
      place = section->carried_back(x - ramp.displacement(place - section->centre_mm, along_mm));
    }
    return place;
  }
  /// Without what of the plane is another vessel's. Beyond the image, where the opening is at an edge of it,
  /// the field only repeats itself.
  [[nodiscard]] double section_value(const LabelField& field, const Vec3& x) const {
    const Vec3 on_plane = place_before(x);
    if (section->inside_section_mm(on_plane) <= 0) return -LabelField::kStoredLimit;
    const double value = field.difference_value(field.frame().to_index(stays ? x : on_plane), 1, 0);
    const double off_mm = -bare->inside_section_mm(on_plane);
    const double most = (section->step_mm - off_mm) / field.frame().spacing_mm.minCoeff();
    return most > 0 ? value : std::max(-LabelField::kStoredLimit, std::min(value, most));
  }
  /// Goes over to the function of a circle, which a tube has: (R^2 - r^2) / 2R.
  [[nodiscard]] double blended(const LabelField& field, const Vec3& x, const Circle& circle,
                               double value) const {
    if (transition_mm < 0) return value;
    const Vec3& d = section->direction;
    const Vec3 off = x - circle.centre_mm;
    const double along_mm = (x - section->centre_mm).dot(d);
    const double share = smoothstep(along_mm, transition_mm);
    constexpr double kLimit = LabelField::kStoredLimit;
    const double r2 = (off - off.dot(d) * d).squaredNorm(), radius = circle.radius_mm;
    const double of_circle = (radius * radius - r2) / (2 * radius * field.frame().spacing_mm.minCoeff());
    return (1 - share) * value + share * std::clamp(of_circle, -kLimit, kLimit);
  }
};

}  // namespace lumesh
