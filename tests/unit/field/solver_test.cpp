// The parts of the fit against what mathematics says of them: quadrics cost nothing, operators are symmetric,
// B-splines sum up to one.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../src/field/band.hpp"
#include "../src/field/border_derivatives.hpp"
#include "../src/field/energy.hpp"
#include "../src/field/face_data.hpp"
#include "../src/field/fit_state.hpp"
#include "../src/field/multilevel.hpp"
#include "../src/field/simple_voxels.hpp"
#include "field_fixtures.hpp"

namespace lumesh::field {
namespace {

/// Values of a function at the band's voxels, `outside` elsewhere.
template <class Function>
LaneArray values_of(const Band& band, float outside, const Function& function) {
  LaneArray values(band.end(), outside);
  for (int s = 1; s < band.end(); ++s)
    for (int lane = 0; lane < kLanes; ++lane)
      if (Band::has(band.alive(s), lane))
        values.at(s)[lane] = static_cast<float>(function(band.voxel(s * kLanes + lane)));
  return values;
}

double product(const Band& band, const LaneArray& a, const LaneArray& b) {
  double sum = 0;
  for (int s = 1; s < band.end(); ++s)
    for (int lane = 0; lane < kLanes; ++lane)
      if (Band::has(band.alive(s), lane)) sum += static_cast<double>(a.at(s)[lane]) * b.at(s)[lane];
  return sum;
}

class FieldSolver : public ::testing::Test {
 protected:
  LabelImage image = oblique_tube(3.7, {1, 1, 1.4});
  std::vector<PairFaces> pairs = touching_pairs(image);
  Band band{image, pairs.front()};
  std::mt19937 random{7};

  LaneArray random_values(float outside) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    return values_of(band, outside, [&](const Index3& /*voxel*/) { return uniform(random); });
  }
};

TEST_F(FieldSolver, TheBandHoldsTheVoxelsNearTheOtherSideAndNoOthers) {
  const ImageFrame& frame = image.frame();
  const Vec3 edge(1, 1, 1.4);
  const LaneArray places = values_of(band, 0, [](const Index3&) { return 1; });
  std::size_t checked = 0;
  for (int k = 0; k < frame.size.z(); k += 2) {
    for (int j = 0; j < frame.size.y(); j += 2) {
      for (int i = 0; i < frame.size.x(); ++i) {
        const Index3 v(i, j, k);
        double least = 1e9;
        for (int n = 0; n < 9 * 9 * 7; ++n) {
          const Index3 w = v + Index3(n % 9 - 4, n / 9 % 9 - 4, n / 81 - 3);
          if (frame.contains(w) && image.at(w) != image.at(v))
            least = std::min(least, (w - v).cast<double>().cwiseProduct(edge).norm());
        }
        const bool is_near = least <= Band::kReach + 1e-6;
        ASSERT_EQ(band.value_at(places, v) > 0, is_near) << v.transpose();
        ++checked;
      }
    }
    if (k > 6) break;
  }
  EXPECT_GT(checked, 1000U);
}

TEST_F(FieldSolver, QuadricsCostNothingAndCubicsWhatTheirDerivativesSay) {
  Energy energy;
  energy.band = &band;
  energy.stiffness = values_of(band, 0, [](const Index3&) { return 1; });
  energy.faces = FaceWeights(band.entry_count());
  energy.differences = difference_weights(band.edges(), 1, 0);
  const Vec3 edges = band.edges();
  const auto at = [&](const Index3& v) { return Vec3(0.1 * v.cast<double>().cwiseProduct(edges)); };
  const LaneArray quadric = values_of(band, std::nanf(""), [&](const Index3& v) {
    const Vec3 x = at(v);
    return x.x() * x.x() - 2 * x.x() * x.y() + x.y() * x.z() + 0.5 * x.z() * x.z() - x.x() + 3;
  });
  LaneArray image_of(band.end());
  apply(energy, quadric, image_of);
  EXPECT_LT(std::abs(product(band, quadric, image_of)), 1e-6);
  // u = x y z has one third derivative, six times in the full tensor: 0.1^3 squared, on every cube of eight
  // voxels in the band.
  const LaneArray cubic = values_of(band, std::nanf(""), [&](const Index3& v) { return at(v).prod(); });
  LaneArray image_of_cubic(band.end());
  apply(energy, cubic, image_of_cubic);
  const LaneArray inside = values_of(band, 0, [](const Index3&) { return 1; });
  std::size_t cubes = 0;
  for (int s = 1; s < band.end(); ++s) {
    for (int lane = 0; lane < kLanes; ++lane) {
      if (!Band::has(band.alive(s), lane)) continue;
      bool whole = true;
      for (int c = 0; c < 8; ++c)
        whole &= band.value_at(inside, band.voxel(s * kLanes + lane) + Index3(c & 1, c >> 1 & 1, c >> 2)) > 0;
      cubes += static_cast<std::size_t>(whole);
    }
  }
  const double expected = static_cast<double>(cubes) * 6e-6 * edges.prod();
  EXPECT_NEAR(product(band, cubic, image_of_cubic), expected, 2e-3 * expected);
}

TEST_F(FieldSolver, NearTheBorderDerivativesAreThoseFurtherIn) {
  // u = x y z + x^3 / 6 has third differences xyz and xxx of 1e-3 times the edges, all others are 0.
  const LaneArray cubic = values_of(band, std::nanf(""), [&](const Index3& v) {
    const Vec3 x = 0.1 * v.cast<double>().cwiseProduct(band.edges());
    return x.prod() + x.x() * x.x() * x.x() / 6;
  });
  Energy energy;
  energy.band = &band;
  BorderDerivatives(band, energy.targets).update(cubic, energy);
  const DifferenceTargets& targets = energy.targets;
  ASSERT_EQ(targets.place.size(), band.segment_count());
  int whole = 0, fading = 0;
  for (int s = 1; s < band.end(); ++s) {
    const std::int32_t place = targets.place[static_cast<std::size_t>(s)];
    for (int lane = 0; place != 0 && lane < kLanes; ++lane) {
      if (!Band::has(band.alive(s), lane)) continue;
      const Index3 v = band.voxel(s * kLanes + lane);
      const auto target = [&](std::size_t row) { return 1e3F * targets.rows[row].at(place)[lane]; };
      EXPECT_NEAR(target(9), 1.4F * target(0), 0.01F) << v.transpose();
      for (const std::size_t other : {1, 2, 3, 4, 5, 6, 7, 8}) EXPECT_NEAR(target(other), 0, 0.01F);
      EXPECT_LT(target(0), 0.81F) << "not all of it, " << v.transpose();
      // Through these faces the tube leaves.
      if (v.x() <= 3 || v.x() >= image.frame().size.x() - 4) {
        EXPECT_GT(target(0), 0.78F) << v.transpose();
        ++whole;
      }
      fading += target(0) < 0.7F ? 1 : 0;
    }
  }
  EXPECT_GT(whole, 100);
  EXPECT_GT(fading, 100);
}

TEST_F(FieldSolver, NearTheBorderSecondDerivativesAreThoseFurtherIn) {
  // u = x^2 + x y has second differences xx and xy of 2e-2 and 1e-2 times the edges, all others are 0.
  const LaneArray quadric = values_of(band, std::nanf(""), [&](const Index3& v) {
    const Vec3 x = 0.1 * v.cast<double>().cwiseProduct(band.edges());
    return x.x() * (x.x() + x.y());
  });
  Energy energy;
  energy.band = &band;
  BorderDerivatives(band, energy.targets).update(quadric, energy);
  int whole = 0;
  for (int s = 1; s < band.end(); ++s) {
    const std::int32_t place = energy.targets.place[static_cast<std::size_t>(s)];
    for (int lane = 0; place != 0 && lane < kLanes; ++lane) {
      const Index3 v = band.voxel(s * kLanes + lane);
      if (!Band::has(band.alive(s), lane) || (v.x() > 3 && v.x() < image.frame().size.x() - 4)) continue;
      const auto target = [&](std::size_t row) { return 1e2 * energy.targets.rows[row].at(place)[lane]; };
      const Vec3& edges = band.edges();
      EXPECT_NEAR(target(10) / (2 * edges.x() * edges.x()), 0.8, 0.01) << v.transpose();
      EXPECT_NEAR(target(13) / (edges.x() * edges.y()), 0.8, 0.01) << v.transpose();
      for (const std::size_t other : {0, 1, 9, 11, 12, 14, 15}) EXPECT_NEAR(target(other), 0, 0.01);
      ++whole;
    }
  }
  EXPECT_GT(whole, 100);
}

TEST_F(FieldSolver, TheOperatorIsSymmetric) {
  FitState state(band);
  set_face_weights(state.values, state);
  const LaneArray x = random_values(std::nanf("")), y = random_values(std::nanf(""));
  LaneArray ax(band.end()), ay(band.end());
  apply(state.energy, x, ax);
  apply(state.energy, y, ay);
  EXPECT_NEAR(product(band, y, ax), product(band, x, ay), 1e-5 * product(band, x, ax));
}

TEST_F(FieldSolver, TheDiagonalOfTheDifferencesIsTheirOperators) {
  const FitState state(band);  // its faces weigh nothing yet
  LaneArray diagonal(band.end());
  add_difference_diagonal(state.energy, state.values, diagonal);
  for (int n = 0; n < 60; ++n) {
    const auto s = 1 + static_cast<int>(random() % static_cast<unsigned>(band.end() - 1));
    const auto lane = static_cast<int>(random() % kLanes);
    if (!Band::has(band.alive(s), lane)) continue;
    LaneArray unit = values_of(band, std::nanf(""), [](const Index3&) { return 0; });
    unit.at(s)[lane] = 1;
    LaneArray column(band.end());
    apply(state.energy, unit, column);
    EXPECT_NEAR(column.at(s)[lane], diagonal.at(s)[lane], 1e-4 * diagonal.at(s)[lane]) << s << " " << lane;
  }
}

TEST_F(FieldSolver, CoarseSplinesSumUpToOneAndRestrictionIsTheTransposeOfProlongation) {
  const SegmentGrid* fine = &band.grid();
  std::vector<Transfer> levels;
  levels.reserve(4);
  for (int level = 0; level < 4; ++level) {
    Transfer& transfer = levels.emplace_back(*fine);
    LaneArray ones(transfer.coarse().end(), 1);
    transfer.prolong(ones);
    for (int s = 1; s < fine->end(); ++s) {
      if (!fine->exists(s)) continue;
      const Lanes v = transfer.load_fine(s);
      for (int lane = 0; lane < kLanes; ++lane) ASSERT_NEAR(v[lane], 1, 1e-5) << level << " " << s;
    }
    std::uniform_real_distribution<float> uniform(-1, 1);
    LaneArray a(fine->end()), b(transfer.coarse().end()), restricted(transfer.coarse().end());
    for (int s = 1; s < fine->end(); ++s)
      for (int lane = 0; lane < kLanes; ++lane) a.at(s)[lane] = fine->exists(s) ? uniform(random) : 0;
    for (int s = 1; s < transfer.coarse().end(); ++s)
      for (int lane = 0; lane < kLanes; ++lane) b.at(s)[lane] = uniform(random);
    transfer.restrict_to_coarse(a, restricted);
    double down = 0, up = 0;
    for (int s = 1; s < transfer.coarse().end(); ++s)
      for (int lane = 0; lane < kLanes; ++lane)
        down += static_cast<double>(restricted.at(s)[lane]) * b.at(s)[lane];
    transfer.prolong(b);
    for (int s = 1; s < fine->end(); ++s) {
      if (!fine->exists(s)) continue;
      const Lanes v = transfer.load_fine(s);
      for (int lane = 0; lane < kLanes; ++lane) up += static_cast<double>(v[lane]) * a.at(s)[lane];
    }
    EXPECT_NEAR(down, up, 1e-3) << level;
    fine = &transfer.coarse();
  }
}

TEST(SimpleVoxels, EndsAndFacesMayGoButBridgesAndPlugsAreNeeded) {
  LabelImage image(frame_of({7, 7, 7}, Vec3::Ones()), {0, 1});
  for (int i = 1; i < 6; ++i) image.at({i, 3, 3}) = 1;
  EXPECT_EQ(role_of(image, {1, 3, 3}), VoxelRole::kSimple) << "the end of a line";
  EXPECT_EQ(role_of(image, {3, 3, 3}), VoxelRole::kNeeded) << "its middle";
  image.at({3, 5, 5}) = 1;
  EXPECT_EQ(role_of(image, {3, 5, 5}), VoxelRole::kAlone);
  EXPECT_EQ(role_of(image, {3, 4, 3}), VoxelRole::kSimple) << "background beside the line";
  // A ring of eight voxels: its hole is background that is needed.
  LabelImage ring(frame_of({7, 7, 7}, Vec3::Ones()), {0, 1});
  for (int j = 2; j < 5; ++j)
    for (int i = 2; i < 5; ++i) ring.at({i, j, 3}) = static_cast<LabelImage::Index>(i != 3 || j != 3);
  EXPECT_EQ(role_of(ring, {3, 3, 3}), VoxelRole::kNeeded);
  EXPECT_EQ(role_of(ring, {2, 2, 3}), VoxelRole::kNeeded) << "a corner of the ring";
}

}  // namespace
}  // namespace lumesh::field
