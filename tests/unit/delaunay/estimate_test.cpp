#include "../src/delaunay/estimate.hpp"

#include <gtest/gtest.h>

#include <limits>

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
    EXPECT_LT(estimated_tets(spacing), 3 * made) << delta_mm << " " << size_mm;
    EXPECT_GT(estimated_tets(spacing), made / 3) << delta_mm << " " << size_mm;
  }
}

}  // namespace
}  // namespace lumesh::delaunay
