// Flow extensions against tubes that are known exactly.
#include "lumesh/domain/extension.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "fixtures/images.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/domain/vessel_cut.hpp"
#include "lumesh/field/label_field.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

struct StraightTube {
  Vec3 through, axis;
  double radius;

  [[nodiscard]] double off(const Vec3& p) const {
    const Vec3 r = p - through;
    return (r - r.dot(axis) * axis).norm();
  }
};

ExtensionOptions extension_of(const std::string& lengths, const std::string& transition) {
  ExtensionOptions options{named_lengths_from(lengths)};
  if (!transition.empty()) options.transition = local_length_from(transition);
  return options;
}

struct Extended {
  LabelImage before;
  ImageDomain domain;
  std::vector<Opening> openings;
  ExtendedImage result;
  std::map<std::string, Opening> ends;  // By name.

  Extended(LabelImage image, const std::string& lengths, const std::string& transition = "",
           const std::vector<CutPlane>& cuts = {})
      : before(std::move(image)),
        domain(before, {{}, cuts}),
        openings(find_openings(domain)),
        result(extend_openings(before, domain, openings, extension_of(lengths, transition))) {
    for (const Opening& end : find_openings(*result.domain)) ends[end.name] = end;
  }
};

LabelImage image_of(const StraightTube& tube, double wall = 0) {
  return fixtures::voxels_of(fixtures::frame_of({40, 36, 32}), {0, 3, 7}, [&](const Vec3& p) {
    return tube.off(p) < tube.radius ? 1 : tube.off(p) < tube.radius + wall ? 2 : 0;
  });
}

TEST(ExtendOpenings, CarriesASlantedTubeOnAlongItsAxis) {
  const StraightTube tube{{19.3, 18.2, 16}, Vec3(0.45, -0.2, 1).normalized(), 4};
  const Extended e(image_of(tube), "5r");
  EXPECT_TRUE(e.result.notes.empty());
  ASSERT_EQ(e.ends.size(), e.openings.size());
  const double area = std::numbers::pi * tube.radius * tube.radius;
  for (const Opening& opening : e.openings) {
    ASSERT_TRUE(e.ends.contains(opening.name));
    const Opening& end = e.ends.at(opening.name);
    EXPECT_NEAR((end.centre_mm - opening.centre_mm).norm() / (5 * tube.radius), 1, 0.01);
    EXPECT_NEAR(end.area_mm2 / area, 1, 0.02);  // The field's own radius is right to 1 %.
    EXPECT_NEAR(end.area_mm2 / (opening.area_mm2 * end.normal.dot(opening.normal)), 1, 0.01);
    EXPECT_GT(std::abs(end.normal.dot(tube.axis)), std::cos(1 * std::numbers::pi / 180));
    const Vec3 side = tube.axis.unitOrthogonal(), on_axis = end.centre_mm - 2 * end.normal;
    EXPECT_EQ(e.result.domain->label_at(on_axis + (tube.radius - 0.4) * side), 3);
    EXPECT_EQ(e.result.domain->label_at(on_axis + (tube.radius + 0.4) * side), 0);
    EXPECT_EQ(e.result.domain->label_at(end.centre_mm + 0.1 * end.normal), 0);
  }
}

TEST(ExtendOpenings, CarriesAnObliqueTubeOnAlongItsAxis) {
  for (const double degrees : {60.0, 65.0, 70.0, 74.0}) {
    const double lean = degrees * std::numbers::pi / 180;
    const StraightTube tube{{65.3, 9.6, 12.1}, Vec3(std::sin(lean), 0, std::cos(lean)), 4};
    const Extended e(fixtures::voxels_of(fixtures::frame_of({130, 20, 25}), {0, 3},
                                         [&](const Vec3& p) { return tube.off(p) < tube.radius ? 1 : 0; }),
                     "6r");
    EXPECT_TRUE(e.result.notes.empty());
    ASSERT_EQ(e.ends.size(), 2U);
    for (const auto& [name, end] : e.ends) {
      EXPECT_NEAR(end.area_mm2 / (std::numbers::pi * tube.radius * tube.radius), 1, 0.04) << degrees << name;
      EXPECT_GT(std::abs(end.normal.dot(tube.axis)), std::cos(1 * std::numbers::pi / 180)) << degrees << name;
    }
  }
}

TEST(ExtendOpenings, LeavesTheImageAsItWas) {
  const StraightTube tube{{19.3, 18.2, 16}, Vec3(0.1, -0.2, 1).normalized(), 5};
  const Extended e(image_of(tube, 2), "4r");
  const Index3 shift = (e.result.domain->frame().to_index(Vec3::Zero())).array().round().cast<int>();
  for (int k = 3; k < 29; ++k)
    for (int j = 3; j < 33; ++j)
      for (int i = 3; i < 37; ++i) {
        const Vec3 at = Vec3(i, j, k) + Vec3(0.25, 0.5, 0.375);
        const Vec3 same = at + shift.cast<double>();
        EXPECT_EQ(e.result.image.at(Index3(i, j, k) + shift), e.before.at({i, j, k}));
        for (const int second : {1, 2})
          for (const int first : {0, 3 - second}) {
            const auto a = static_cast<LabelImage::Index>(first), b = static_cast<LabelImage::Index>(second);
            const double value = e.domain.field().difference_value(at, a, b);
            if (std::abs(value) >= LabelField::kFieldLimit) continue;
            ASSERT_EQ(e.result.domain->field().difference_value(same, a, b), value);
          }
      }
}

/// What the field has beyond the border shapes the section there, too.
TEST(ExtendOpenings, LeavesOtherOpeningsAsTheyWere) {
  const StraightTube tube{{19.3, 18.2, 16}, Vec3(0.6, -0.3, 1).normalized(), 4};
  const Extended e(image_of(tube), "inlet_1=4r");
  ASSERT_EQ(e.openings.size(), 2U);
  for (const Opening& before : e.openings) {
    if (before.name == "inlet_1") continue;
    EXPECT_NEAR(e.ends.at(before.name).area_mm2, before.area_mm2, 0.005 * before.area_mm2) << before.name;
  }
}

TEST(ExtendOpenings, KeepsLumenAndWallAPair) {
  const StraightTube tube{{19.3, 18.2, 16}, Vec3(0.1, -0.2, 1).normalized(), 5};
  for (const std::string transition : {"", "1r"}) {
    const Extended e(image_of(tube, 2), "4r", transition);
    ASSERT_EQ(e.openings.size(), 4U);
    for (const Opening& opening : e.openings) {
      ASSERT_TRUE(e.ends.contains(opening.name)) << opening.name;
      const Opening& end = e.ends.at(opening.name);
      EXPECT_EQ(end.label, opening.label);
      EXPECT_EQ(end.is_rim, opening.is_rim);
      EXPECT_NEAR(end.area_mm2 / (opening.area_mm2 * end.normal.dot(opening.normal)), 1, 0.01);
      EXPECT_NEAR((end.centre_mm - opening.centre_mm).norm() / (4 * tube.radius), 1, 0.02);
    }
  }
}

/// A wall whose lumen has no label, so that its ends are rings, carried on with and without a transition.
void expect_hollow_wall_carried_on(const Vec3& way, double wall) {
  const StraightTube tube{{20.3, 17.6, 16}, way.normalized(), 6};
  LabelImage image = fixtures::voxels_of(fixtures::frame_of({48, 44, 32}), {0, 2}, [&](const Vec3& p) {
    return tube.off(p) >= tube.radius && tube.off(p) < tube.radius + wall ? 1 : 0;
  });
  for (const std::string transition : {"", "1r"}) {
    const Extended e(image, "3r", transition);
    ASSERT_EQ(e.openings.size(), 2U);
    EXPECT_EQ(e.result.notes.size(), transition.empty() ? 0U : 2U);
    for (const Opening& opening : e.openings) {
      EXPECT_NEAR(opening.lumen_radius_mm(), tube.radius * std::sqrt(1 / tube.axis.z()), 0.03 * tube.radius);
      const Opening& end = e.ends.at(opening.name);
      EXPECT_TRUE(end.is_hollow());
      EXPECT_NEAR((end.centre_mm - opening.centre_mm).norm() / (3 * tube.radius), 1, 0.04);
      EXPECT_GT(std::abs(end.normal.dot(tube.axis)), std::cos(5 * std::numbers::pi / 180));
      EXPECT_NEAR(end.area_mm2 / (opening.area_mm2 * end.normal.dot(opening.normal)), 1, 0.02);
    }
  }
}

TEST(ExtendOpenings, CarriesAHollowWallOnAlongItsAxis) {
  expect_hollow_wall_carried_on({0.3, 0.1, 1}, 2);
}

TEST(ExtendOpenings, CarriesHollowWallsOnAlongTheirAxes) {
  for (const Vec3& way : {Vec3(0.1, -0.05, 1), Vec3(0.3, 0.1, 1), Vec3(-0.2, 0.35, 1)})
    for (const double wall : {2.0, 3.0})
      if (way != Vec3(0.3, 0.1, 1) || wall != 2) expect_hollow_wall_carried_on(way, wall);
}

TEST(ExtendOpenings, TurnsAnEllipseIntoTheCircleOfItsArea) {
  const LabelImage image = fixtures::voxels_of(fixtures::frame_of({40, 30, 20}), {0, 1}, [](const Vec3& p) {
    return std::hypot((p.x() - 19.4) / 8, (p.y() - 14.7) / 4) < 1 ? 1 : 0;
  });
  const Extended kept(image, "inlet_1=4r"), round(image, "inlet_1=4r", "2r");
  for (const Extended* e : {&kept, &round}) {
    const Opening &end = e->ends.at("inlet_1"), &before = e->openings.front();
    EXPECT_NEAR(end.area_mm2 / (std::numbers::pi * 8 * 4), 1, 0.02);
    EXPECT_NEAR(end.area_mm2 / before.area_mm2, 1, 3e-3);
    const Vec3 size = end.box_mm.sizes(), was = before.box_mm.sizes();
    EXPECT_NEAR(size.x(), e == &kept ? was.x() : 2 * std::sqrt(32), 0.3);
    EXPECT_NEAR(size.y(), e == &kept ? was.y() : 2 * std::sqrt(32), 0.3);
  }
  // Not named: it stays where it is.
  const Opening& other = *std::find_if(kept.openings.begin(), kept.openings.end(),
                                       [](const Opening& o) { return o.name == "outlet_1"; });
  EXPECT_LT((kept.ends.at("outlet_1").centre_mm - other.centre_mm).norm(), 0.02);
  EXPECT_NEAR(kept.ends.at("outlet_1").area_mm2 / other.area_mm2, 1, 2e-3);
}

TEST(ExtendOpenings, StopsBeforeAnotherExtension) {
  // They would meet 25 beyond the image.
  const StraightTube a{{14, 15, 25}, Vec3(0.3, 0, 1).normalized(), 3},
      b{{36, 15, 25}, Vec3(-0.3, 0, 1).normalized(), 3};
  const auto pair = fixtures::voxels_of(fixtures::frame_of({50, 30, 26}), {0, 1}, [&](const Vec3& p) {
    return p.z() > 8 && std::min(a.off(p), b.off(p)) < 3 ? 1 : 0;
  });
  const Extended free(pair, "4r"), stopped(pair, "20r");
  EXPECT_TRUE(free.result.notes.empty());
  ASSERT_EQ(stopped.result.notes.size(), 2U);
  EXPECT_EQ(stopped.ends.size(), 2U);
  for (const auto& [name, end] : stopped.ends) EXPECT_GT(end.centre_mm.z(), 35) << name;
  for (const Extended* e : {&free, &stopped}) {
    const auto labels = label_topology(e->result.image);
    EXPECT_EQ(labels.at(0).component_count, 2U);
    EXPECT_EQ(labels.at(0).euler_number, 2);
  }
}

/// Two vessels that leave side by side and lean towards each other.
LabelImage leaning_pair(double gap, double lean_deg) {
  const double lean = lean_deg * std::numbers::pi / 180, radius = 4;
  const StraightTube a{{15.2, 15.1, 25.5}, Vec3(std::sin(lean), 0, std::cos(lean)), radius},
      b{{15.2 + 2 * radius + gap, 15.1, 25.5}, Vec3(-std::sin(lean), 0, std::cos(lean)), radius};
  return fixtures::voxels_of(fixtures::frame_of({42, 31, 26}), {0, 1}, [&](const Vec3& p) {
    return p.z() > 4 && std::min(a.off(p), b.off(p)) < radius ? 1 : 0;
  });
}

double distance_of_ends(const Extended& e) {
  return (e.ends.at("inlet_1").centre_mm - e.ends.at("outlet_1").centre_mm).norm();
}

TEST(ExtendOpenings, KeepsNeighboursAsFarApartAsTheirOpeningsAre) {
  for (const double lean_deg : {0.0, 1.0, 2.0}) {
    const Extended e(leaning_pair(2.2, lean_deg), "10r");
    SCOPED_TRACE(lean_deg);
    ASSERT_EQ(e.openings.size(), 2U);
    ASSERT_EQ(e.ends.size(), 2U);
    EXPECT_TRUE(e.result.notes.empty()) << e.result.notes.front();
    EXPECT_NEAR(distance_of_ends(e), (e.openings[0].centre_mm - e.openings[1].centre_mm).norm(), 0.2);
    EXPECT_EQ(label_topology(e.result.image).at(0).component_count, 2U);
  }
}

TEST(ExtendOpenings, StopsBeforeNeighboursInItsPlaneComeTogether) {
  const Extended e(leaning_pair(4, 5), "10r");
  ASSERT_EQ(e.ends.size(), 2U);
  EXPECT_EQ(e.result.notes.size(), 2U);
  EXPECT_GT(distance_of_ends(e), 8 + 2);
  EXPECT_EQ(label_topology(e.result.image).at(0).component_count, 2U);
}

TEST(ExtendOpenings, StopsBeforeTheObject) {
  // The first is cut off in the middle, and would run into the second one.
  const StraightTube first{{0, 15.2, 14.6}, Vec3::UnitX(), 3}, second{{45, 15, 0}, Vec3::UnitZ(), 4};
  LabelImage image = fixtures::voxels_of(fixtures::frame_of({60, 30, 30}), {0, 1}, [&](const Vec3& p) {
    return (p.x() < 30 && first.off(p) < 3) || second.off(p) < 4 ? 1 : 0;
  });
  const CutVessel cut = cut_off_vessel(image, {{18, 15.2, 14.6}, Vec3::UnitX()}, 3);
  const Extended e(image, "10r,inlet_1=0,outlet_1=0", "", {cut.plane});
  ASSERT_EQ(e.result.notes.size(), 1U);
  double farthest = 0;
  for (const auto& [name, end] : e.ends)
    if (end.normal.x() > 0.9) farthest = std::max(farthest, end.centre_mm.x());
  EXPECT_GT(farthest, 25);
  EXPECT_LT(farthest, 41 - 3);  // One radius before the wall.
  EXPECT_EQ(label_topology(e.result.image).at(0).component_count, 2U);
}

/// Degrees between normals of the outer wall half a voxel before and behind the plane of an opening, mean
/// over the sides.
double crease_deg(const Domain& domain, const Opening& opening, const Vec3& direction) {
  constexpr int kSides = 24;
  const Vec3 u = direction.unitOrthogonal(), v = direction.cross(u);
  double sum = 0;
  for (int side = 0; side < kSides; ++side) {
    const double angle = 2 * std::numbers::pi * side / kSides;
    const Vec3 out = std::cos(angle) * u + std::sin(angle) * v;
    const auto wall_normal = [&](const Vec3& centre) {
      double inside = 0, outside = 12;
      for (int step = 0; step < 40; ++step) {
        const double middle = (inside + outside) / 2;
        (domain.separation_value(centre + middle * out, 1, 0) > 0 ? inside : outside) = middle;
      }
      return Vec3(domain.separation(centre + inside * out, 1, 0).gradient.normalized());
    };
    const Vec3 before = wall_normal(opening.centre_mm - 0.5 * opening.normal),
               behind = wall_normal(opening.centre_mm + 0.5 * opening.normal);
    sum += std::acos(std::min(1.0, before.dot(behind))) * 180 / std::numbers::pi / kSides;
  }
  return sum;
}

TEST(ExtendOpenings, GoesOnAlongWallsThatTaper) {
  const double slope = std::tan(7 * std::numbers::pi / 180);
  const StraightTube axis{{19.3, 18.2, 16}, Vec3(0.1, -0.05, 1).normalized(), 0};
  const Extended e(fixtures::voxels_of(fixtures::frame_of({40, 36, 32}), {0, 3},
                                       [&](const Vec3& p) {
                                         const double along = (p - axis.through).dot(axis.axis);
                                         return axis.off(p) < 7 - slope * along ? 1 : 0;
                                       }),
                   "3r");
  EXPECT_TRUE(e.result.notes.empty());
  ASSERT_EQ(e.openings.size(), 2U);
  for (const Opening& opening : e.openings) {
    const Opening& end = e.ends.at(opening.name);
    EXPECT_LT(crease_deg(*e.result.domain, opening, end.normal), 3) << opening.name;
    EXPECT_NEAR(end.area_mm2 / (opening.area_mm2 * end.normal.dot(opening.normal)), 1, 0.01) << opening.name;
  }
}

TEST(ExtendOpenings, GivesTheSameBitsForEveryThreadCount) {
  const StraightTube tube{{19.3, 18.2, 16}, Vec3(0.45, -0.2, 1).normalized(), 4};
  const Extended one = [&] {
    const parallel::ThreadLimit limit(1);
    return Extended(image_of(tube, 2), "3r", "2r");
  }();
  const parallel::ThreadLimit limit(3);
  const Extended three(image_of(tube, 2), "3r", "2r");
  EXPECT_EQ(one.result.image.voxels(), three.result.image.voxels());
  for (const Opening& o : one.openings)
    for (double s = 0.3; s < 12; s += 0.37) {
      const Vec3 x = o.centre_mm + s * o.normal + 0.1 * s * o.normal.unitOrthogonal();
      EXPECT_EQ(one.result.domain->separation_value(x, 1, 0), three.result.domain->separation_value(x, 1, 0));
      EXPECT_EQ(one.result.domain->separation_value(x, 2, 1), three.result.domain->separation_value(x, 2, 1));
    }
}

TEST(ExtendOpenings, RefusesOpeningsThatAreNot) {
  const StraightTube tube{{19.3, 18.2, 16}, Vec3::UnitZ(), 4};
  EXPECT_THROW(Extended(image_of(tube), "outlet_9=5r"), Error);
  for (const char* text : {"=3", "5x", "-3", "r", "inlet_1=", "5r,6r", "inf", "5r,"})
    EXPECT_THROW(static_cast<void>(named_lengths_from(text)), Error) << text;
}

}  // namespace
}  // namespace lumesh
