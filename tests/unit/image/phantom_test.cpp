// Phantoms against closed forms, against their own raster, and against bad specs.
#include "lumesh/image/phantom.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "lumesh/core/error.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

using std::numbers::pi;

PhantomSpec spec_of(PhantomKind kind) {
  PhantomSpec spec;
  spec.kind = kind;
  return spec;
}

/// A carotid of half the default resolution: the same shape, an eighth of the voxels.
PhantomSpec half_carotid() {
  PhantomSpec spec = spec_of(PhantomKind::kCarotid);
  spec.size = {256, 256, 254};
  spec.spacing_mm.setConstant(2);
  return spec;
}

std::vector<PhantomSpec> all_specs() {
  return {half_carotid(), spec_of(PhantomKind::kBifurcation), spec_of(PhantomKind::kLayered),
          spec_of(PhantomKind::kSphere), spec_of(PhantomKind::kTorus)};
}

class RandomPoints {
 public:
  RandomPoints(const ImageFrame& frame, std::uint32_t seed) : frame_(frame), random_(seed) {}
  Vec3 next() {
    std::uniform_real_distribution<double> unit(0, 1);
    const Vec3 index =
        Vec3(unit(random_), unit(random_), unit(random_)).cwiseProduct(frame_.size.cast<double>());
    return frame_.to_physical(index - Vec3::Constant(0.5));
  }

 private:
  ImageFrame frame_;
  std::mt19937 random_;
};

TEST(Phantom, SphereHasTheDistanceAndVolumeOfASphere) {
  PhantomSpec spec = spec_of(PhantomKind::kSphere);
  spec.rotation_deg = {20, -30, 65};
  spec.origin_mm = {-100, 40, 7};
  const Phantom phantom(spec);
  const Vec3 centre = phantom.frame().to_physical(Vec3::Constant(31.5));
  RandomPoints points(phantom.frame(), 3);
  for (int n = 0; n < 200; ++n) {
    const Vec3 p = points.next();
    EXPECT_NEAR(phantom.signed_distance_mm(p, 1), (p - centre).norm() - 20, 1e-9);
    EXPECT_NEAR(phantom.surface_distance_mm(p, 1) < 4 ? phantom.surface_distance_mm(p, 1) : 0,
                phantom.surface_distance_mm(p, 1) < 4 ? std::abs((p - centre).norm() - 20) : 0, 1e-9);
  }
  EXPECT_NEAR(phantom.volume_mm3(1), 33510.3216, 1e-3);
  EXPECT_NEAR(label_topology(phantom.rasterise()).at(0).volume_mm3, 33510.3, 0.003 * 33510.3);
}

TEST(Phantom, TorusDistanceIsThatToItsCoreCircleMinusTheTube) {
  const Phantom phantom(spec_of(PhantomKind::kTorus));
  const Vec3 centre(47.5, 47.5, 23.5);
  RandomPoints points(phantom.frame(), 4);
  for (int n = 0; n < 50; ++n) {
    const Vec3 p = points.next();
    double nearest = 1e9;  // by search along the circle
    for (int i = 0; i < 20000; ++i) {
      const double turn = 2 * pi * i / 20000;
      nearest = std::min(nearest, (p - centre - 28 * Vec3(std::cos(turn), std::sin(turn), 0)).norm());
    }
    EXPECT_NEAR(phantom.signed_distance_mm(p, 1), nearest - 11, 1e-5);
  }
  EXPECT_NEAR(phantom.volume_mm3(1), 2 * pi * pi * 28 * 121, 1e-6);
}

TEST(Phantom, LineIntegralsFindTheVolumeOfASphere) {
  PhantomSpec spec = spec_of(PhantomKind::kSphere);
  spec.noise_voxels = 1e-12;  // too little to move anything, enough to take the numeric way
  EXPECT_NEAR(Phantom(spec).volume_mm3(1), 33510.3216, 1e-4 * 33510);
  spec.spacing_mm = {0.5, 1.5, 1};
  spec.size = {100, 40, 50};
  spec.radius_mm = 18.25;  // 36.5 x 12.2 x 18.25 voxels
  EXPECT_NEAR(Phantom(spec).volume_mm3(1), 4.0 / 3 * pi * std::pow(18.25, 3), 3e-4 * 25461);
}

TEST(Phantom, RasterHasTheTopologyAndVolumeOfTheTruth) {
  for (const PhantomSpec& spec : all_specs()) {
    SCOPED_TRACE(phantom_kind_name(spec.kind));
    const Phantom phantom(spec);
    const std::vector<LabelTopology> found = label_topology(phantom.rasterise());
    ASSERT_EQ(found.size(), phantom.labels().size());
    for (const LabelTopology& label : found) {
      EXPECT_EQ(label.component_count, static_cast<std::size_t>(phantom.truth(label.label).component_count));
      EXPECT_EQ(label.euler_number, phantom.truth(label.label).euler_number);
      EXPECT_NEAR(label.volume_mm3 / phantom.volume_mm3(label.label), 1, 0.01) << "label " << label.label;
    }
  }
}

TEST(Phantom, NoiseMovesTheBoundaryButNotTheTopology) {
  for (PhantomSpec spec : all_specs()) {
    SCOPED_TRACE(phantom_kind_name(spec.kind));
    const Phantom smooth(spec);
    spec.noise_voxels = spec.kind == PhantomKind::kLayered ? 0.3 : 0.5;
    spec.seed = 9;
    const Phantom rough(spec);
    const LabelImage image = rough.rasterise();
    EXPECT_NE(image.voxels(), smooth.rasterise().voxels());
    for (const LabelTopology& label : label_topology(image)) {
      EXPECT_EQ(label.component_count, static_cast<std::size_t>(rough.truth(label.label).component_count));
      EXPECT_EQ(label.euler_number, rough.truth(label.label).euler_number) << "label " << label.label;
    }
    RandomPoints points(rough.frame(), 6);
    for (int n = 0; n < 500; ++n) {
      const Vec3 p = points.next();
      EXPECT_LE(std::abs(rough.signed_distance_mm(p, 1) - smooth.signed_distance_mm(p, 1)),
                spec.noise_voxels * rough.spec().spacing_mm.maxCoeff() + 1e-12);
    }
  }
}

TEST(Phantom, DistancesAreLipschitzAndAgreeWithTheLabels) {
  for (PhantomSpec spec : all_specs()) {
    SCOPED_TRACE(phantom_kind_name(spec.kind));
    spec.rotation_deg = {10, 20, 30};
    const Phantom phantom(spec);
    RandomPoints points(phantom.frame(), 7);
    Vec3 before = points.next();
    for (int n = 0; n < 2000; ++n) {
      const Vec3 p = points.next();
      for (const Label label : phantom.labels()) {
        const double distance = phantom.signed_distance_mm(p, label);
        EXPECT_EQ(distance < 0, phantom.label_at(p) == label);
        EXPECT_LE(std::abs(distance - phantom.signed_distance_mm(before, label)), (p - before).norm() + 1e-9);
        EXPECT_LE(phantom.surface_distance_mm(p, label),
                  std::abs(distance) + 1e-9);  // points lie in the image
      }
      before = p;
    }
  }
}

TEST(Phantom, EveryVoxelOfTheRasterHasTheLabelAtItsCentre) {
  PhantomSpec spec = spec_of(PhantomKind::kBifurcation);
  spec.rotation_deg = {40, 0, 200};
  const Phantom phantom(spec);
  const LabelImage image = phantom.rasterise();
  std::mt19937 random(8);
  std::size_t inside = 0;
  for (int n = 0; n < 20000; ++n) {
    const Index3 v(static_cast<int>(random() % 176), static_cast<int>(48 + random() % 32),
                   static_cast<int>(random() % 104));
    ASSERT_EQ(image.label_at(v), phantom.label_at(image.frame().to_physical(v.cast<double>())))
        << v.transpose();
    inside += image.at(v);
  }
  EXPECT_GT(inside, 1000U);
}

/// Radius of the opening around a point where a vessel leaves the image, from the voxels of the border's
/// face.
double opening_radius(const LabelImage& image, const Vec3& exit_index) {
  Index3 v = exit_index.array().round().cast<int>();
  v = v.cwiseMax(0).cwiseMin(image.frame().size - Index3::Ones());
  int axis = 0;
  ((exit_index + Vec3::Constant(0.5))
       .cwiseMin(image.frame().size.cast<double>() - exit_index - Vec3::Constant(0.5)))
      .minCoeff(&axis);
  double count = 0;
  for (int a = -40; a <= 40; ++a)
    for (int b = -40; b <= 40; ++b) {
      Index3 w = v;
      w[(axis + 1) % 3] += a;
      w[(axis + 2) % 3] += b;
      if (image.frame().contains(w)) count += image.at(w);
    }
  return std::sqrt(count / pi);
}

TEST(Phantom, VesselsLeaveTheImageSquarelyWithTheRadiusOfTheirCenterline) {
  for (const PhantomSpec& spec : {half_carotid(), spec_of(PhantomKind::kBifurcation)}) {
    SCOPED_TRACE(phantom_kind_name(spec.kind));
    const Phantom phantom(spec);
    const LabelImage image = phantom.rasterise();
    const double voxel = phantom.spec().spacing_mm.x();
    const std::vector<PhantomCurve> curves = phantom.centerline();
    EXPECT_EQ(curves.size(), spec.kind == PhantomKind::kCarotid ? 4U : 3U);
    for (const PhantomCurve& curve : curves) {
      const bool parent = curve.branch == 0;
      const Vec3 exit = parent ? curve.points_mm.front() : curve.points_mm.back();
      const Vec3 inner = parent ? curve.points_mm[2] : curve.points_mm[curve.points_mm.size() - 3];
      EXPECT_GT((exit - inner).normalized().cwiseAbs().maxCoeff(), 0.9999) << "branch " << curve.branch;
      EXPECT_NEAR(phantom.surface_distance_mm(exit, 1), 0, 1e-6);
      const double radius = parent ? curve.radius_mm.front() : curve.radius_mm.back();
      EXPECT_NEAR(opening_radius(image, image.frame().to_index(exit)) * voxel, radius, 0.15 * voxel);
      for (std::size_t i = 0; i < curve.points_mm.size(); ++i)  // the ball of that radius fits the vessel
        EXPECT_LE(phantom.signed_distance_mm(curve.points_mm[i], 1), -curve.radius_mm[i] + 1e-3 * voxel);
    }
  }
}

TEST(Phantom, CarotidHasItsRadiiAndSac) {
  const Phantom phantom(spec_of(PhantomKind::kCarotid));
  EXPECT_EQ(phantom.frame().size, Index3(512, 512, 508));
  const std::vector<PhantomCurve> curves = phantom.centerline();
  EXPECT_NEAR(curves.front().radius_mm.front(), 14, 0.01);
  EXPECT_NEAR(curves.back().radius_mm.back(), 4, 0.01);
  double deepest = 0;
  std::mt19937 random(12);
  for (int n = 0; n < 20000; ++n) {  // around the sac's centre
    const Vec3 p(255 + 0.001 * (random() % 50000), 165 + 0.001 * (random() % 50000),
                 180 + 0.001 * (random() % 50000));
    deepest = std::max(deepest, -phantom.signed_distance_mm(p, 1));
  }
  EXPECT_NEAR(deepest, 35, 2);
  EXPECT_LE(deepest, 35);
}

TEST(Phantom, CapsAreFlatAtTheOuterFacesOfTheImage) {
  const Phantom phantom(spec_of(PhantomKind::kCarotid));
  const Vec3 inlet = phantom.centerline().front().points_mm.front();
  EXPECT_NEAR(inlet.z(), -0.5, 1e-9);
  EXPECT_NEAR(phantom.surface_distance_mm(inlet + Vec3(3, 0, 1.25), 1), 1.25, 1e-9);  // inside, near the cap
  EXPECT_NEAR(phantom.surface_distance_mm(inlet + Vec3(3, 0, -2), 1), 2, 1e-9);       // beyond the cap
  EXPECT_NEAR(phantom.surface_distance_mm(inlet + Vec3(14 + 3, 0, -4), 1), 5,
              0.01);  // beside the rim: 3, 4, 5
  EXPECT_NEAR(phantom.surface_distance_mm(inlet + Vec3(0, 14 + 3, 10), 1), 3,
              0.1);  // beside the wall, which tapers
}

TEST(Phantom, StreamlinesStayInsideAndCarryTheInletsFlow) {
  for (const PhantomSpec& spec : {half_carotid(), spec_of(PhantomKind::kBifurcation)}) {
    const Phantom phantom(spec);
    const std::vector<PhantomStreamline> lines = phantom.velocity_streamlines();
    ASSERT_GT(lines.size(), 20U);
    for (const PhantomStreamline& line : lines) {
      ASSERT_EQ(line.points_mm.size(), line.velocity_m_s.size());
      for (std::size_t i = 0; i < line.points_mm.size(); ++i) {
        ASSERT_LT(phantom.signed_distance_mm(line.points_mm[i], 1), 0);
        ASSERT_LT(line.velocity_m_s[i].norm(), 3);
      }
    }
    EXPECT_NEAR(lines.front().velocity_m_s.front().norm(), 0.5, 1e-6);  // twice the mean speed on the axis
  }
}

TEST(Phantom, RasterIsTheSameForEveryNumberOfThreads) {
  const Phantom phantom(spec_of(PhantomKind::kBifurcation));
  const auto with_threads = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    return std::pair(phantom.rasterise().voxels(), phantom.volume_mm3(1));
  };
  EXPECT_EQ(with_threads(1), with_threads(3));
}

TEST(PhantomSpec, SurvivesJsonUnchanged) {
  PhantomSpec spec = half_carotid();
  spec.spacing_mm = {1.0 / 3, 0.7, 2};
  spec.radius_mm = 3.3;
  spec.end_radius_mm = 2.2;
  spec.sac_radius_mm = 9.1;
  spec.ring_radius_mm = 1;
  spec.wall_mm = 0.4;
  spec.noise_voxels = 0.1;
  spec.seed = 4000000000U;
  spec.rotation_deg = {1, 2, 3};
  spec.origin_mm = {-1e3, 0, 0.1};
  const PhantomSpec back = phantom_spec_from_json(to_json_text(spec));
  EXPECT_EQ(back.kind, spec.kind);
  EXPECT_EQ(back.size, spec.size);
  EXPECT_EQ(back.spacing_mm, spec.spacing_mm);
  EXPECT_EQ(back.radius_mm, spec.radius_mm);
  EXPECT_EQ(back.end_radius_mm, spec.end_radius_mm);
  EXPECT_EQ(back.sac_radius_mm, spec.sac_radius_mm);
  EXPECT_EQ(back.ring_radius_mm, spec.ring_radius_mm);
  EXPECT_EQ(back.wall_mm, spec.wall_mm);
  EXPECT_EQ(back.noise_voxels, spec.noise_voxels);
  EXPECT_EQ(back.seed, spec.seed);
  EXPECT_EQ(back.rotation_deg, spec.rotation_deg);
  EXPECT_EQ(back.origin_mm, spec.origin_mm);
}

TEST(PhantomSpec, BadTextIsRefusedWithTheFieldsName) {
  for (const char* text : {"", "[1]", "{}", R"({"kind": "cube"})", R"({"kind": "sphere", "radius": 3})",
                           R"({"kind": "sphere", "size": [1, 2]})", R"({"kind": "sphere", "seed": "x"})",
                           R"({"kind": "sphere", "lumesh_phantom": 99})"}) {
    try {
      (void)phantom_spec_from_json(text);
      ADD_FAILURE() << text << " was accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
}

TEST(PhantomSpec, BadValuesAreRefused) {
  const auto refused = [](PhantomKind kind, auto&& change) {
    PhantomSpec spec = spec_of(kind);
    change(spec);
    try {
      (void)resolve(spec);
      return false;
    } catch (const Error& error) {
      return error.kind() == ErrorKind::kUsage;
    }
  };
  EXPECT_TRUE(
      refused(PhantomKind::kSphere, [](PhantomSpec& s) { s.radius_mm = 31; }));  // would graze the border
  EXPECT_TRUE(refused(PhantomKind::kSphere, [](PhantomSpec& s) { s.radius_mm = -1; }));
  EXPECT_TRUE(refused(PhantomKind::kSphere, [](PhantomSpec& s) { s.radius_mm = std::nan(""); }));
  EXPECT_TRUE(refused(PhantomKind::kSphere, [](PhantomSpec& s) { s.spacing_mm = {1, 0, 1}; }));
  EXPECT_TRUE(refused(PhantomKind::kSphere, [](PhantomSpec& s) { s.spacing_mm = {1, -1, 1}; }));
  EXPECT_TRUE(refused(PhantomKind::kSphere, [](PhantomSpec& s) { s.size = {64, 64, 4}; }));
  EXPECT_TRUE(refused(PhantomKind::kSphere, [](PhantomSpec& s) { s.size = {64, 64, 3000}; }));
  EXPECT_TRUE(refused(PhantomKind::kSphere, [](PhantomSpec& s) { s.noise_voxels = 3; }));
  EXPECT_TRUE(refused(PhantomKind::kTorus, [](PhantomSpec& s) { s.ring_radius_mm = 12; }));  // hole too small
  EXPECT_TRUE(refused(PhantomKind::kLayered, [](PhantomSpec& s) { s.wall_mm = 0.5; }));
  EXPECT_TRUE(refused(PhantomKind::kCarotid, [](PhantomSpec& s) { s.sac_radius_mm = 100; }));
  EXPECT_TRUE(refused(PhantomKind::kCarotid, [](PhantomSpec& s) { s.end_radius_mm = 20; }));
  EXPECT_FALSE(refused(PhantomKind::kCarotid, [](PhantomSpec&) {}));
  EXPECT_THROW((void)phantom_kind_from_name("cube"), Error);
  EXPECT_THROW((void)Phantom(spec_of(PhantomKind::kSphere)).volume_mm3(2), Error);
}

}  // namespace
}  // namespace lumesh
