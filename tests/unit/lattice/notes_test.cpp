// What the mesher says about meshes that are less than perfect.
#include "fixtures/images.hpp"
#include "shapes.hpp"

namespace lumesh {
namespace {

using fixtures::frame_of;
using fixtures::voxels_of;

LatticeResult lattice_of(const LabelImage& image, const LatticeOptions& options = {}) {
  const ImageDomain domain(image, {});
  Context context;
  return mesh_lattice(image, domain, options, context);
}

std::string joined(const std::vector<std::string>& notes) {
  std::string all;
  for (const std::string& note : notes) all += note + "\n";
  return all;
}

TEST(LatticeNotes, AGoodMeshNeedsNone) {
  const Vec3 centre(23.3, 23.6, 23.8);
  const LatticeResult result = lattice_of(voxels_of(
      frame_of({48, 48, 48}), {0, 1}, [&](const Vec3& p) { return (p - centre).norm() < 15 ? 1 : 0; }));
  EXPECT_EQ(joined(result.report.notes), "");
  EXPECT_EQ(result.report.deviating_points, 0U);
}

TEST(LatticeNotes, AVolumeThatIsLostIsSaid) {
  const Vec3 centre(15.6, 15.4, 15.5);
  const Vec3 axis = Vec3(0.3, 0.2, 1).normalized();
  const LabelImage image = voxels_of(frame_of({32, 32, 32}), {0, 7}, [&](const Vec3& p) {
    const Vec3 d = p - centre;
    return (d - axis * axis.dot(d)).norm() < 1 ? 1 : 0;  // two voxels thick
  });
  LatticeOptions coarse;
  coarse.spacing_mm = 3;
  coarse.max_refinement = 1;  // Else the lattice is fine enough.
  const LatticeResult result = lattice_of(image, coarse);
  const auto voxels = static_cast<double>(
      std::count_if(image.voxels().begin(), image.voxels().end(), [](auto v) { return v != 0; }));
  const double lost_percent = 100 * (1 - test::label_volumes(result.mesh).at(7) / voxels);
  ASSERT_GT(lost_percent, 5);
  const std::string notes = joined(result.report.notes);
  const std::string begin = "label 7 fills ";
  const std::size_t at = notes.find(begin);
  ASSERT_NE(at, std::string::npos) << notes;
  EXPECT_NEAR(std::stod(notes.substr(at + begin.size())), lost_percent, 0.051);
  EXPECT_NE(notes.find(" % less than its voxels;", at), std::string::npos) << notes;
}

TEST(LatticeNotes, APinThatIsMissedIsSaid) {
  const Vec3 centre(23.3, 23.6, 17.8);
  constexpr double kTop = 41;  // of a pin on the ball, 8 voxels long
  const auto in_pin = [&](const Vec3& p) {
    return std::hypot(p.x() - centre.x(), p.y() - centre.y()) < 1.5 && p.z() > centre.z() && p.z() <= kTop;
  };
  const LabelImage image = voxels_of(frame_of({48, 48, 48}), {0, 1}, [&](const Vec3& p) {
    return (p - centre).norm() < 15 || in_pin(p) ? 1 : 0;
  });
  LatticeOptions options;
  options.spacing_mm = 10;
  options.max_refinement = 0;
  const LatticeResult result = lattice_of(image, options);
  EXPECT_GT(result.report.deviating_points, 0U);
  const double off_mm = test::worst_distance_mm(image, result.mesh);
  ASSERT_GT(off_mm, 2.5) << "or a triangle may be further off";
  const double from_domain_mm =
      test::worst_distance_from_domain_mm(image, ImageDomain(image, {}), result.mesh);
  EXPECT_NEAR(result.report.furthest_deviation_mm, from_domain_mm, 1e-9);
  EXPECT_NEAR(from_domain_mm, off_mm, 0.87) << "the pin's end is round in the domain";
  EXPECT_NE(joined(result.report.notes).find(" points are off by more than 1.25 voxels"), std::string::npos);
}

}  // namespace
}  // namespace lumesh
