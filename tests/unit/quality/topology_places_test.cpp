// Meshes of small hexahedra whose topology differs from their image's in places known by construction.
#include "lumesh/quality/topology_places.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <map>

#include "fixtures/images.hpp"
#include "lumesh/quality/surface.hpp"

namespace lumesh::quality {
namespace {

using Shape = std::function<bool(const Vec3&)>;

constexpr int kSize = 16;          // Voxels of 1 mm along each axis.
constexpr int kCellsPerVoxel = 3;  // Voxels' centres lie within cells.

bool in_box(const Vec3& p, const Vec3& low, const Vec3& high) {
  return (p.array() > low.array()).all() && (p.array() < high.array()).all();
}

LabelImage image_of(const Shape& shape) {
  return fixtures::voxels_of(fixtures::frame_of({kSize, kSize, kSize}), {0, 5},
                             [&](const Vec3& p) { return shape(p) ? 1 : 0; });
}

/// Cells of a third of a voxel whose centres are in the shape.
MixedMesh mesh_of(const Shape& shape) {
  MixedMesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> corners;
  const auto corner = [&](int i, int j, int k) {
    const auto [at, is_new] = corners.try_emplace({i, j, k}, static_cast<std::uint32_t>(mesh.points.size()));
    if (is_new) mesh.points.push_back(Vec3(i, j, k) / kCellsPerVoxel - Vec3::Constant(0.5));
    return at->second;
  };
  for (int k = 0; k < kSize * kCellsPerVoxel; ++k)
    for (int j = 0; j < kSize * kCellsPerVoxel; ++j)
      for (int i = 0; i < kSize * kCellsPerVoxel; ++i) {
        if (!shape((Vec3(i, j, k) + Vec3::Constant(0.5)) / kCellsPerVoxel - Vec3::Constant(0.5))) continue;
        mesh.hexahedra.push_back({corner(i, j, k), corner(i + 1, j, k), corner(i + 1, j + 1, k),
                                  corner(i, j + 1, k), corner(i, j, k + 1), corner(i + 1, j, k + 1),
                                  corner(i + 1, j + 1, k + 1), corner(i, j + 1, k + 1)});
        mesh.hexahedron_labels.push_back(5);
      }
  return mesh;
}

std::vector<TopologyPlace> places(const Shape& of_mesh, const Shape& of_image, std::int64_t components,
                                  std::int64_t handles, std::int64_t cavities) {
  const std::vector<TopologyDifference> differences = {
      {5, components, handles, cavities, components - handles + cavities}};
  return find_topology_places(mesh_of(of_mesh).view(), image_of(of_image), differences);
}

bool bar(const Vec3& p) {
  return in_box(p, {1.5, 5.5, 5.5}, {13.5, 8.5, 8.5});
}

TEST(TopologyPlaces, APieceBetweenVoxelsIsExtra) {
  // One cell at the corner of a voxel.
  const auto with_crumb = [](const Vec3& p) {
    return bar(p) || in_box(p, {3.2, 11.2, 11.2}, {3.5, 11.5, 11.5});
  };
  const auto found = places(with_crumb, bar, 1, 0, 0);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].label, 5);
  EXPECT_EQ(found[0].change, TopologyChange::kExtraPiece);
  EXPECT_EQ(found[0].cells, 1U);
  EXPECT_NEAR(found[0].volume_mm3, 1.0 / 27, 1e-12);
  EXPECT_NEAR((found[0].centre_mm - Vec3(3 + 1.0 / 3, 11 + 1.0 / 3, 11 + 1.0 / 3)).norm(), 0, 1e-12);
  EXPECT_EQ(in_words(found[0]), "a piece of 0.037 mm³ (1 cell) that holds no voxel");
}

TEST(TopologyPlaces, AFlatCellBetweenVoxelsOfItsLabelIsExtra) {
  const auto block = [](const Vec3& p) { return in_box(p, {1.5, 1.5, 1.5}, {5.5, 5.5, 5.5}); };
  const auto both = [&](const Vec3& p) { return block(p) || in_box(p, {8.5, 8.5, 8.5}, {12.5, 12.5, 12.5}); };
  MixedMesh mesh = mesh_of(block);
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  const Vec3 corners[] = {{10.4, 9.5, 9.5}, {10.4, 11.4, 9.5}, {10.4, 9.5, 11.4}, {11.2, 10.4, 10.4}};
  mesh.points.insert(mesh.points.end(), std::begin(corners), std::end(corners));
  mesh.tetrahedra.push_back({first, first + 2, first + 1, first + 3});
  mesh.tetrahedron_labels.push_back(5);
  const std::vector<TopologyDifference> differences = {{5, 0, 0, 0, 0}};
  std::map<TopologyChange, int> count;
  for (const TopologyPlace& place : find_topology_places(mesh.view(), image_of(both), differences))
    ++count[place.change];
  EXPECT_EQ(count, (std::map<TopologyChange, int>{{TopologyChange::kExtraPiece, 1},
                                                  {TopologyChange::kMissingPiece, 1}}));
}

TEST(TopologyPlaces, VoxelsWithoutCellsAreMissing) {
  const auto with_voxels = [](const Vec3& p) {
    return bar(p) || in_box(p, {2.5, 10.5, 11.5}, {4.5, 11.5, 12.5});
  };
  const auto found = places(bar, with_voxels, -1, 0, 0);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].change, TopologyChange::kMissingPiece);
  EXPECT_EQ(found[0].voxels, 2U);
  EXPECT_NEAR(found[0].volume_mm3, 2, 1e-12);
  EXPECT_NEAR((found[0].centre_mm - Vec3(3.5, 11, 12)).norm(), 0, 1e-12);
  EXPECT_EQ(found[0].box.low, Index3(3, 11, 12));
  EXPECT_EQ(found[0].box.high, Index3(5, 12, 13));
}

TEST(TopologyPlaces, PiecesThatJoinOrPartDoSoAtTheGap) {
  const auto parted = [](const Vec3& p) { return bar(p) && !(p.x() > 8.5 && p.x() < 9.5); };
  const auto bridged = [&](const Vec3& p) { return parted(p) || (bar(p) && p.y() < 5.9 && p.z() < 5.9); };
  const auto joined = places(bridged, parted, -1, 0, 0);
  ASSERT_EQ(joined.size(), 1U);
  EXPECT_EQ(joined[0].change, TopologyChange::kJoined);
  EXPECT_EQ(joined[0].voxels, 36U);  // From x = 10 on.
  EXPECT_NEAR((joined[0].centre_mm - Vec3(9, 5.6667, 5.6667)).norm(), 0, 1.5);
  const auto split = places(parted, bar, 1, 0, 0);
  ASSERT_EQ(split.size(), 1U);
  EXPECT_EQ(split[0].change, TopologyChange::kSplit);
  EXPECT_NEAR(split[0].volume_mm3, 36, 1e-9);
  EXPECT_NEAR(split[0].centre_mm.x(), 9, 1);
}

/// A square ring about z with a hole 4 voxels wide.
bool ring(const Vec3& p) {
  return in_box(p, {2.5, 2.5, 5.5}, {12.5, 12.5, 8.5}) && !in_box(p, {5.5, 5.5, 5}, {9.5, 9.5, 9});
}

void expect_change(const std::vector<TopologyPlace>& found, TopologyChange change, std::int64_t handles,
                   std::int64_t cavities, const Vec3& centre_mm, double tolerance_mm) {
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].change, change);
  EXPECT_EQ(found[0].handles, handles);
  EXPECT_EQ(found[0].cavities, cavities);
  EXPECT_LT((found[0].centre_mm - centre_mm).norm(), tolerance_mm) << found[0].centre_mm.transpose();
  EXPECT_TRUE((found[0].box.low.array() < found[0].box.high.array()).all());
}

TEST(TopologyPlaces, ARingThatIsCutLosesItsHandleThere) {
  const auto open = [](const Vec3& p) { return ring(p) && !(p.x() > 9 && p.y() > 6.5 && p.y() < 7.5); };
  expect_change(places(open, ring, 0, -1, 0), TopologyChange::kCut, -1, 0, {11, 7, 7}, 1.5);
  expect_change(places(ring, open, 0, 1, 0), TopologyChange::kFilled, 1, 0, {11, 7, 7}, 1.5);
}

TEST(TopologyPlaces, AHoleThatIsClosedTakesTheHandleAway) {
  const auto plate = [](const Vec3& p) { return ring(p) || in_box(p, {5, 5, 6.5}, {10, 10, 7.5}); };
  expect_change(places(plate, ring, 0, -1, 0), TopologyChange::kFilled, -1, 0, {7.5, 7.5, 7}, 2);
  expect_change(places(ring, plate, 0, 1, 0), TopologyChange::kCut, 1, 0, {7.5, 7.5, 7}, 2);
}

TEST(TopologyPlaces, CavitiesAreFoundThatTheMeshHasMoreOrLess) {
  const auto hollow = [](const Vec3& p) { return bar(p) && !in_box(p, {10.5, 6.5, 6.5}, {11.5, 7.5, 7.5}); };
  expect_change(places(hollow, bar, 0, 0, 1), TopologyChange::kCut, 0, 1, {11, 7, 7}, 0.5);
  expect_change(places(bar, hollow, 0, 0, -1), TopologyChange::kFilled, 0, -1, {11, 7, 7}, 1);
}

TEST(TopologyPlaces, AShapeThatOnlyMovedByHalfAVoxelHasNoPlaces) {
  const auto moved = [](const Vec3& p) { return ring(p + Vec3(0.4, 0.4, -0.4)); };
  EXPECT_TRUE(places(moved, ring, 0, 0, 0).empty());
}

TEST(TopologyPlaces, HandlesAreToldApartFromPieces) {
  // A ring cut twice is two pieces: of the two cuts one parts them, the other takes the handle.
  const auto halves = [](const Vec3& p) { return ring(p) && !(p.y() > 6.5 && p.y() < 7.5); };
  const auto found = places(halves, ring, 1, -1, 0);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].change, TopologyChange::kSplit);
  EXPECT_EQ(found[1].change, TopologyChange::kCut);
  EXPECT_EQ(found[1].handles, -1);
}

}  // namespace
}  // namespace lumesh::quality
