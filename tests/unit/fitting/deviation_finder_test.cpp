#include "../src/fitting/deviation_finder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <tuple>

#include "../src/lattice/labelled_lattice.hpp"
#include "fixtures/images.hpp"
#include "lumesh/fitting/boundary_choice.hpp"

namespace lumesh::fitting {
namespace {

/// A ball in two halves, as it comes from the lattice: no vertex is where it should be.
LabelImage halved_ball() {
  return fixtures::voxels_of(fixtures::frame_of({26, 26, 26}), {0, 1, 2}, [](const Vec3& p) {
    const Vec3 from_centre = p - Vec3(12.6, 12.3, 12.8);
    return from_centre.norm() > 9 ? 0 : from_centre.x() > 0 ? 1 : 2;
  });
}

struct Surface {
  WorkMesh mesh;
  BoundaryModel boundary;
};

Surface surface_of(const LabelImage& image, const ImageDomain& domain) {
  LatticeOptions options;
  const SizeGrid sizes(image, domain, options, 5, image.voxels().size(), OpeningSizes(domain));
  const LatticeFrame frame = make_lattice_frame(domain, 5, options.coarsening + options.max_refinement);
  Surface s{make_work_mesh(refined_lattice(frame, domain, sizes), frame, domain), {}};
  choose_boundary(s.mesh, domain);
  s.boundary = find_boundary(s.mesh, domain);
  return s;
}

using Told = std::tuple<bool, double, double, double, double>;

/// What was found, in an order of its own: which of two equally near triangles is told may differ.
std::vector<Told> told(const std::vector<Deviation>& deviations) {
  std::vector<Told> all;
  for (const Deviation& m : deviations)
    all.emplace_back(m.is_outlier, m.place_mm.x(), m.place_mm.y(), m.place_mm.z(), m.off_mm);
  std::sort(all.begin(), all.end());
  return all;
}

/// Vertices move, one triangle goes, one vertex gets other materials.
void change(Surface& s, std::mt19937& random) {
  std::uniform_real_distribution<double> step(-1, 1);
  for (int n = 0; n < 15; ++n) {
    const BoundaryTriangle& t = s.boundary.triangles[random() % s.boundary.triangles.size()];
    s.mesh.positions[t.vertices[random() % 3]] += Vec3(step(random), step(random), step(random));
  }
  s.boundary.triangles[random() % s.boundary.triangles.size()] = s.boundary.triangles.back();
  s.boundary.triangles.pop_back();
  const BoundaryTriangle& other = s.boundary.triangles[random() % s.boundary.triangles.size()];
  s.boundary.sets[other.vertices[0]] = {0, 1, 2};
}

TEST(DeviationFinder, FindsTheSameWhetherItKnowsTheSurfaceOfBeforeOrNot) {
  const LabelImage image = halved_ball();
  const ImageDomain domain(image, {});
  Surface s = surface_of(image, domain);
  const std::vector<Probe> probes = boundary_probes(image, domain);
  std::mt19937 random(17);
  DeviationFinder knowing(domain, probes);
  std::size_t found = 0, outliers = 0;
  for (int round = 0; round < 12; ++round) {
    if (round % 4 == 3) {
      EXPECT_GT(knowing.find(s.mesh, s.boundary, 0.5, 0).size(), 0U);  // stops at the first kind of deviation
      change(s, random);
    }
    const std::vector<Deviation> again = knowing.find(s.mesh, s.boundary, 0.5);
    DeviationFinder fresh(domain, probes);
    const std::vector<Deviation> first = fresh.find(s.mesh, s.boundary, 0.5);
    ASSERT_EQ(told(again), told(first)) << "round " << round;
    EXPECT_TRUE(std::is_sorted(again.begin(), again.end(),
                               [](const Deviation& a, const Deviation& b) { return a.off_mm > b.off_mm; }));
    found += first.size();
    outliers += static_cast<std::size_t>(
        std::count_if(first.begin(), first.end(), [](const Deviation& m) { return m.is_outlier; }));
    change(s, random);
  }
  EXPECT_GT(outliers, 20U);
  EXPECT_GT(found - outliers, 20U);
}

TEST(DeviationFinder, MeasuresWhatItMissedHoweverFarItIs) {
  const LabelImage image = halved_ball();
  const ImageDomain domain(image, {});
  const Surface s = surface_of(image, domain);
  const Vec3 near = s.mesh.positions[s.boundary.triangles[0].vertices[0]];  // on the surface
  const Vec3 far(12.6, 12.3, 62.8);                                         // 41 voxels from the ball's pole
  std::vector<Probe> probes(40, Probe{near, {0, 1}});
  probes.push_back({far, {0, 1}});
  DeviationFinder finder(domain, probes);
  (void)finder.find_probe_deviations(s.mesh, s.boundary, 1.0);
  const std::vector<double> distances = finder.deviating_probe_distances_mm(s.mesh, s.boundary);
  ASSERT_EQ(distances.size(), 1U);
  EXPECT_NEAR(distances[0], 41, 2) << "the lattice is not fitted yet";
}

}  // namespace
}  // namespace lumesh::fitting
