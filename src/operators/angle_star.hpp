#pragma once
/// @file The dihedral angles around one vertex as a function of its place, and the place where the worst of
/// them is best.

#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh::operators {

class AngleStar {
 public:
  /// Begins anew, with no tetrahedra. @param obtuse_weight  As in ShapeMeasure.
  void begin(double obtuse_weight) {
    bases_.clear();
    normal_ = Vec3::Zero();
    obtuse_weight_ = obtuse_weight;
  }
  /// Adds the tetrahedron between a triangle and the vertex, positively oriented in this order.
  void add(const Vec3& a, const Vec3& b, const Vec3& c) { bases_.push_back({a, b, c}); }
  /// Climbing keeps to the plane through its start. @param normal  Unit.
  void keep_in_plane(const Vec3& normal) { normal_ = normal; }

  /// Lowest angle_quality() with the vertex at `x`.
  [[nodiscard]] double worst_at(const Vec3& x) const;
  /// Climbs from x to a place where the worst quality is as good as it gets nearby; from where some
  /// tetrahedron is flat or inverted it does not move. Steepest ascent of the minimum of many functions:
  /// along the shortest convex combination of the gradients of the worst ones, as far as they are the worst
  /// ones. Source: Freitag and Ollivier-Gooch 1997,
  /// doi:10.1002/(SICI)1097-0207(19971115)40:21<3979::AID-NME251>3.0.CO;2-9.
  /// @return the worst quality there.
  double climb(Vec3& x, int max_steps);

 private:
  struct Base {
    Vec3 a, b, c;
  };
  /// Weighted sine of one dihedral angle and its gradient by the place of the vertex.
  struct Term {
    double value;
    Vec3 gradient;
  };

  void differentiate(const Vec3& x);
  [[nodiscard]] Vec3 ascent_direction(double worst);
  [[nodiscard]] double first_step(const Vec3& direction, double worst) const;

  double obtuse_weight_ = 1;
  Vec3 normal_ = Vec3::Zero();
  std::vector<Base> bases_;
  std::vector<Term> terms_;
  std::vector<Vec3> active_;
};

}  // namespace lumesh::operators
