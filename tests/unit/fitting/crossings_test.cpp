// The outside of the mesh does not cross itself where vessels leave the image obliquely, through faces, edges
// and corners: vertices are moved onto planes there, tetrahedra put into clefts beside them.
#include <random>

#include "fixtures/images.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "unit/lattice/shapes.hpp"

namespace lumesh::fitting {
namespace {

using fixtures::frame_of;
using fixtures::voxels_of;

/// Straight tubes of 2 to 7 voxels in radius through places close to a face, an edge or a corner.
LabelImage random_tubes(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0, 1);
  std::normal_distribution<double> normal;
  constexpr double kSize = 34;
  struct Tube {
    Vec3 point, along;
    double radius;
  };
  std::vector<Tube> tubes(1 + seed % 2);
  for (Tube& tube : tubes) {
    for (int axis = 0; axis < 3; ++axis)
      tube.point[axis] =
          axis < static_cast<int>(seed % 4) ? (share(random) < 0.5 ? 0 : kSize) : kSize * share(random);
    const Vec3 middle =
        kSize * Vec3(0.3 + 0.4 * share(random), 0.3 + 0.4 * share(random), 0.3 + 0.4 * share(random));
    tube.along =
        (middle - tube.point + 3 * Vec3(normal(random), normal(random), normal(random))).normalized();
    tube.radius = 2 * std::pow(3.5, share(random));
  }
  return voxels_of(frame_of({35, 35, 35}), {0, 1}, [&](const Vec3& p) {
    return std::any_of(tubes.begin(), tubes.end(), [&](const Tube& tube) {
      return (p - tube.point).cross(tube.along).norm() < tube.radius;
    });
  });
}

TEST(LatticeCrossings, NoneWhereTubesLeaveTheImage) {
  for (unsigned seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    for (const double spacing_mm : {2.5, 5.0}) {
      LatticeOptions options;
      options.spacing_mm = spacing_mm;
      const MixedMesh mesh = test::meshed(random_tubes(seed), options);
      EXPECT_TRUE(find_self_crossings(mesh.points, mesh.triangles).empty()) << "spacing " << spacing_mm;
    }
  }
}

}  // namespace
}  // namespace lumesh::fitting
