#include "../src/delaunay/estimate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "fixtures/analytic_domain.hpp"
#include "lumesh/delaunay/delaunay.hpp"

namespace lumesh::delaunay {
namespace {

/// Where the volume decides, where the surface does, and where both do.
TEST(Estimate, CountsTetrahedraWithinAFactorOfThree) {
  const fixtures::AnalyticDomain domain = fixtures::analytic_ball(Vec3(1, 2, 3), 10);
  struct Case {
    double delta_mm, size_mm;
  };
  for (const auto& [delta_mm, size_mm] : {Case{1.2, 1.5}, Case{0.4, 8}, Case{0.4, 1.2}}) {
    DelaunayOptions options;
    options.delta_mm = delta_mm;
    options.size_mm = size_mm;
    Context context;
    const double made = mesh_delaunay(domain, options, context).mesh.tet_count();
    const Spacing spacing(domain, delta_mm, size_mm, std::numeric_limits<double>::infinity(), nullptr);
    EXPECT_LT(estimated_tets(spacing).all, 3 * made) << delta_mm << " " << size_mm;
    EXPECT_GT(estimated_tets(spacing).all, made / 3) << delta_mm << " " << size_mm;
  }
}

/// The lattice beside a thin shell is finer by powers of two: its points may not be as many as that makes
/// them.
TEST(Estimate, ThinPartsHaveNoMoreTetrahedraWhereEdgesAreLonger) {
  const Vec3 centre(1, 2, 3);
  const fixtures::ShapeFunction inner = fixtures::ball_shape(centre, 3);
  fixtures::AnalyticDomainOptions in_box;
  in_box.bounds_mm = fixtures::box_around(centre, 4);
  in_box.resolution_mm = 0.15;
  const fixtures::AnalyticDomain domain(
      {{1, inner}, {2, fixtures::without(fixtures::ball_shape(centre, 3.8), inner)}}, in_box);
  double fewest = std::numeric_limits<double>::infinity();
  std::string notes;
  for (const double edge_mm : {0.38, 0.42, 0.6, 0.76, 0.84}) {
    DelaunayOptions options;
    options.edge_length_mm = edge_mm;
    Context context;
    const DelaunayResult result = mesh_delaunay(domain, options, context);
    const double made = result.mesh.tet_count(), expected = estimated_tetrahedra(domain, options);
    EXPECT_LT(made, 1.2 * fewest) << edge_mm;
    EXPECT_LT(expected, 2 * made) << edge_mm;
    EXPECT_GT(expected, made / 2) << edge_mm;
    fewest = std::min(fewest, made);
    for (const std::string& note : result.report.notes) notes += note;
  }
  EXPECT_NE(notes.find("thin parts have about "), std::string::npos) << notes;
}

}  // namespace
}  // namespace lumesh::delaunay
