// The zero sets at the border of the image, where vessels leave it.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "field_fixtures.hpp"
#include "lumesh/field/label_field.hpp"
#include "wall_fixtures.hpp"

namespace lumesh {
namespace {

TEST(LabelField, VesselsLeaveTheImageInTheirOwnDirection) {
  const ImageFrame frame = frame_of({40, 40, 40}, Vec3::Ones());
  const TubeAxis axis = axis_through_middle(frame, {1, 0.5, 0.3});
  const LabelField field(tube(frame, axis, 4), {});
  // Sections square to the axis that reach to within half a voxel of the border x = 39.
  double squares = 0;
  int count = 0;
  const Vec3 a = axis.direction.cross(Vec3::UnitX()).normalized(), b = axis.direction.cross(a);
  for (double t = 10; t < 22; t += 0.25) {
    for (int n = 0; n < 40; ++n) {
      const Vec3 out = std::cos(n * 0.157) * a + std::sin(n * 0.157) * b;
      const Vec3 wall = axis.point + t * axis.direction + 4 * out;
      if (wall.x() < 36 || wall.x() > 39.4 || (wall.tail<2>().array() < 3).any() ||
          (wall.tail<2>().array() > 36).any())
        continue;
      const double r = radius_along(field, axis.point + t * axis.direction, out, 5.5);
      ASSERT_TRUE(std::isfinite(r));
      squares += (r - 4) * (r - 4);
      ++count;
    }
  }
  ASSERT_GT(count, 100);
  EXPECT_LT(std::sqrt(squares / count), 0.08);
}

/// Area of the label's section in the image's border of highest x, per the circle's of the radius.
/// @param longer  Along y, than the circle.
double section_at_border(const LabelField& field, const Vec3& centre, double radius, double longer = 1) {
  constexpr double kStep = 0.125;
  int inside = 0;
  const double reach = longer * radius + 3;
  for (double y = -reach; y < reach; y += kStep)
    for (double z = -radius - 3; z < radius + 3; z += kStep) {
      const Vec3 place(centre.x() - 0.01, centre.y() + y, centre.z() + z);
      inside += field.value(field.frame().to_index(place), 1) > 0 ? 1 : 0;
    }
  return inside * kStep * kStep / (M_PI * radius * radius);
}

/// The true one, in the same unit.
template <class IsInside>
double section_of(const IsInside& is_inside, const Vec3& centre, double radius) {
  constexpr double kStep = 0.125;
  int inside = 0;
  for (double y = -2 * radius; y < 2 * radius; y += kStep)
    for (double z = -2 * radius; z < 2 * radius; z += kStep)
      inside += is_inside(centre + Vec3(0, y, z)) ? 1 : 0;
  return inside * kStep * kStep / (M_PI * radius * radius);
}

TEST(LabelField, VesselsThatBendAtTheBorderKeepTheirSection) {
  // Square to the border, along circles of 5 to 9 radii. Least third derivatives alone are 4 % too narrow.
  constexpr int kCount = 16;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  const ImageFrame frame = frame_of({36, 40, 40}, Vec3::Ones());
  double sum = 0, squares = 0;
  for (int n = 0; n < kCount; ++n) {
    const double radius = 3.5 + 2 * uniform(random), circle = radius * (5 + 4 * uniform(random));
    const double turn = 2 * M_PI * uniform(random);
    const Vec3 end(35.5, 19 + uniform(random), 19 + uniform(random)), side(0, std::cos(turn), std::sin(turn));
    const LabelField field(image_of(frame, 1,
                                    [&](const Vec3& p) {
                                      const Vec3 d = p - end;
                                      const double off = std::hypot(circle - d.dot(side), d.x()) - circle;
                                      return std::hypot(off, d.dot(side.cross(Vec3::UnitX()))) < radius;
                                    }),
                           {});
    const double error = section_at_border(field, end, radius) - 1;
    sum += error, squares += error * error;
  }
  EXPECT_NEAR(sum / kCount, 0, 0.02);
  EXPECT_LT(std::sqrt(squares / kCount), 0.035);
}

/// Errors of the sections of vessels on circles of 6 to 10 radii, that leave up to 25 degrees off square.
/// @param wall  Thickness of another label around them.
std::vector<double> errors_of_bent_vessels(double thinnest, double thickest, double wall = 0) {
  constexpr int kCount = 24;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  const ImageFrame frame = frame_of({36, 44, 44}, Vec3::Ones());
  std::vector<double> errors;
  for (int n = 0; n < kCount; ++n) {
    const double radius = thinnest + (thickest - thinnest) * uniform(random);
    const double circle = radius * (6 + 4 * uniform(random)),
                 lean = M_PI / 180 * 50 * (uniform(random) - 0.5), turn = 2 * M_PI * uniform(random);
    const Vec3 end(35.5, 21 + uniform(random), 21 + uniform(random)), side(0, std::cos(turn), std::sin(turn));
    const Vec3 to_centre = std::cos(lean) * side - std::sin(lean) * Vec3::UnitX(),
               along = std::cos(lean) * Vec3::UnitX() + std::sin(lean) * side;
    const auto distance = [&](const Vec3& p) {
      const Vec3 d = p - end;
      const double off = std::hypot(circle - d.dot(to_centre), d.dot(along)) - circle;
      return std::hypot(off, d.dot(side.cross(Vec3::UnitX())));
    };
    const auto is_inside = [&](const Vec3& p) { return distance(p) < radius; };
    const LabelField field(image_of(frame, 2,
                                    [&](const Vec3& p) {
                                      return is_inside(p) ? 1 : distance(p) < radius + wall ? 2 : 0;
                                    }),
                           {});
    errors.push_back(section_at_border(field, end, radius, 1.5) / section_of(is_inside, end, radius) - 1);
  }
  return errors;
}

double root_mean_square(std::span<const double> values) {
  return std::sqrt(std::inner_product(values.begin(), values.end(), values.begin(), 0.0) /
                   static_cast<double>(values.size()));
}

/// Errors are 21, 10 and 5 % without the shift towards sections further in.
TEST(LabelField, ThinVesselsThatBendAtTheBorderKeepTheirSection) {
  EXPECT_LT(root_mean_square(errors_of_bent_vessels(1.5, 2)), 0.1);
  EXPECT_LT(root_mean_square(errors_of_bent_vessels(2, 2.5)), 0.08);
  EXPECT_LT(root_mean_square(errors_of_bent_vessels(2.5, 4)), 0.04);
}

/// Errors are 13 % where the outer wall alone is shifted.
TEST(LabelField, LumensOfThinVesselsThatBendAtTheBorderKeepTheirSection) {
  EXPECT_LT(root_mean_square(errors_of_bent_vessels(2, 2.5, 1.8)), 0.08);
}

/// Errors of the sections of vessels along x, up to 20 degrees off, whose radius changes towards the border.
/// @param radius_at  By the distance along the axis from where it meets the border, over the radius.
template <class RadiusAt>
std::vector<double> errors_of_changing_vessels(double thinnest, double thickest, const RadiusAt& radius_at) {
  constexpr int kCount = 24;
  std::mt19937 random(13);
  std::uniform_real_distribution<double> uniform(0, 1);
  const ImageFrame frame = frame_of({36, 44, 44}, Vec3::Ones());
  std::vector<double> errors;
  for (int n = 0; n < kCount; ++n) {
    const double radius = thinnest + (thickest - thinnest) * uniform(random),
                 lean = M_PI / 180 * 20 * uniform(random), turn = 2 * M_PI * uniform(random);
    const Vec3 end(35.5, 21 + uniform(random), 21 + uniform(random)), side(0, std::cos(turn), std::sin(turn)),
        along = std::cos(lean) * Vec3::UnitX() + std::sin(lean) * side;
    const auto is_inside = [&](const Vec3& p) {
      const double at = (p - end).dot(along);
      return (p - end - at * along).norm() < radius * radius_at(at / radius);
    };
    const LabelField field(image_of(frame, 1, is_inside), {});
    const double section = section_of(is_inside, end, radius);
    errors.push_back(section_at_border(field, end, radius, 1.5) / section - 1);
  }
  return errors;
}

/// Errors are 21, 11 and 24 % where the voxels of the last layer do not count.
TEST(LabelField, VesselsThatNarrowOrWidenTowardsTheBorderHaveTheirSectionThere) {
  const auto narrow_end = [](double at) { return 1 - 0.3 * std::exp(std::min(0.0, at / 0.8)); };
  const auto wide_end = [](double at) { return 1 + 0.3 * std::exp(std::min(0.0, at / 0.8)); };
  const auto throat = [](double at) { return 1 - 0.25 * std::exp(-std::pow((at + 0.8) / 1.5, 2)); };
  EXPECT_LT(root_mean_square(errors_of_changing_vessels(2.5, 3.5, narrow_end)), 0.17);
  EXPECT_LT(root_mean_square(errors_of_changing_vessels(2.5, 3.5, wide_end)), 0.075);
  EXPECT_LT(root_mean_square(errors_of_changing_vessels(2.5, 3.5, throat)), 0.18);
}

TEST(LabelField, StraightVesselsThatLeaveObliquelyKeepTheirSection) {
  // Least second derivatives widened them by 1.9 % in the mean.
  constexpr int kCount = 12;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  double sum = 0, squares = 0;
  for (int n = 0; n < kCount; ++n) {
    const double radius = 3 + uniform(random), lean = M_PI / 180 * (60 + 12 * uniform(random));
    const ImageFrame frame = frame_of({20, 90, 16}, Vec3::Ones());
    const Vec3 end(19.5, 70 + uniform(random), 7 + uniform(random));
    const TubeAxis axis{end, Vec3(std::cos(lean), std::sin(lean), 0)};
    const LabelField field(tube(frame, axis, radius), {});
    const double longer = 1 / std::cos(lean);
    const double error = section_at_border(field, end, radius, longer) / longer - 1;
    sum += error, squares += error * error;
  }
  EXPECT_NEAR(sum / kCount, 0, 0.01);
  EXPECT_LT(std::sqrt(squares / kCount), 0.025);
}

/// Root of the mean square of the errors of two vessels' sections at the border, each 1 for the circle's.
/// @param gap  Least distance of their walls, in voxels. @param bar  Radius of a rod that joins them far
/// away.
double error_beside(double gap, double bar) {
  constexpr int kPairs = 10;
  std::mt19937 random(23);
  std::uniform_real_distribution<double> uniform(0, 1);
  double squares = 0;
  for (int n = 0; n < kPairs; ++n) {
    const double radius = 2.2 + 1.8 * uniform(random), turn = 2 * M_PI * uniform(random);
    const double width = gap + 1.5 * uniform(random);
    const Vec3 axis = Vec3(1, 0.5 * uniform(random), 0.5 * uniform(random)).normalized();
    const ImageFrame frame = frame_of({40, 60, 60}, Vec3::Ones());
    const Vec3 y = axis.cross(Vec3::UnitZ()).normalized(), z = axis.cross(y);
    const Vec3 off = (radius + 0.5 * width) * (std::cos(turn) * y + std::sin(turn) * z);
    const Vec3 end(39.5, 29 + uniform(random), 29 + uniform(random));
    const TubeAxis tubes[2] = {{end + off - off.x() / axis.x() * axis, axis},
                               {end - off + off.x() / axis.x() * axis, axis}};
    const Vec3 rod = end - 30 * axis;
    const auto is_inside = [&](const Vec3& p) {
      const double along = (p - rod).dot(off.normalized());
      const bool is_in_rod =
          std::abs(along) < off.norm() && (p - rod - along * off.normalized()).norm() < bar;
      return is_in_rod || std::min(tubes[0].distance(p), tubes[1].distance(p)) < radius;
    };
    const LabelField field(image_of(frame, 1, [&](const Vec3& p) { return is_inside(p) ? 1 : 0; }), {});
    for (const int t : {0, 1}) {
      constexpr double kStep = 0.125, kReach = 7;
      int inside = 0;
      for (double dy = -kReach; dy < kReach; dy += kStep)
        for (double dz = -kReach; dz < kReach; dz += kStep) {
          const Vec3 place = tubes[t].point + Vec3(-0.01, dy, dz);
          if (tubes[t].distance(place) < tubes[1 - t].distance(place))
            inside += field.value(field.frame().to_index(place), 1) > 0 ? 1 : 0;
        }
      const double error = inside * kStep * kStep / (M_PI * radius * radius / axis.x()) - 1;
      squares += error * error;
    }
  }
  return std::sqrt(squares / (2 * kPairs));
}

/// The error of one vessel by itself is 2 %. A common function of two walls had 4.2, 6.6 and 4.3 %.
TEST(LabelField, VesselsSideBySideLeaveTheImageWithTheirSections) {
  EXPECT_LT(error_beside(1.5, 0), 0.025);
  EXPECT_LT(error_beside(0.8, 0), 0.035);
  EXPECT_LT(error_beside(1.5, 2.0), 0.03);
}

/// A wall alone has a label. One function for both its sides was up to 55 % off at the border.
TEST(LabelField, WallsWithoutALabelOfTheLumenLeaveTheImageWithTheirSections) {
  struct Wall {
    double radius, thickness, degrees;
  };
  for (const Wall& wall : {Wall{2, 2, 25}, Wall{2, 3, 25}, Wall{4, 3, 0}, Wall{4, 3, 25}, Wall{6, 1.5, 25}}) {
    const double lean = M_PI / 180 * wall.degrees, outer = wall.radius + wall.thickness;
    const ImageFrame frame = frame_of({32, 46, 30}, Vec3::Ones());
    const Vec3 end(31.5, 31.3, 14.6);
    const TubeAxis axis{end, Vec3(std::cos(lean), std::sin(lean), 0)};
    const auto is_wall = [&](const Vec3& p) {
      return axis.distance(p) >= wall.radius && axis.distance(p) < outer;
    };
    const LabelField field(image_of(frame, 1, is_wall), {});
    const double exact = (1 - std::pow(wall.radius / outer, 2)) / std::cos(lean);
    EXPECT_NEAR(section_at_border(field, end, outer, 1 / std::cos(lean)) / exact, 1, 0.05)
        << wall.radius << " " << wall.thickness << " " << wall.degrees;
  }
}

}  // namespace
}  // namespace lumesh
