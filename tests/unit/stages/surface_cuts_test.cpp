#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "fixtures/surfaces.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/surface_input.hpp"

namespace lumesh {
namespace {

using fixtures::icosphere;
using fixtures::TriangleSoup;

constexpr double kPi = std::numbers::pi;

std::unique_ptr<SurfaceDomain> domain_of(const MixedMesh& surface) {
  SurfaceInput input;
  input.mesh = surface;
  return input.domain({});
}

/// Open at both ends, around a curve of places and directions by the length along it.
struct Tube {
  double length_mm = 20;
  std::function<Vec3(double)> axis = [](double s) { return Vec3(0, 0, s); };
  std::function<Vec3(double)> along = [](double /*s*/) { return Vec3(0, 0, 1); };
  std::function<double(double)> radius = [](double /*angle*/) { return 2.0; };
  std::uint32_t rows = 48;
};

TriangleSoup soup_of(const Tube& tube) {
  constexpr std::uint32_t kAround = 32;
  TriangleSoup soup;
  for (std::uint32_t row = 0; row <= tube.rows; ++row) {
    const double s = tube.length_mm * row / tube.rows;
    const Vec3 v = Vec3::UnitY(), u = v.cross(tube.along(s));
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const double angle = 2 * kPi * i / kAround;
      soup.points.emplace_back(tube.axis(s) +
                               tube.radius(angle) * (std::cos(angle) * u + std::sin(angle) * v));
    }
  }
  for (std::uint32_t row = 0; row < tube.rows; ++row)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const std::uint32_t a = row * kAround + i, b = row * kAround + (i + 1) % kAround;
      soup.triangles.push_back({a, b, a + kAround});
      soup.triangles.push_back({b, b + kAround, a + kAround});
    }
  return soup;
}

/// A quarter of a circle of radius 15 in the plane y = 0.
Tube bent() {
  Tube tube;
  tube.length_mm = 7.5 * kPi;
  tube.axis = [](double s) { return Vec3(15 * (1 - std::cos(s / 15)), 0, 15 * std::sin(s / 15)); };
  tube.along = [](double s) { return Vec3(std::sin(s / 15), 0, std::cos(s / 15)); };
  return tube;
}

class SurfaceCuts : public ::testing::Test {
 protected:
  std::filesystem::path write(const TriangleSoup& soup) {
    const ::testing::TestInfo& test = *::testing::UnitTest::GetInstance()->current_test_info();
    const std::filesystem::path path = ::testing::TempDir() + "surface_cuts_" + test.name() + ".obj";
    std::ofstream file(path);
    file.precision(17);
    for (const Vec3& p : soup.points) file << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
    for (const auto& [a, b, c] : soup.triangles)
      file << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
    return path;
  }
  SurfaceInput read(const TriangleSoup& soup, const InputCuts& cuts) {
    return read_surface(write(soup), "", {}, cuts, context_);
  }
  static FlatEnd end_named(const MixedMesh& surface, const std::string& name) {
    const auto domain = domain_of(surface);
    for (const FlatEnd& end : domain->flat_ends())
      if (end.name == name) return end;
    ADD_FAILURE() << "no end " << name;
    return {};
  }
  static double volume_of(const MixedMesh& surface) { return domain_of(surface)->volume_mm3(); }

  std::vector<std::string> told_;
  Context context_{nullptr, [this](std::string_view text) { told_.emplace_back(text); }};
};

TEST_F(SurfaceCuts, AnExtensionHasTheLengthAndTheSectionOfItsEnd) {
  const MixedMesh plain = read(soup_of(bent()), {}).mesh;
  InputCuts cuts;
  cuts.extension.lengths = named_lengths_from("5r");
  const MixedMesh longer = read(soup_of(bent()), cuts).mesh;
  for (const std::string name : {"inlet_1", "outlet_1"}) {
    const FlatEnd before = end_named(plain, name), after = end_named(longer, name);
    const double radius_mm = std::sqrt(before.area_mm2 / kPi);
    EXPECT_NEAR((after.centre_mm - before.centre_mm).norm(), 5 * radius_mm, 0.005 * 5 * radius_mm) << name;
    EXPECT_NEAR((after.centre_mm - before.centre_mm).normalized().dot(before.normal), 1, 1e-3) << name;
    EXPECT_NEAR(after.area_mm2, before.area_mm2, 0.01 * before.area_mm2) << name;
  }
  const double end_mm2 = end_named(plain, "inlet_1").area_mm2;
  EXPECT_NEAR(volume_of(longer) - volume_of(plain), 2 * 5 * 2 * end_mm2, 0.01 * 20 * end_mm2);
}

// Sizes that nobody asks for are multiples of the resolution.
TEST_F(SurfaceCuts, CutsAndExtensionsKeepTheResolution) {
  const double plain_mm = read(soup_of(bent()), {}).domain({})->resolution_mm();
  InputCuts longer, shorter;
  longer.extension.lengths = named_lengths_from("20r");
  shorter.planes = {{Vec3(0, 0, 5), Vec3(0, 0, -1)}};
  for (const InputCuts& cuts : {longer, shorter}) {
    const SurfaceInput changed = read(soup_of(bent()), cuts);
    EXPECT_DOUBLE_EQ(changed.domain({})->resolution_mm(), plain_mm);
    EXPECT_GT(std::abs(domain_of(changed.mesh)->resolution_mm() - plain_mm), 0.05 * plain_mm);
  }
}

// A rim is often finer than the wall, as that of a ragged cut is.
TEST_F(SurfaceCuts, RowsOfAnExtensionAreAsHighAsTheWallsTriangles) {
  TriangleSoup fine_rim = soup_of({});
  const auto around = static_cast<std::uint32_t>(32);
  for (std::uint32_t i = 0; i < around; ++i) {  // Each triangle at the end z = 20 becomes eight.
    const std::uint32_t a = 48 * around + i, b = 48 * around + (i + 1) % around;
    const auto at = std::find_if(fine_rim.triangles.begin(), fine_rim.triangles.end(), [&](const Cell<3>& t) {
      return std::count(t.begin(), t.end(), a) == 1 && std::count(t.begin(), t.end(), b) == 1;
    });
    const std::uint32_t tip =
        *std::find_if(at->begin(), at->end(), [&](std::uint32_t v) { return v != a && v != b; });
    fine_rim.triangles.erase(at);
    std::uint32_t from = b;
    for (int k = 1; k <= 8; ++k) {
      std::uint32_t to = a;
      if (k < 8) {
        to = static_cast<std::uint32_t>(fine_rim.points.size());
        fine_rim.points.push_back(fine_rim.points[b] + k / 8.0 * (fine_rim.points[a] - fine_rim.points[b]));
      }
      fine_rim.triangles.push_back({from, to, tip});
      from = to;
    }
  }
  InputCuts cuts;
  cuts.extension.lengths = named_lengths_from("10r");
  const SurfaceInput plain = read(fine_rim, {}), longer = read(fine_rim, cuts);
  // 20 mm in rows of 0.3 to 0.5 mm with 256 edges around one end and 32 around the other, not of the rim's
  // 0.05 mm.
  const auto sides = static_cast<double>(longer.mesh.triangles.size() - plain.mesh.triangles.size());
  EXPECT_LT(sides, 2.0 * (256 + 32) * 20 / 0.3);
  EXPECT_GT(sides, 2.0 * (256 + 32) * 20 / 0.5);
}

/// Mean angle between the triangles that share an edge of the plane z = 0, 32 edges around.
double turned_at_seam_deg(const MixedMesh& surface) {
  double turned_deg = 0;
  std::size_t count = 0;
  const auto normal_of = [&](const Cell<3>& t) {
    return triangle_normal(surface.points[t[0]], surface.points[t[1]], surface.points[t[2]]);
  };
  const auto is_at_seam = [&](const Cell<3>& t, double side) {
    int on = 0, beyond = 0;
    for (const std::uint32_t v : t) {
      on += std::abs(surface.points[v].z()) < 1e-9 ? 1 : 0;
      beyond += side * surface.points[v].z() > 1e-9 ? 1 : 0;
    }
    return on == 2 && beyond == 1;
  };
  for (const Cell<3>& t : surface.triangles)
    for (const Cell<3>& u : surface.triangles) {
      if (!is_at_seam(t, 1) || !is_at_seam(u, -1)) continue;
      const auto shared = std::count_if(t.begin(), t.end(),
                                        [&](auto v) { return std::find(u.begin(), u.end(), v) != u.end(); });
      if (shared != 2) continue;
      turned_deg += std::acos(std::min(1.0, normal_of(t).dot(normal_of(u)))) * 180 / kPi;
      ++count;
    }
  EXPECT_EQ(count, 32U);
  return turned_deg / static_cast<double>(count);
}

TEST_F(SurfaceCuts, WallsGoOnSmoothly) {
  InputCuts cuts;
  cuts.extension.lengths = named_lengths_from("3r");
  EXPECT_LT(turned_at_seam_deg(read(soup_of(bent()), cuts).mesh), 3);
}

// A straight extension would have a crease of up to 8 degrees.
TEST_F(SurfaceCuts, WallsThatTaperOrLeanGoOnSmoothly) {
  struct Slopes {
    double taper, lean;
  };
  for (const auto& [taper, lean] : {Slopes{0.14, 0}, Slopes{-0.09, 0}, Slopes{0, 0.07}, Slopes{0.08, -0.06}})
    for (const bool is_to_circle : {false, true}) {
      TriangleSoup vessel = soup_of({});
      for (Vec3& p : vessel.points) {
        const double z = p.z(), wider = 1 + taper / 2 * z;
        p = Vec3(wider * p.x() + lean * z, wider * p.y(), z);
      }
      const std::string name = taper > 0 ? "outlet_1" : "inlet_1";  // The inlet is the wider end.
      InputCuts cuts;
      cuts.extension.lengths = named_lengths_from(name + "=5r");
      if (is_to_circle) cuts.extension.transition = local_length_from("2r");
      const MixedMesh plain = read(vessel, {}).mesh, longer = read(vessel, cuts).mesh;
      EXPECT_LT(turned_at_seam_deg(longer), 3) << taper << ' ' << lean;
      const FlatEnd before = end_named(plain, name), after = end_named(longer, name);
      EXPECT_NEAR(after.area_mm2, before.area_mm2, 1e-6 * before.area_mm2);
      EXPECT_NEAR(after.centre_mm.z(), -5 * std::sqrt(before.area_mm2 / kPi), 1e-6);
      EXPECT_TRUE(told_.empty());
    }
}

TEST_F(SurfaceCuts, AnExtensionFollowsAVesselThatBendsAndTapersToAnObliqueEnd) {
  TriangleSoup vessel = soup_of({});
  for (Vec3& p : vessel.points) {  // About the curve x = z^2 / 100.
    const double z = p.z();
    p = Vec3((1 - 0.035 * z) * p.x() + 0.01 * z * z, (1 - 0.035 * z) * p.y(), z);
  }
  InputCuts cuts;
  cuts.planes = {{Vec3(1.44, 0, 12), Vec3(0.35, 0, 1)}};
  cuts.extension.lengths = named_lengths_from("5r");
  const FlatEnd end = end_named(read(vessel, cuts).mesh, "outlet_1");
  EXPECT_LT(std::acos(end.normal.dot(Vec3(0.24, 0, 1).normalized())) * 180 / kPi, 0.2);
  EXPECT_TRUE(told_.empty());
}

/// The boundary of the voxels of 0.5 mm within 2.2 mm of an axis through the origin, up to 12 mm to both
/// sides, with each vertex moved by a share of the way to the middle of its neighbours: by all of it, stairs
/// as marching cubes leave them.
TriangleSoup stairs_around(const Vec3& axis) {
  constexpr double kVoxel = 0.5;
  constexpr int kReach = 26;
  const auto is_inside = [&](const Index3& v) {
    const Vec3 x = kVoxel * v.cast<double>() + Vec3(0.11, 0.07, 0.13);
    return std::abs(x.dot(axis)) < 12 && (x - x.dot(axis) * axis).norm() < 2.2;
  };
  TriangleSoup soup;
  std::map<std::tuple<int, int, int>, std::uint32_t> numbers;
  const auto number = [&](const Index3& corner) {
    const auto [at, is_new] = numbers.try_emplace({corner.x(), corner.y(), corner.z()},
                                                  static_cast<std::uint32_t>(soup.points.size()));
    if (is_new) soup.points.emplace_back(kVoxel * (corner.cast<double>() - Vec3::Constant(0.5)));
    return at->second;
  };
  for (int z = -kReach; z <= kReach; ++z)
    for (int y = -kReach; y <= kReach; ++y)
      for (int x = -kReach; x <= kReach; ++x)
        for (int side = 0; side < 6 && is_inside({x, y, z}); ++side) {
          const int along = side % 3, sign = side < 3 ? 1 : -1;
          if (is_inside(Index3(x, y, z) + sign * Index3::Unit(along))) continue;
          const Index3 u = Index3::Unit((along + (sign > 0 ? 1 : 2)) % 3),
                       v = Index3::Unit((along + (sign > 0 ? 2 : 1)) % 3);
          const Index3 first = Index3(x, y, z) + (sign > 0 ? 1 : 0) * Index3::Unit(along);
          const std::uint32_t a = number(first), b = number(first + u), c = number(first + u + v),
                              d = number(first + v);
          soup.triangles.push_back({a, b, c});
          soup.triangles.push_back({a, c, d});
        }
  std::vector<Vec3> sums(soup.points.size(), Vec3::Zero());
  std::vector<int> counts(soup.points.size(), 0);
  for (const Cell<3>& t : soup.triangles)
    for (std::size_t i = 0; i < 3; ++i) sums[t[i]] += soup.points[t[(i + 1) % 3]], ++counts[t[i]];
  for (std::size_t i = 0; i < sums.size(); ++i) soup.points[i] = sums[i] / counts[i];
  return soup;
}

TEST_F(SurfaceCuts, ExtensionsOfStairSurfacesFollowTheVessel) {
  for (const double slope : {0.4, 0.9})
    for (const Vec3& given : {Vec3(0.42, 0.1, 0.9), Vec3(0.3, 0.3, 0.85)}) {
      const Vec3 axis = given.normalized(), on_axis = -Vec3(0.11, 0.07, 0.13);
      InputCuts cuts;
      cuts.planes = {{8 * axis, axis + slope * axis.unitOrthogonal()}, {-8 * axis, -axis}};
      cuts.extension.lengths = named_lengths_from("4r");
      const auto domain = read(stairs_around(axis), cuts).domain({});
      ASSERT_EQ(domain->flat_ends().size(), 2U);
      for (const FlatEnd& end : domain->flat_ends()) {
        EXPECT_GT(std::abs(end.normal.dot(axis)), std::cos(2 * kPi / 180)) << given.transpose() << end.name;
        const CutPlane& plane = cuts.planes[end.normal.dot(axis) > 0 ? 0 : 1];
        const Vec3 before = on_axis - plane.height(on_axis) / plane.normal.dot(axis) * axis;
        const double radius_mm = std::sqrt(end.area_mm2 / kPi);
        EXPECT_NEAR((end.centre_mm - before).norm(), 4 * radius_mm, 0.02 * 4 * radius_mm)
            << given.transpose() << slope << end.name;
      }
    }
}

// Half a circle of two radii of the vessel; points of the walls, but for the ends', are off by up to 0.08 of
// it along each axis.
TEST_F(SurfaceCuts, ExtensionsOfRoughBendsThatLeanAreTold) {
  constexpr double kArc = 8, kRadius = 4;
  int leaning = 0;
  for (int seed = 0; seed < 12; ++seed) {
    Tube tube;
    tube.length_mm = kArc * kPi;
    tube.rows = 16;
    tube.axis = [](double s) { return Vec3(kArc * (1 - std::cos(s / kArc)), 0, kArc * std::sin(s / kArc)); };
    tube.along = [](double s) { return Vec3(std::sin(s / kArc), 0, std::cos(s / kArc)); };
    tube.radius = [](double) { return kRadius; };
    TriangleSoup soup = soup_of(tube);
    std::mt19937 random(static_cast<unsigned>(seed));
    constexpr std::size_t kAround = 32;
    for (std::size_t i = kAround; i + kAround < soup.points.size(); ++i)
      for (double& x : soup.points[i])
        x += 0.15 * kRadius * (static_cast<double>(random()) / 0xffffffffU - 0.5);
    InputCuts cuts;
    cuts.extension.lengths = named_lengths_from("2r");
    told_.clear();
    const auto domain = read(soup, cuts).domain({});
    for (const FlatEnd& end : domain->flat_ends())
      for (const double s : {0.0, tube.length_mm}) {
        const Vec3 out = (s > 0 ? 1 : -1) * tube.along(s), off = end.centre_mm - tube.axis(s);
        if (std::abs(off.norm() - 2 * kRadius) > 1) continue;
        if (off.normalized().dot(out) > std::cos(6 * kPi / 180)) continue;
        ++leaning;
        const std::string words = "the direction of the vessel at " + end.name + ", (";
        EXPECT_TRUE(std::ranges::any_of(
            told_, [&](const std::string& line) { return line.find(words) != std::string::npos; }))
            << seed << end.name;
      }
  }
  EXPECT_GE(leaning, 3);
}

TEST_F(SurfaceCuts, AnEndThatIsClippedKeepsItsName) {
  const TriangleSoup soup = soup_of(bent());
  const std::filesystem::path path = write(soup);
  std::ofstream file(path, std::ios::app);  // As the group of all walls: it comes last.
  const std::size_t last = soup.points.size() - 32;
  for (const auto& [name, first, turn] :
       {std::tuple("ICA", std::size_t{0}, true), std::tuple("MCA", last, false)}) {
    file << "g " << name << '\n';
    for (std::size_t i = 1; i + 1 < 32; ++i)
      file << "f " << first + 1 << ' ' << first + 1 + (turn ? i + 1 : i) << ' '
           << first + 1 + (turn ? i : i + 1) << '\n';
  }
  file.close();
  InputCuts cuts;
  cuts.ends = local_length_from("1r");
  const SurfaceInput cut = read_surface(path, "", {}, cuts, context_);
  const auto domain = cut.domain({});
  std::set<std::string> names;
  for (const FlatEnd& end : domain->flat_ends()) names.insert(end.name);
  EXPECT_EQ(names, (std::set<std::string>{"ICA", "MCA"}));
}

/// A tube closed by fans over rims up to 3.5 % of its radius off their planes.
TriangleSoup closed_raggedly() {
  TriangleSoup soup = soup_of({});
  const std::size_t last = soup.points.size() - 32;
  for (const std::size_t first : {std::size_t{0}, last}) {
    const auto middle = static_cast<std::uint32_t>(soup.points.size());
    Vec3 centre = Vec3::Zero();
    for (std::uint32_t i = 0; i < 32; ++i) {
      centre += soup.points[first + i] / 32;
      soup.points[first + i].z() += 0.07 * std::cos(4.0 * i * i);
    }
    soup.points.push_back(centre);
    for (std::uint32_t i = 0; i < 32; ++i) {
      const auto a = static_cast<std::uint32_t>(first) + i,
                 b = static_cast<std::uint32_t>(first) + (i + 1) % 32;
      soup.triangles.push_back(first == 0 ? Cell<3>{b, a, middle} : Cell<3>{a, b, middle});
    }
  }
  return soup;
}

// A fan over a ragged rim was several openings, or none.
TEST_F(SurfaceCuts, EndsThatSharpEdgesDivideAreCappedAnew) {
  SurfaceInputOptions options;
  options.domain.feature_angle_deg = 25;
  const SurfaceInput given = read_surface(write(closed_raggedly()), "", options, {}, context_);
  ASSERT_EQ(given.closed.size(), 2U);
  const auto domain = given.domain(options.domain);
  ASSERT_EQ(domain->flat_ends().size(), 2U);
  for (const FlatEnd& end : domain->flat_ends()) EXPECT_NEAR(end.area_mm2, 4 * kPi, 0.02 * 4 * kPi);
  options.keeps_open = true;
  EXPECT_TRUE(read_surface(write(closed_raggedly()), "", options, {}, context_).closed.empty());
}

// A tube of six sides: its ends are flat, though no rim of an opening has so few edges.
TEST_F(SurfaceCuts, WhatWasFilledAndIsAFlatEndIsToldAsAnOpening) {
  TriangleSoup soup;
  for (std::uint32_t row = 0; row < 13; ++row)
    for (std::uint32_t i = 0; i < 6; ++i)
      soup.points.emplace_back(2 * std::cos(kPi * i / 3), 2 * std::sin(kPi * i / 3), row);
  for (std::uint32_t row = 0; row < 12; ++row)
    for (std::uint32_t i = 0; i < 6; ++i) {
      const std::uint32_t a = row * 6 + i, b = row * 6 + (i + 1) % 6;
      soup.triangles.push_back({a, b, a + 6});
      soup.triangles.push_back({b, b + 6, a + 6});
    }
  SurfaceInput given = read_surface(write(soup), "", {}, {}, context_);
  const auto domain = given.domain({.feature_angle_deg = 70});
  ASSERT_EQ(domain->flat_ends().size(), 2U);
  name_closed(given.closed, domain->flat_ends());
  warn_of_filled_ends(given.closed, context_);
  EXPECT_TRUE(told_.empty()) << told_.front();
  for (const surfaces::ClosedRim& rim : given.closed) EXPECT_TRUE(rim.is_opening) << rim.name;
}

// Caps may be much finer than the wall.
TEST_F(SurfaceCuts, CapsDoNotCountInTheResolution) {
  Tube tube;
  tube.radius = [](double /*angle*/) { return 0.5; };
  tube.rows = 200;
  const TriangleSoup soup = soup_of(tube);
  double sum_mm = 0;
  for (const Cell<3>& t : soup.triangles)
    for (std::size_t i = 0; i < 3; ++i) sum_mm += (soup.points[t[(i + 1) % 3]] - soup.points[t[i]]).norm();
  const double mean_mm = sum_mm / static_cast<double>(3 * soup.triangles.size());
  EXPECT_NEAR(read(soup, {}).domain({})->resolution_mm(), 0.5 * mean_mm, 1e-12);
}

// A speck has often more triangles than the vessel.
TEST_F(SurfaceCuts, SpecksDoNotCountInTheResolution) {
  Tube tube;
  tube.radius = [](double /*angle*/) { return 0.5; };
  tube.rows = 200;
  TriangleSoup soup = soup_of(tube);
  const Box3 box = bounding_box(soup.points);
  const double alone_mm = read(soup, {}).domain({})->resolution_mm();
  TriangleSoup speck = fixtures::icosphere(4, 0.02).moved(
      [&](const Vec3& p) { return Vec3(p + box.center() + Vec3(0.45, 0.45, 0)); });
  speck.patches.assign(speck.triangles.size(), soup.patches.empty() ? 0 : soup.patches.front());
  soup.append(speck);
  EXPECT_DOUBLE_EQ(read(soup, {}).domain({})->resolution_mm(), alone_mm);
}

TEST_F(SurfaceCuts, ASectionBecomesACircleOfItsArea) {
  Tube tube;
  tube.radius = [](double angle) {
    return 2 / std::sqrt(std::pow(std::cos(angle), 2) + 2 * std::pow(std::sin(angle), 2));
  };
  InputCuts cuts;
  cuts.extension.lengths = named_lengths_from("outlet_1=4r,inlet_1=0");
  cuts.extension.transition = local_length_from("2r");
  const MixedMesh plain = read(soup_of(tube), {}).mesh, longer = read(soup_of(tube), cuts).mesh;
  const FlatEnd before = end_named(plain, "outlet_1"), after = end_named(longer, "outlet_1");
  EXPECT_NEAR(after.area_mm2, before.area_mm2, 1e-6 * before.area_mm2);
  EXPECT_EQ(end_named(longer, "inlet_1").centre_mm, end_named(plain, "inlet_1").centre_mm);
  double least = 1e9, most = 0;
  const auto patch = std::find_if(longer.info.patches.begin(), longer.info.patches.end(),
                                  [](const Patch& p) { return p.name == "outlet_1"; });
  const auto number = static_cast<std::int32_t>(patch - longer.info.patches.begin());
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (std::size_t t = 0; t < longer.triangles.size(); ++t)
    if (longer.triangle_patches[t] == number)
      for (std::size_t s = 0; s < 3; ++s)
        ++edges[std::minmax(longer.triangles[t][s], longer.triangles[t][(s + 1) % 3])];
  for (const auto& [edge, count] : edges) {
    if (count != 1) continue;
    const double off = (longer.points[edge.first] - after.centre_mm).norm();
    least = std::min(least, off);
    most = std::max(most, off);
  }
  EXPECT_LT(most / least, 1.001);
}

TEST_F(SurfaceCuts, EndsAreCutSquareAndSacsAreNot) {
  InputCuts cuts;
  cuts.ends = local_length_from("1r");
  const MixedMesh cut = read(soup_of(bent()), cuts).mesh;
  EXPECT_NEAR(volume_of(cut), kPi * 4 * (7.5 * kPi - 2 * 2), 0.03 * kPi * 4 * 7.5 * kPi);
  for (const std::string name : {"inlet_1", "outlet_1"}) {
    const FlatEnd end = end_named(cut, name);
    EXPECT_NEAR(end.area_mm2, kPi * 4, 0.01 * kPi * 4) << name;
    const double angle = std::atan2(end.centre_mm.z(), 15 - end.centre_mm.x());
    EXPECT_GT(std::abs(end.normal.dot(Vec3(std::sin(angle), 0, std::cos(angle)))), std::cos(1.5 / 180 * kPi))
        << name;
  }
  EXPECT_EQ(domain_of(cut)->flat_ends().size(), 2U);
}

TEST_F(SurfaceCuts, EndsOfOvalVesselsAreCut) {
  constexpr double kLong = 3.2, kShort = 1.28;  // The ball that fits has 0.4 of the section's area.
  InputCuts cuts;
  cuts.ends = local_length_from("1r");
  Tube oval;
  oval.radius = [](double angle) {
    return kLong * kShort / std::hypot(kShort * std::cos(angle), kLong * std::sin(angle));
  };
  const double given_mm3 = volume_of(read(soup_of(oval), {}).mesh);
  const MixedMesh cut = read(soup_of(oval), cuts).mesh;
  EXPECT_NEAR(volume_of(cut) / given_mm3, (20 - 2 * kShort) / 20, 0.03);
  EXPECT_NEAR(end_named(cut, "inlet_1").area_mm2, given_mm3 / 20, 0.01 * given_mm3 / 20);
}

constexpr double kBend = 24;

/// The balls that fit into it can lie to either side, and their centres stray.
Tube bent_oval(double ratio) {
  Tube tube;
  tube.length_mm = 50;
  tube.rows = 60;
  tube.axis = [](double s) {
    return Vec3(kBend * (1 - std::cos(s / kBend)), 0, kBend * std::sin(s / kBend));
  };
  tube.along = [](double s) { return Vec3(std::sin(s / kBend), 0, std::cos(s / kBend)); };
  tube.radius = [ratio](double angle) {  // The long axis is that of y.
    return 3 * ratio / std::hypot(ratio * std::cos(angle), std::sin(angle));
  };
  return tube;
}

TEST_F(SurfaceCuts, EndsOfOvalVesselsThatBendAreCutSquare) {
  for (const double ratio : {2.0, 3.0, 4.0}) {
    const Tube tube = bent_oval(ratio);
    InputCuts cuts;
    cuts.ends = local_length_from("2r");
    const auto domain = read(soup_of(tube), cuts).domain({});
    ASSERT_EQ(domain->flat_ends().size(), 2U);
    for (const FlatEnd& end : domain->flat_ends()) {
      const double s = kBend * std::atan2(end.centre_mm.z(), kBend - end.centre_mm.x());
      EXPECT_GT(std::abs(end.normal.dot(tube.along(s))), std::cos(kPi / 180)) << ratio;
    }
  }
}

TEST_F(SurfaceCuts, PlacesOnOvalVesselsThatBendAreCutSquare) {
  for (const double ratio : {1.5, 2.0, 4.0})
    for (const double s : {16.0, 25.0, 33.0}) {
      const Tube tube = bent_oval(ratio);
      InputCuts cuts;
      cuts.places_mm = {tube.axis(s)};
      const auto domain = read(soup_of(tube), cuts).domain({});
      const auto is_cut = [&](const FlatEnd& end) { return (end.centre_mm - tube.axis(s)).norm() < 1; };
      const auto end = std::ranges::find_if(domain->flat_ends(), is_cut);
      ASSERT_NE(end, domain->flat_ends().end()) << ratio << ' ' << s;
      EXPECT_GT(std::abs(end->normal.dot(tube.along(s))), std::cos(0.5 * kPi / 180)) << ratio << ' ' << s;
    }
  EXPECT_TRUE(told_.empty()) << told_.front();
}

TEST_F(SurfaceCuts, EndsThatAPlaneMadeAreCutToo) {
  InputCuts cuts;
  cuts.planes = {{{0, 0, 15}, {0.3, 0, 1}}};
  cuts.ends = local_length_from("1r");
  const MixedMesh cut = read(soup_of({}), cuts).mesh;
  EXPECT_NEAR(volume_of(cut), kPi * 4 * (15 - 2 * 2), 0.03 * kPi * 4 * 15);
  EXPECT_NEAR(end_named(cut, "inlet_1").area_mm2, kPi * 4, 0.01 * kPi * 4);
}

TEST_F(SurfaceCuts, TheEndGoesThoughItIsTheLargerPart) {
  InputCuts cuts;
  cuts.ends = local_length_from("12");
  Tube tube;
  tube.length_mm = 30;
  const MixedMesh cut = read(soup_of(tube), cuts).mesh;
  EXPECT_NEAR(volume_of(cut), kPi * 4 * (30 - 2 * 12), 0.03 * kPi * 4 * 6);
}

TEST_F(SurfaceCuts, VesselsThatStandAloneAreAllCut) {
  TriangleSoup two = soup_of({});
  two.append(soup_of({}).moved([](const Vec3& p) { return Vec3(p + Vec3(20, 0, 0)); }));
  InputCuts ends, place;
  ends.ends = local_length_from("1r");
  EXPECT_NEAR(volume_of(read(two, ends).mesh), 2 * kPi * 4 * (20 - 2 * 2), 0.03 * 2 * kPi * 4 * 16);
  place.places_mm = {{20, 0, 14}};
  EXPECT_NEAR(volume_of(read(two, place).mesh), kPi * 4 * (20 + 14), 0.02 * kPi * 4 * 34);
}

TEST_F(SurfaceCuts, AnExtensionIsAsShortOrAsLongAsAskedOrRefused) {
  InputCuts cuts;
  for (const double length_mm : {0.3, 2.0, 90.0}) {
    cuts.extension.lengths = named_lengths_from(std::to_string(length_mm));
    const MixedMesh longer = read(soup_of({}), cuts).mesh;
    EXPECT_NEAR(end_named(longer, "inlet_1").centre_mm.z() - end_named(longer, "outlet_1").centre_mm.z(),
                std::copysign(20 + 2 * length_mm, end_named(longer, "inlet_1").centre_mm.z() - 10), 1e-6)
        << length_mm;
  }
  EXPECT_TRUE(told_.empty());
  for (const char* const length : {"1e4r", "1e300r"}) {
    cuts.extension.lengths = named_lengths_from(length);
    EXPECT_THROW(static_cast<void>(read(soup_of({}), cuts)), Error) << length;
  }
}

TEST_F(SurfaceCuts, APlaceCutsTheVesselThere) {
  InputCuts cuts;
  cuts.places_mm = {{0.3, 0.2, 14}};
  const SurfaceInput cut = read(soup_of({}), cuts);
  EXPECT_NEAR(volume_of(cut.mesh), kPi * 4 * 14, 0.02 * kPi * 4 * 14);
  // The end that went is not among what was closed.
  EXPECT_EQ(cut.closed.size(), 1U);
  InputCuts beside;
  beside.places_mm = {{30, 0, 14}};
  EXPECT_THROW(static_cast<void>(read(soup_of({}), beside)), Error);
}

TEST_F(SurfaceCuts, ExtensionsKeepOffOtherVessels) {
  // A hook whose end looks at its own beginning.
  Tube hook;
  hook.length_mm = 1.6 * kPi * 8;
  hook.axis = [](double s) { return Vec3(8 * (1 - std::cos(s / 8)), 0, 8 * std::sin(s / 8)); };
  hook.along = [](double s) { return Vec3(std::sin(s / 8), 0, std::cos(s / 8)); };
  InputCuts cuts;
  cuts.extension.lengths = named_lengths_from("30r");
  const MixedMesh longer = read(soup_of(hook), cuts).mesh;
  ASSERT_FALSE(told_.empty());
  EXPECT_NE(told_.front().find("in the way"), std::string::npos);
  EXPECT_EQ(domain_of(longer)->flat_ends().size(), 2U);
}

// The wall widens by 17 degrees: the extension bulges by 0.08 mm where a straight one would pass by.
TEST_F(SurfaceCuts, ExtensionsOfWallsThatWidenKeepOffToo) {
  for (const bool widens : {false, true}) {
    Tube tube;
    tube.length_mm = 5;
    TriangleSoup vessels = soup_of(tube);
    for (Vec3& p : vessels.points) p.head<2>() *= widens ? 1 - 0.15 * p.z() : 1.0;
    const auto first = static_cast<std::uint32_t>(vessels.points.size());
    const TriangleSoup ball = icosphere(3, 0.5);
    for (const Vec3& p : ball.points) vessels.points.emplace_back(p + Vec3(2.90, 0, -1));
    for (const auto& [a, b, c] : ball.triangles)
      vessels.triangles.push_back({a + first, b + first, c + first});
    InputCuts cuts;
    cuts.extension.lengths = named_lengths_from("inlet_1=5r");
    static_cast<void>(read(vessels, cuts));
    EXPECT_EQ(told_.size(), widens ? 1U : 0U);
  }
}

TEST_F(SurfaceCuts, WithoutAFlatEndNothingIsExtended) {
  InputCuts cuts;
  cuts.extension.lengths = named_lengths_from("5r");
  try {
    static_cast<void>(read(icosphere(3, 4), cuts));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    EXPECT_NE(std::string(error.what()).find("no flat end"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace lumesh
