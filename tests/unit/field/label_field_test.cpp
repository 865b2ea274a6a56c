// The zero sets against the shapes that the voxels were made of, and what fields tell at places.
#include "lumesh/field/label_field.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "field_fixtures.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/parallel/loops.hpp"
#include "wall_fixtures.hpp"

namespace lumesh {
namespace {

/// R.m.s. figures over random places of a tube's axis.
WallFigures walls_of_tubes(double radius, const Vec3& direction) {
  constexpr int kPlaces = 6;
  const ImageFrame frame = frame_of({64, 48, 44}, Vec3::Ones());
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  WallFigures squares;
  for (int place = 0; place < kPlaces; ++place) {
    TubeAxis axis = axis_through_middle(frame, direction);
    axis.point += Vec3(uniform(random), uniform(random), uniform(random));
    const WallFigures w = wall_of(LabelField(tube(frame, axis, radius), {}), axis, radius, 14);
    squares.mean += w.mean * w.mean / kPlaces;
    squares.roughness += w.roughness * w.roughness / kPlaces;
    squares.normal_deg += w.normal_deg * w.normal_deg / kPlaces;
  }
  return {std::sqrt(squares.mean), std::sqrt(squares.roughness), std::sqrt(squares.normal_deg)};
}

TEST(LabelField, WallsOfTubesAreSmoothAndInPlace) {
  struct Case {
    double radius;
    Vec3 direction;
    double roughness, normal_deg, mean;
  };
  // A low-pass of the same voxels has 0.04 to 0.12 voxels, 2 to 6.5 degrees, and takes 2 to 10 % from the
  // radius.
  const std::array<Case, 4> cases = {{{2, {1, 0.82, 0.64}, 0.02, 0.8, 0.02},
                                      {3, {1, 0.05, 0.03}, 0.035, 0.7, 0.01},
                                      {5, {1, 0.82, 0.64}, 0.02, 0.3, 0.01},
                                      {8, {1, 0.035, 0.02}, 0.035, 0.4, 0.02}}};
  for (const Case& c : cases) {
    const WallFigures w = walls_of_tubes(c.radius, c.direction);
    EXPECT_LT(w.roughness, c.roughness) << c.radius;
    EXPECT_LT(w.normal_deg, c.normal_deg) << c.radius;
    EXPECT_LT(w.mean, c.mean) << c.radius;
  }
}

TEST(LabelField, LongVoxelsCountWithTheirLengths) {
  const ImageFrame frame = frame_of({60, 50, 30}, {0.5, 0.5, 1});
  const TubeAxis axis = axis_through_middle(frame, {1, 0.3, 0.2});
  const LabelField field(tube(frame, axis, 3), {});
  const WallFigures w = wall_of(field, axis, 3, 8);
  EXPECT_LT(w.roughness, 0.05);
  EXPECT_LT(w.normal_deg, 2.5);
  EXPECT_LT(std::abs(w.mean), 0.03);
}

TEST(LabelField, DirectionsOfTheGridAreAllTheSame) {
  // The same tubes with their axes exchanged: rows of voxels along x are nothing special.
  const Vec3 direction = Vec3(1, 0.2, 0.1).normalized();
  constexpr int kPlaces = 8;
  std::array<double, 3> roughness = {};
  for (int place = 0; place < kPlaces; ++place) {
    const Vec3 middle = Vec3(19.3, 19.6, 19.1) + Vec3(0.17, 0.29, 0.41) * place;
    for (int turn = 0; turn < 3; ++turn) {
      const auto turned = [&](const Vec3& v) { return Vec3(v[turn], v[(turn + 1) % 3], v[(turn + 2) % 3]); };
      const ImageFrame frame = frame_of({40, 40, 40}, Vec3::Ones());
      const TubeAxis axis{turned(middle), turned(direction)};
      const LabelField field(tube(frame, axis, 4), {});
      roughness[static_cast<std::size_t>(turn)] += wall_of(field, axis, 4, 12).roughness / kPlaces;
    }
  }
  EXPECT_NEAR(roughness[0], roughness[1], 0.3 * roughness[0]);
  EXPECT_NEAR(roughness[0], roughness[2], 0.3 * roughness[0]);
}

TEST(LabelField, LabelsOfOneTubeShareItsWallWithoutAGroove) {
  const ImageFrame frame = frame_of({50, 32, 32}, Vec3::Ones());
  const TubeAxis axis = axis_through_middle(frame, {1, 0.12, 0.08});
  const Vec3 cut = Vec3(1, 0.2, 0.1).normalized();
  const LabelImage image = image_of(frame, 2, [&](const Vec3& p) {
    return axis.distance(p) >= 5 ? 0 : cut.dot(p - axis.point) > 0 ? 1 : 2;
  });
  const LabelField field(image, {});
  const Vec3 a = axis.direction.cross(Vec3::UnitZ()).normalized(), b = axis.direction.cross(a);
  for (double t = -4; t <= 4; t += 0.25) {
    for (int n = 0; n < 40; ++n) {
      const Vec3 out = std::cos(n * 0.157) * a + std::sin(n * 0.157) * b;
      EXPECT_NE(field.label_at(axis.point + t * axis.direction + 4.85 * out), 0);
      EXPECT_EQ(field.label_at(axis.point + t * axis.direction + 5.15 * out), 0);
    }
  }
  // Their common boundary is the plane.
  for (int n = 0; n < 40; ++n) {
    const Vec3 p = axis.point + 3 * std::cos(n * 0.157) * a + 3 * std::sin(n * 0.157) * b;
    EXPECT_EQ(field.label_at(p + (0.25 - cut.dot(p - axis.point)) * cut), 1);
    EXPECT_EQ(field.label_at(p - (0.25 + cut.dot(p - axis.point)) * cut), 2);
  }
}

TEST(LabelField, GradientsAreThoseOfFiniteDifferences) {
  const LabelField field(oblique_tube(4, {1, 0.8, 1.1}), {});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  constexpr double kStep = 2e-3;
  for (int n = 0; n < 500; ++n) {
    const Vec3 x(33 * uniform(random), 29 * uniform(random), 23 * uniform(random));
    const FieldSample s = field.difference(x, 1, 0);
    if (std::abs(s.value) > 1.5) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 step = kStep * Vec3::Unit(axis);
      const double slope =
          (field.difference_value(x + step, 1, 0) - field.difference_value(x - step, 1, 0)) / (2 * kStep);
      EXPECT_NEAR(s.gradient[axis], slope, 4e-3);
    }
    EXPECT_EQ(s.value > 0, field.label_at(x) == 1);
  }
}

TEST(LabelField, DepthNeverReachesPastTheBoundary) {
  const ImageFrame frame = frame_of({40, 40, 40}, Vec3::Ones());
  const Vec3 centre(19.7, 19.4, 20.1);
  const LabelField field(image_of(frame, 1, [&](const Vec3& p) { return (p - centre).norm() < 6 ? 1 : 0; }),
                         {});
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 2000; ++n) {
    const Vec3 out = Vec3(normal(random), normal(random), normal(random)).normalized();
    const double r = 1 + 0.005 * n;
    EXPECT_LT(field.winner(centre + r * out).depth, std::abs(r - 6) + 0.06) << r;
  }
}

TEST(LabelField, TheSameBitsForEveryNumberOfThreads) {
  const ImageFrame frame = frame_of({50, 40, 64}, Vec3::Ones());
  const LabelImage image = image_of(frame, 3, [](const Vec3& p) {
    const double r = (p - Vec3(25, 20, p.z())).norm() + 2 * std::sin(0.2 * p.z());
    return r > 9 ? 0 : p.z() < 20 ? 1 : p.z() < 45 ? 2 : 3;
  });
  std::vector<double> expected;
  for (const int threads : {1, 2, 5, 16}) {
    const parallel::ThreadLimit limit(threads);
    const LabelField field(image, {});
    std::vector<double> values;
    std::mt19937 random(2);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int n = 0; n < 4000; ++n) {
      const Vec3 x(49 * uniform(random), 39 * uniform(random), 63 * uniform(random));
      for (const LabelImage::Index label : {0, 1, 2, 3}) values.push_back(field.value(x, label));
    }
    if (expected.empty()) expected = values;
    EXPECT_EQ(std::memcmp(values.data(), expected.data(), values.size() * sizeof(double)), 0) << threads;
  }
}

TEST(LabelField, OddImagesAreNoProblem) {
  for (const Index3& size : {Index3(1, 1, 1), Index3(1, 30, 20), Index3(40, 1, 1), Index3(9, 9, 9)}) {
    for (const int labels : {0, 1, 2}) {
      const LabelImage image = image_of(frame_of(size, {1, 1, 100}), 2, [&](const Vec3& p) {
        return labels == 0 ? 0 : labels == 1 ? 1 : static_cast<int>(p.x() + p.y()) % 3;
      });
      const LabelField field(image, {});
      const Vec3 middle = 0.5 * (size - Index3::Ones()).cast<double>();
      if (labels < 2) {
        EXPECT_EQ(field.label_at(middle), labels);
      }
      EXPECT_LE(field.label_at(middle), 2);
      EXPECT_TRUE(std::isfinite(field.value({-7, 1e6, 3}, 1)));
    }
  }
}

TEST(LabelField, LabelsThatTouchAtAnEdgeOnlyMeetInItsMiddle) {
  // Two blocks that share one edge, along z at x = y = 7.5, and no face: nothing but nearness tells them
  // apart there.
  const LabelImage image = image_of(frame_of({16, 16, 12}, Vec3::Ones()), 2, [](const Vec3& p) {
    if ((p.array() < 2).any() || (p.array() > Vec3(13, 13, 9).array()).any()) return 0;
    return p.x() < 7.5 && p.y() < 7.5 ? 1 : p.x() > 7.5 && p.y() > 7.5 ? 2 : 0;
  });
  const LabelField field(image, {});
  for (const double t : {0.1, 0.3, 0.45}) {
    const Vec3 middle(7.5, 7.5, 6), out = t * Vec3(1, 1, 0);
    EXPECT_EQ(field.object_label_at(middle - out), 1) << t;
    EXPECT_EQ(field.object_label_at(middle + out), 2) << t;
    EXPECT_GT(field.difference_value(middle - out, 1, 2), 0) << t;
    EXPECT_LT(field.difference_value(middle + out, 1, 2), 0) << t;
  }
}

TEST(LabelField, NoiseIsRefusedWithWhatItIsAndCheckerboardsAreNot) {
  std::mt19937 random(5);
  const auto noise = [&](int edge, int labels) {
    return image_of(frame_of(Index3::Constant(edge), Vec3::Ones()), labels, [&](const Vec3&) {
      return 1 + static_cast<int>(random() % static_cast<unsigned>(labels));
    });
  };
  const auto refusal = [](const LabelImage& image) -> std::string {
    try {
      const LabelField field(image, {});
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refusal(noise(24, 20)).find("touch no other voxel of their label"), std::string::npos);
  EXPECT_NE(refusal(noise(64, 1000)).find("pairs of labels touch"), std::string::npos);
  // 64,000 labels of one voxel each, none of which touch.
  const LabelImage dust = image_of(frame_of(Index3::Constant(81), Vec3::Ones()), 64000, [](const Vec3& p) {
    const Index3 v = p.cast<int>();
    const bool is_odd = v.x() % 2 == 1 && v.y() % 2 == 1 && v.z() % 2 == 1;
    return is_odd ? 1 + v.x() / 2 + 40 * (v.y() / 2 + 40 * (v.z() / 2)) : 0;
  });
  EXPECT_NE(refusal(dust).find("touch no other voxel of their label"), std::string::npos);
  const LabelImage board = image_of(frame_of(Index3::Constant(16), Vec3::Ones()), 3, [](const Vec3& p) {
    return 1 + static_cast<int>(std::lround(p.sum())) % 3;
  });
  EXPECT_EQ(refusal(board), "");
}

}  // namespace
}  // namespace lumesh
