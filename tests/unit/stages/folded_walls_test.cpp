// Warnings of folded walls.
#include "lumesh/stages/folded_walls.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "fixtures/images.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/lattice/lattice.hpp"

namespace lumesh {
namespace {

TEST(FoldedWalls, AreCountedWithThePlaceOfTheWorst) {
  const LabelImage image = fixtures::voxels_of(fixtures::frame_of({20, 20, 24}), {0, 1}, [](const Vec3& p) {
    return std::hypot(p.x() - 9.3, p.y() - 9.6) < 6 ? 1 : 0;
  });
  const ImageDomain domain(image, {});
  Context context;
  MixedMesh mesh = mesh_lattice(image, domain, {}, context).mesh;
  EXPECT_TRUE(note_of_folds(mesh.view(), domain).empty());

  const auto name_of = [&](std::size_t t) {
    return mesh.info.patches[static_cast<std::size_t>(mesh.triangle_patches[t])].name;
  };
  std::size_t turned = 0;
  while (name_of(turned) != "wall") ++turned;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)  // Those of openings have no wall to face.
    if (t == turned || name_of(t) != "wall") std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
  const auto& [a, b, c] = mesh.triangles[turned];
  const std::vector<std::string> notes = note_of_folds(mesh.view(), domain);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("1 triangle faces against"), std::string::npos) << notes[0];
  const std::string place = place_text((mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3);
  EXPECT_NE(notes[0].find(place), std::string::npos) << notes[0] << ", not at " << place;
}

}  // namespace
}  // namespace lumesh
