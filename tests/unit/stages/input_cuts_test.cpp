#include "lumesh/stages/input_cuts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fixtures/images.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/domain/vessel_cut.hpp"
#include "lumesh/stages/provenance.hpp"

namespace lumesh {
namespace {

constexpr double kThick = 6.1, kThin = 3.3;

/// A trunk along z, and an arm from its middle along x and z; whether the trunk leaves the image.
LabelImage fork(bool is_open) {
  return fixtures::voxels_of(fixtures::frame_of({70, 26, 70}), {0, 1}, [=](const Vec3& p) {
    const double across = p.y() - 12.7;
    const bool in_trunk = std::hypot(p.x() - 14.2, across) < kThick && (is_open || (p.z() > 3 && p.z() < 66));
    const Vec3 along = Vec3(1, 0, 0.3).normalized(), off = p - Vec3(14.2, 12.7, 30);
    const double t = off.dot(along);
    return in_trunk || (t > 0 && t < 45 && (off - t * along).norm() < kThin) ? 1 : 0;
  });
}

const Vec3 kInArm = Vec3(14.2, 12.7, 30) + 30 * Vec3(1, 0, 0.3).normalized();

std::size_t object_voxels(const LabelImage& image) {
  return static_cast<std::size_t>(
      std::count_if(image.voxels().begin(), image.voxels().end(), [](auto v) { return v != 0; }));
}

TEST(InputCuts, OneVesselIsCutSquareAndTheOthersStay) {
  Context context;
  LabelImage image = fork(true);
  const std::size_t before = object_voxels(image);
  // A whole plane there would meet nothing of the trunk; one square to the arm, beyond the trunk, does at z
  // > 66.
  ImageDomainOptions options;
  options.cut_planes = cut_off(image, {{}, {kInArm + Vec3(0, 1, 0)}}, context);
  const std::vector<Opening> openings = find_openings(ImageDomain(image, options));
  ASSERT_EQ(openings.size(), 3U);
  EXPECT_NEAR(openings[2].area_mm2, std::numbers::pi * kThin * kThin,
              0.03 * std::numbers::pi * kThin * kThin);
  EXPECT_GT(openings[2].normal.dot(Vec3(1, 0, 0.3).normalized()), 0.995);
  EXPECT_LT((openings[2].centre_mm - kInArm).norm(), 0.5);
  const auto gone = static_cast<double>(before - object_voxels(image));
  EXPECT_NEAR(gone, (15 - 5) * std::numbers::pi * kThin * kThin, 80) << "the part beyond, but for a stump";
}

/// A place in the trunk above the arm, whose plane meets the arm as well.
TEST(InputCuts, APlaneThatMeetsAnotherVesselLeavesItAlone) {
  Context context;
  LabelImage image = fork(true);
  ImageDomainOptions options;
  options.cut_planes = cut_off(image, {{}, {{14.2, 12.7, 42}}}, context);
  const ImageDomain domain(image, options);
  const Vec3 end_of_arm = Vec3(14.2, 12.7, 30) + 42 * Vec3(1, 0, 0.3).normalized();
  EXPECT_GT(end_of_arm.z(), 42);
  EXPECT_EQ(domain.label_at(end_of_arm), 1);
  EXPECT_EQ(domain.label_at({14.2, 12.7, 43}), 0);
  EXPECT_EQ(domain.label_at({14.2, 12.7, 60}), 0);
  EXPECT_EQ(domain.label_at({14.2, 12.7, 41}), 1);
  EXPECT_EQ(find_openings(domain).size(), 2U);
}

/// Voxel centres in the plane of the cut are no other vessel.
TEST(InputCuts, AStraightTubeIsCutAtTheCentresOfItsVoxels) {
  Context context;
  for (const double x : {20.0, 20.5, 20.03, 31.0}) {
    LabelImage tube = fixtures::voxels_of(fixtures::frame_of({60, 31, 31}), {0, 1}, [](const Vec3& p) {
      return std::hypot(p.y() - 15, p.z() - 15) < 6 ? 1 : 0;
    });
    ImageDomainOptions options;
    options.cut_planes = cut_off(tube, {{}, {{x, 15, 15}}}, context);
    const std::vector<Opening> openings = find_openings(ImageDomain(tube, options));
    ASSERT_EQ(openings.size(), 2U) << x;
    for (const Opening& o : openings) EXPECT_NEAR(o.area_mm2, std::numbers::pi * 36, 3) << x;
  }
}

/// A place says which vessel is meant, also in a smaller piece and beside a thicker one.
TEST(InputCuts, TheVesselThatThePlaceIsInIsCut) {
  Context context;
  const auto pair = [] {
    return fixtures::voxels_of(fixtures::frame_of({60, 44, 31}), {0, 1}, [](const Vec3& p) {
      const bool thick = std::hypot(p.y() - 13, p.z() - 15) < 8,
                 thin = std::hypot(p.y() - 32, p.z() - 15) < 3.2;
      return thick || (thin && p.x() > 4) ? 1 : 0;
    });
  };
  LabelImage image = pair();
  ImageDomainOptions options;
  options.cut_planes = cut_off(image, {{}, {{20, 32, 15}}}, context);
  const ImageDomain thin(image, options);
  EXPECT_EQ(thin.label_at({8, 32, 15}), 0);
  EXPECT_EQ(thin.label_at({40, 32, 15}), 1);
  EXPECT_EQ(thin.label_at({8, 13, 15}), 1);
  LabelImage other = pair();
  options.cut_planes = cut_off(other, {{}, {{20, 20, 15}}}, context);
  const ImageDomain thick(other, options);
  EXPECT_EQ(thick.label_at({8, 32, 15}), 1) << "near the thin one, but within the thick one";
  EXPECT_EQ(thick.label_at({8, 13, 15}), 0);
}

std::string refusal(LabelImage image, const std::vector<Vec3>& places) {
  Context context;
  try {
    static_cast<void>(cut_off(image, {{}, places}, context));
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    return error.what();
  }
  return "";
}

TEST(InputCuts, SectionsOfMoreThanOneVesselAreRefused) {
  std::string told;
  Context context({}, [&](std::string_view text) { told += text; });
  LabelImage forked = fork(true);
  static_cast<void>(cut_off(forked, {{}, {{14.2, 12.7, 33}}}, context));
  EXPECT_NE(told.find("look whether it forks"), std::string::npos) << told;
  const LabelImage sac = fixtures::voxels_of(fixtures::frame_of({60, 44, 44}), {0, 1}, [](const Vec3& p) {
    const bool tube = std::hypot(p.y() - 21.6, p.z() - 10.3) < 3;
    return tube || (p - Vec3(30.2, 21.6, 24)).norm() < 13 ? 1 : 0;
  });
  EXPECT_NE(refusal(sac, {{30, 21.6, 10}}).find("forks or bulges"), std::string::npos)
      << refusal(sac, {{30, 21.6, 10}});
  const LabelImage oblique = fixtures::voxels_of(fixtures::frame_of({50, 31, 50}), {0, 1}, [](const Vec3& p) {
    return std::hypot(p.y() - 15, (p.z() - p.x()) / std::sqrt(2)) < 5 ? 1 : 0;
  });
  EXPECT_NE(refusal(oblique, {{46, 15, 46}}).find("leaves the image"), std::string::npos);
  EXPECT_EQ(refusal(oblique, {{36, 15, 36}}), "");
  EXPECT_NE(refusal(oblique, {{36, 15, 36}, {38, 15, 38}}).find("is cut off already"), std::string::npos);
}

/// The legs of a U, two voxels apart: an opening would touch the other leg.
TEST(InputCuts, AVesselCloseBesideIsRefused) {
  const auto legs = [](double apart) {
    return fixtures::voxels_of(fixtures::frame_of({70, 44, 21}), {0, 1}, [=](const Vec3& p) {
      const double z = p.z() - 10.2, low = 10.3, high = low + apart, middle = 0.5 * (low + high);
      const bool in_legs = p.x() < 40 && (std::hypot(p.y() - low, z) < 5 || std::hypot(p.y() - high, z) < 5);
      const bool in_bend =
          p.x() >= 40 && std::hypot(std::hypot(p.x() - 40, p.y() - middle) - 0.5 * apart, z) < 5;
      return in_legs || in_bend ? 1 : 0;
    });
  };
  EXPECT_NE(refusal(legs(12.5), {{20, 10.3, 10.2}}).find("another one beside it"), std::string::npos);
  EXPECT_EQ(refusal(legs(18), {{20, 10.3, 10.2}}), "");
}

TEST(InputCuts, WhatCannotBeCutIsRefusedWithThePlace) {
  EXPECT_NE(refusal(fork(true), {{60, 3, 10}}).find("no vessel runs at (60.0, 3.0, 10.0) mm"),
            std::string::npos);
  LabelImage ring = fixtures::voxels_of(fixtures::frame_of({60, 60, 16}), {0, 1}, [](const Vec3& p) {
    return std::hypot(std::hypot(p.x() - 29.3, p.y() - 29.6) - 20, p.z() - 7.7) < 4 ? 1 : 0;
  });
  try {
    static_cast<void>(cut_off_vessel(ring, {{49.3, 29.6, 7.7}, {0, 1, 0}}, 4));
    FAIL() << "a ring cut once is one piece";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("part of a loop"), std::string::npos) << error.what();
  }
}

/// All tubes of the radius that go through (10, 18, z) along one of the axes in the plane of x and z; with
/// the flag, all meet at the upper border.
LabelImage tubes(const std::vector<double>& heights, double radius, bool do_meet) {
  return fixtures::voxels_of(fixtures::frame_of({60, 36, 72}), {0, 1}, [=](const Vec3& p) {
    for (const double z : heights) {
      const Vec3 start(0, 18, z),
          axis = do_meet ? Vec3(60, 0, 36 - z).normalized() : Vec3(1, 0, 0.3).normalized();
      const Vec3 off = p - start;
      if ((off - off.dot(axis) * axis).norm() < radius) return 1;
    }
    return 0;
  });
}

TEST(InputCuts, AreNotedInMeshesAndReadBackWhateverElseStandsThere) {
  MeshInfo info;
  const auto told_for = [&](const InputCuts& given) {
    const std::vector<std::string> doubts = doubts_about_cuts(given, "m", info);
    return doubts.empty() ? "" : doubts.front().substr(doubts.front().find("given: ") + 7);
  };
  InputCuts cuts;
  cuts.planes = {{{1, -2.5, 0.1}, {0, 0, 1}}, {{3, 0, 0}, {1, 0, 0}}};
  cuts.places_mm = {{30, 10.6, -4}};
  cuts.ends = local_length_from("1.50r");
  cuts.extension.lengths = named_lengths_from("5r, inlet_1=12.5");
  put_cuts(cuts, info.provenance);
  const std::string words = info.provenance.at("cuts");
  EXPECT_EQ(
      words,
      "--cut-plane 1 -2.5 0.1 0 0 1 --cut-plane 3 0 0 1 0 0 --cut-at 30,10.6,-4 --clip-ends 1.5r --extend "
      "5r,inlet_1=12.5");
  EXPECT_EQ(told_for({}), words);
  EXPECT_EQ(told_for(cuts), "");
  EXPECT_TRUE(was_extended(info));
  note_cuts(std::vector<CutPlane>{cuts.planes[1], {{7, 0, 0}, {1, 0, 0}}}, info.provenance);
  EXPECT_NE(told_for(cuts).find("--cut-plane 7 0 0 1 0 0"), std::string::npos);
  EXPECT_EQ(told_for(cuts).size(), words.size() + std::string(" --cut-plane 7 0 0 1 0 0").size());
  info.provenance = {
      {"options",
       "--labels 1,2 --cut-plane 1 2 3 0 0 1 4 5 6 0 0 1 7 --size 3 --cut-at x,1,2 --cut-at 1,2,3 "
       "--extend 2r --extend --clip-ends 5q --cut-at"}};
  EXPECT_EQ(told_for({}), "--cut-plane 1 2 3 0 0 1 --cut-plane 4 5 6 0 0 1 --cut-at 1,2,3 --extend 2r");
}

TEST(InputCuts, EndsOfEveryPieceAreClipped) {
  std::vector<std::string> warnings;
  Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
  LabelImage image = tubes({12, 40}, 5, false);
  const std::vector<CutPlane> planes = cut_off(image, {{}, {}, local_length_from("1r")}, context);
  EXPECT_EQ(planes.size(), 4U);
  EXPECT_TRUE(warnings.empty()) << warnings.front();
  for (const Opening& opening : find_openings(ImageDomain(image, {{}, planes})))
    EXPECT_GT(std::abs(opening.normal.dot(Vec3(1, 0, 0.3).normalized())), 0.99) << opening.name;
}

const Vec3 kFork(28, 22.3, 52);

/// A trunk along z and its two arms, which go apart by 30 degrees each, so many voxels before the border.
LabelImage fork_before_border(int voxels) {
  return fixtures::voxels_of(fixtures::frame_of({56, 44, 52 + voxels}), {0, 1}, [=](const Vec3& p) {
    const Vec3 off = p - kFork;
    const auto is_near = [&](const Vec3& along, double radius) {
      return (off - std::max(0.0, off.dot(along)) * along).norm() < radius;
    };
    return is_near({0, 0, -1}, 5) || is_near(Vec3(1, 0.1, std::sqrt(3)).normalized(), 4) ||
                   is_near(Vec3(-1, 0.1, std::sqrt(3)).normalized(), 3.75)
               ? 1
               : 0;
  });
}

TEST(InputCuts, EndsBehindAForkAreCutSquareOrStayAndAreTold) {
  for (const std::string length : {"0.5r", "1r", "5", "2r"}) {
    std::vector<std::string> warnings;
    Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
    LabelImage image = fork_before_border(8);
    const std::vector<CutPlane> planes = cut_off(image, {{}, {}, local_length_from(length)}, context);
    const bool is_clear = length == "2r";  // Two voxels below the fork.
    EXPECT_EQ(planes.size(), is_clear ? 2U : 1U) << length;
    EXPECT_EQ(warnings.size(), is_clear ? 0U : 1U) << length;
    for (const std::string& warning : warnings) {
      EXPECT_NE(warning.find("the end at (32.0, 22."), std::string::npos) << warning;
      EXPECT_NE(warning.find(" stays: "), std::string::npos) << warning;
    }
    for (const CutPlane& plane : planes)
      EXPECT_GT(std::abs(plane.normal.z()), std::cos(std::numbers::pi / 180)) << length;
  }
}

/// Angles between planes and the vessels that they cut.
struct Angles {
  void add(const CutPlane& plane, const Vec3& along) {
    squares += std::pow(std::acos(std::min(1.0, std::abs(plane.normal.dot(along)))), 2);
    ++count;
  }
  [[nodiscard]] double rms_deg() const { return std::sqrt(squares / count) * 180 / std::numbers::pi; }

  double squares = 0;
  int count = 0;
};

/// Straight tubes of 1.75 to 2.9 voxels in radius, that lean to all sides.
struct ThinTube {
  explicit ThinTube(int i)
      : along(std::sin(0.06 * i) * std::cos(2.4 * i), std::sin(0.06 * i) * std::sin(2.4 * i),
              std::cos(0.06 * i)),
        middle(21.3 + 0.05 * i, 19.7 - 0.03 * i, 21.5),
        image(fixtures::voxels_of(fixtures::frame_of({44, 40, 44}), {0, 1}, [&](const Vec3& p) {
          return (p - middle - (p - middle).dot(along) * along).norm() < 1.75 + 0.1 * i ? 1 : 0;
        })) {}

  Vec3 along, middle;
  LabelImage image;
};

TEST(InputCuts, EndsOfThinVesselsAreCutSquare) {
  Angles angles;
  for (int i = 0; i < 12; ++i) {
    ThinTube tube(i);
    Context context;
    for (const CutPlane& plane : cut_off(tube.image, {{}, {}, local_length_from("1r")}, context))
      angles.add(plane, tube.along);
  }
  EXPECT_EQ(angles.count, 24);
  EXPECT_LT(angles.rms_deg(), 1.2);
}

/// Arcs of 234 degrees, 1.5 voxels in radius, that bend to three radii and six: planes parallel to the one
/// before an end leave them, or run along them.
TEST(InputCuts, EndsOfThinVesselsThatBendStronglyAreCut) {
  Angles angles;
  int stay = 0;
  for (int i = 0; i < 12; ++i) {
    const double bend = i % 2 == 0 ? 4.5 : 9;
    const Vec3 middle(bend + 4.2 + 0.1 * i, 4.2 + 0.03 * i, 6.1 + 0.07 * i);
    LabelImage image = fixtures::voxels_of(fixtures::frame_of({32, 20, 13}), {0, 1}, [&](const Vec3& p) {
      constexpr double kPi = std::numbers::pi;
      const double angle =
          std::remainder(std::atan2(p.y() - middle.y(), p.x() - middle.x()) - kPi / 2, 2 * kPi);
      const double at = kPi / 2 + std::clamp(angle, -0.65 * kPi, 0.65 * kPi);
      return (p - middle - bend * Vec3(std::cos(at), std::sin(at), 0)).norm() < 1.5 ? 1 : 0;
    });
    std::vector<std::string> warnings;
    Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
    for (const CutPlane& plane : cut_off(image, {{}, {}, local_length_from("1r")}, context)) {
      const Vec3 off = plane.point_mm - middle;
      angles.add(plane, Vec3(-off.y(), off.x(), 0).normalized());
    }
    for (const std::string& warning : warnings) stay += warning.find(" stays: ") != std::string::npos ? 1 : 0;
  }
  EXPECT_LE(stay, 2);
  EXPECT_GE(angles.count, 21);
  EXPECT_LT(angles.rms_deg(), 6);
}

TEST(InputCuts, PlacesOnThinVesselsAreCutSquare) {
  Angles angles;
  for (int i = 0; i < 12; ++i)
    for (const double off_mm : {-6.0, 1.0, 8.0}) {
      ThinTube tube(i);
      Context context;
      for (const CutPlane& plane : cut_off(tube.image, {{}, {tube.middle + off_mm * tube.along}}, context))
        angles.add(plane, tube.along);
    }
  EXPECT_EQ(angles.count, 36);
  EXPECT_LT(angles.rms_deg(), 1.2);
}

/// The balls that fit into an oval vessel can lie to either side, and have a quarter of its section.
TEST(InputCuts, PlacesOnOvalVesselsThatBendAreCutSquare) {
  constexpr double kBend = 24, kThin = 3;
  for (const double ratio : {2.0, 4.0})
    for (const double degrees : {30.0, 45.0, 60.0}) {
      LabelImage image = fixtures::voxels_of(fixtures::frame_of({42, 36, 42}), {0, 1}, [&](const Vec3& p) {
        const double off = std::hypot(p.x(), p.z()) - kBend;
        return std::hypot(off, (p.y() - 17.3) / ratio) < kThin ? 1 : 0;
      });
      std::vector<std::string> warnings;
      Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
      const double angle = degrees * std::numbers::pi / 180;
      const Vec3 along(-std::sin(angle), 0, std::cos(angle)),
          place(kBend * std::cos(angle), 17.3, kBend * std::sin(angle));
      Angles off;
      for (const CutPlane& plane : cut_off(image, {{}, {place}}, context)) off.add(plane, along);
      EXPECT_EQ(off.count, 1) << ratio << ' ' << degrees;
      EXPECT_LT(off.rms_deg(), 1.5) << ratio << ' ' << degrees;
      EXPECT_TRUE(warnings.empty()) << warnings.front();
    }
}

TEST(InputCuts, APlaceWhereTheDirectionCannotBeToldIsCutAndTold) {
  std::vector<std::string> warnings;
  Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
  LabelImage image = fork_before_border(30);
  const Vec3 place = kFork + 8 * Vec3(1, 0.1, std::sqrt(3)).normalized();
  EXPECT_EQ(cut_off(image, {{}, {place}}, context).size(), 1U);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find(" may be oblique: "), std::string::npos) << warnings[0];
}

TEST(InputCuts, AnObliqueEndIsCutBehindItsOpening) {
  constexpr double kRadius = 5, kLean = 65 * std::numbers::pi / 180;
  const Vec3 middle(70.3, 9.6, 19.2), along(std::sin(kLean), 0, std::cos(kLean));
  const auto section_is_square = [&](const std::string& length, double error) {
    std::vector<std::string> warnings;
    Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
    LabelImage image = fixtures::voxels_of(fixtures::frame_of({140, 20, 40}), {0, 1}, [&](const Vec3& p) {
      const Vec3 off = p - middle;
      return (off - off.dot(along) * along).norm() < kRadius ? 1 : 0;
    });
    const std::vector<CutPlane> planes = cut_off(image, {{}, {}, local_length_from(length)}, context);
    EXPECT_EQ(planes.size(), 2U) << length;
    for (const Opening& opening : find_openings(ImageDomain(image, {{}, planes}))) {
      EXPECT_GT(std::abs(opening.normal.dot(along)), 0.999) << length << opening.name;
      EXPECT_NEAR(opening.area_mm2 / (std::numbers::pi * kRadius * kRadius), 1, error)
          << length << opening.name;
    }
    return warnings;
  };
  const std::vector<std::string> warnings = section_is_square("1r", 0.03);  // It begins at the border.
  ASSERT_EQ(warnings.size(), 2U);
  for (const std::string& warning : warnings)
    EXPECT_NE(warning.find("the vessel is cut off obliquely there"), std::string::npos) << warning;
  EXPECT_TRUE(section_is_square("4r", 0.015).empty());
}

TEST(InputCuts, EndsOfOvalVesselsAreClipped) {
  std::vector<std::string> warnings;
  Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
  LabelImage image = fixtures::voxels_of(fixtures::frame_of({40, 24, 60}), {0, 1}, [](const Vec3& p) {
    return std::hypot((p.x() - 20.2) / 11.5, (p.y() - 11.4) / 4.6) < 1 ? 1 : 0;
  });
  EXPECT_EQ(cut_off(image, {{}, {}, local_length_from("2r")}, context).size(), 2U);
  EXPECT_TRUE(warnings.empty()) << warnings.front();
}

TEST(InputCuts, AnEndThatTwoVesselsShareStaysAndIsTold) {
  std::vector<std::string> warnings;
  Context context({}, [&](std::string_view text) { warnings.emplace_back(text); });
  LabelImage image = tubes({6, 66}, 5, true);
  EXPECT_EQ(cut_off(image, {{}, {}, local_length_from("1r")}, context).size(), 2U);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("stays: no axis of a vessel ends there"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[0].find("(59.5, 18.0, "), std::string::npos) << warnings[0];
}

}  // namespace
}  // namespace lumesh
