#include "lumesh/mesh/tet_mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "fixtures/mesh_walks.hpp"
#include "fixtures/meshes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/mesh/triangle_mesh.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

double volume(const TetMesh& mesh) {
  double sum = 0;
  for (const Cell<4>& t : mesh.tets())
    sum += tetrahedron_volume(mesh.points()[t[0]], mesh.points()[t[1]], mesh.points()[t[2]],
                              mesh.points()[t[3]]);
  return sum;
}

/// The message of the kBadInput error that building gives; empty if there is none.
std::string refusal(const fixtures::TetSoup& soup) {
  try {
    static_cast<void>(soup.build());
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    return error.what();
  }
  return {};
}

TEST(Fixtures, HaveTheirVolumesAndCounts) {
  EXPECT_NEAR(volume(fixtures::single_tet().build()), 1.0 / 6, 1e-15);
  EXPECT_NEAR(volume(fixtures::cube_of_5().build()), 1, 1e-15);
  EXPECT_NEAR(volume(fixtures::cube_of_6().build()), 1, 1e-15);
  EXPECT_NEAR(volume(fixtures::cube_grid(3).build()), 27, 1e-12);
  const TetMesh bcc = fixtures::bcc_block(3).build();
  EXPECT_EQ(bcc.tet_count(), 12u * 9 * 2);
  EXPECT_NEAR(volume(bcc), 216.0 / 12, 1e-12);  // A twelfth of a cell each.
}

TEST(TetMeshBuild, LinksAreMutualAndShareTheFace) {
  const TetMesh mesh = fixtures::bcc_block(4).build();
  int inner = 0, outer = 0;
  for (std::uint32_t i = 0; i < mesh.tet_count(); ++i)
    for (int f = 0; f < 4; ++f) {
      const FaceLink link = mesh.link(TetId(i), f);
      if (link.is_boundary()) {
        ++outer;
        continue;
      }
      ++inner;
      EXPECT_EQ(mesh.link(link.tet(), link.face()), FaceLink::to(TetId(i), f));
      const Cell<3> a = mesh.face_corners(TetId(i), f), b = mesh.face_corners(link.tet(), link.face());
      EXPECT_EQ(std::set(a.begin(), a.end()), std::set(b.begin(), b.end()));
    }
  EXPECT_EQ(inner + outer, 4 * 12 * 16 * 3);
  // Behind each of the 6 n^2 border squares four faces are open, but where two border squares of a cell meet
  // (12 n edges) the face of either is missing with the tetrahedra on both its sides.
  EXPECT_EQ(outer, 6 * 16 * 4 - 2 * 12 * 4);
}

TEST(TetMeshBuild, FacesPointOutOfTheMesh) {
  const TetMesh mesh = fixtures::cube_grid(3).build();
  const BoundaryFaces faces = mesh.boundary_faces();
  EXPECT_EQ(faces.triangles.size(), 6u * 9 * 2);
  for (const auto& [a, b, c] : faces.triangles) {
    const Vec3 pa = mesh.points()[a], pb = mesh.points()[b], pc = mesh.points()[c];
    EXPECT_GT((pb - pa).cross(pc - pa).dot((pa + pb + pc) / 3 - Vec3(1.5, 1.5, 1.5)), 0);
  }
}

TEST(TetMeshBuild, NamesPatchesByTheLabelsThatMeet) {
  const TetMesh mesh = fixtures::two_label_block(4).build();
  ASSERT_EQ(mesh.info().patches.size(), 3u);
  EXPECT_EQ(mesh.info().patches[0].name, "wall_1");
  EXPECT_EQ(mesh.info().patches[1].name, "wall_2");
  EXPECT_EQ(mesh.info().patches[2].name, "interface_1_2");
  EXPECT_EQ(mesh.info().patches[2].kind, PatchKind::kInterface);
  const BoundaryFaces faces = mesh.boundary_faces();
  std::map<std::int32_t, int> count;
  for (std::size_t i = 0; i < faces.triangles.size(); ++i) {
    ++count[faces.patches[i]];
    if (faces.patches[i] != 2) continue;
    const auto& [a, b, c] = faces.triangles[i];
    const Vec3 pa = mesh.points()[a], pb = mesh.points()[b], pc = mesh.points()[c];
    EXPECT_EQ(pa.x(), 2);
    EXPECT_EQ((pb - pa).cross(pc - pa), Vec3(1, 0, 0));  // Out of label 1, which lies at lower x.
    EXPECT_EQ(mesh.label(faces.tets[i][0]), 1);
    EXPECT_EQ(mesh.label(faces.tets[i][1]), 2);
  }
  EXPECT_EQ(count[2], 32);           // 4 x 4 squares of two triangles.
  EXPECT_EQ(count[0], 32 + 4 * 16);  // One end and half of four sides.
  EXPECT_EQ(count[1], 32 + 4 * 16);
  EXPECT_EQ(fixtures::cube_of_5().build().info().patches[0].name, "wall");
}

TEST(TetMeshBuild, NamesPatchesAfterLabelsThatHaveNames) {
  const auto soup = fixtures::two_label_block(2);
  MeshInfo info;
  info.label_names = {{2, "left ICA"}};
  const TetMesh mesh = TetMesh::build(soup.points, soup.tets, soup.labels, info);
  EXPECT_EQ(mesh.info().patches[0].name, "wall_1");
  EXPECT_EQ(mesh.info().patches[1].name, "wall_left_ICA");
  EXPECT_EQ(mesh.info().patches[2].name, "interface_1_left_ICA");
}

TEST(TetMeshBuild, TellsABackgroundRegionFromTheOutside) {
  auto soup = fixtures::two_label_block(2);
  for (Label& label : soup.labels) label -= 1;  // Labels 0 and 1.
  const TetMesh mesh = soup.build();
  ASSERT_EQ(mesh.info().patches.size(), 3u);
  EXPECT_EQ(mesh.info().patches[2].name, "interface_0_1");
}

/// Patch 0 to 5 for the six sides of [0, n]^3.
std::int32_t side_of(const Vec3& center, double n) {
  for (int axis = 0; axis < 3; ++axis) {
    if (center[axis] == 0) return 2 * axis;
    if (center[axis] == n) return 2 * axis + 1;
  }
  return -1;
}

TEST(TetMeshBuild, DerivesCornersAndCurvesFromPatches) {
  const int n = 4;
  const auto soup = fixtures::cube_grid(n);
  MeshInfo info;
  info.patches.resize(6);
  const PatchChooser by_side = [&](Label, Label, const Cell<3>& v) {
    return side_of((soup.points[v[0]] + soup.points[v[1]] + soup.points[v[2]]) / 3, n);
  };
  const TetMesh mesh = TetMesh::build(soup.points, soup.tets, soup.labels, by_side, info);
  std::map<VertexDimension, int> count;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) ++count[mesh.dimension(VertexId(v))];
  EXPECT_EQ(count[VertexDimension::kCorner], 8);
  EXPECT_EQ(count[VertexDimension::kCurve], 12 * (n - 1));
  EXPECT_EQ(count[VertexDimension::kSurface], 6 * (n - 1) * (n - 1));
  EXPECT_EQ(count[VertexDimension::kVolume], (n - 1) * (n - 1) * (n - 1));
}

TEST(TetMeshBuild, RimOfAnInterfaceIsACurve) {
  const TetMesh mesh = fixtures::two_label_block(4).build();
  int curve = 0;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const bool on_rim =
        mesh.points()[v].x() == 2 && side_of(Vec3(2, mesh.points()[v].y(), mesh.points()[v].z()), 4) >= 0;
    EXPECT_EQ(mesh.dimension(VertexId(v)) == VertexDimension::kCurve, on_rim);
    curve += on_rim;
  }
  EXPECT_EQ(curve, 16);
}

TEST(TetMeshBuild, TakesPatchesFromATableAndGivesThemBack) {
  const TetMesh first = fixtures::two_label_block(2).build();
  BoundaryFaces faces = first.boundary_faces();
  std::mt19937 random(5);
  for (Cell<3>& triangle : faces.triangles) std::shuffle(triangle.begin(), triangle.end(), random);
  const TetMesh second = TetMesh::build(first.view(faces));
  const BoundaryFaces again = second.boundary_faces();
  EXPECT_EQ(again.patches, faces.patches);
  EXPECT_EQ(again.triangles, first.boundary_faces().triangles);
  EXPECT_EQ(second.info().patches.size(), 3u);
}

TEST(TetMeshBuild, RefusesBrokenInputWithTheReason) {
  auto soup = fixtures::cube_of_6();
  soup.tets[2][1] = 8;
  EXPECT_NE(refusal(soup).find("tetrahedron 2"), std::string::npos);
  soup = fixtures::cube_of_6();
  std::swap(soup.tets[3][0], soup.tets[3][1]);
  EXPECT_NE(refusal(soup).find("tetrahedron 3 (6, 0, 4, 7) is inverted"), std::string::npos);
  soup = fixtures::cube_of_6();
  soup.points[7] = Vec3(0.5, 0.5, 0);
  EXPECT_NE(refusal(soup).find("inverted or flat"), std::string::npos);
  soup = fixtures::cube_of_6();
  soup.points[4].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal(soup).find("vertex 4"), std::string::npos);
  soup = fixtures::cube_of_6();
  soup.labels.pop_back();
  EXPECT_NE(refusal(soup).find("5 labels"), std::string::npos);
  soup = fixtures::cube_of_6();
  soup.labels[1] = -1;
  EXPECT_NE(refusal(soup).find("negative label"), std::string::npos);
  soup = fixtures::single_tet();
  soup.points.insert(soup.points.end(), {Vec3(0.1, 0.1, -1), Vec3(0.3, 0.3, -1)});
  soup.tets.insert(soup.tets.end(), {{0, 2, 1, 4}, {0, 2, 1, 5}});  // All three at face (0, 1, 2).
  soup.labels = {1, 1, 1};
  EXPECT_NE(refusal(soup).find("belongs to 3 tetrahedra"), std::string::npos);
  soup = fixtures::single_tet();
  soup.points.emplace_back(0.1, 0.1, 0.5);
  soup.tets.push_back({0, 1, 2, 4});  // Overlaps the first on the same side of face (0, 1, 2).
  soup.labels.push_back(1);
  EXPECT_NE(refusal(soup).find("same side"), std::string::npos);
}

TEST(TetMeshBuild, RefusesTablesThatDoNotFitTheBoundary) {
  const TetMesh mesh = fixtures::cube_of_6().build();
  const auto refused = [&](const BoundaryFaces& faces) {
    try {
      static_cast<void>(TetMesh::build(mesh.view(faces)));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  BoundaryFaces faces = mesh.boundary_faces();
  EXPECT_EQ(refused(faces), "");
  faces.triangles.pop_back();
  faces.patches.pop_back();
  EXPECT_NE(refused(faces).find("has no patch"), std::string::npos);
  faces = mesh.boundary_faces();
  faces.triangles.push_back({0, 1, 7});  // Between two tetrahedra of one label.
  faces.patches.push_back(0);
  EXPECT_NE(refused(faces).find("remove it"), std::string::npos);
  faces = mesh.boundary_faces();
  faces.patches[3] = 9;
  EXPECT_NE(refused(faces).find("patch 9"), std::string::npos);
  faces = mesh.boundary_faces();
  faces.triangles.push_back(faces.triangles[0]);
  faces.patches.push_back(1);
  EXPECT_NE(refused(faces).find("twice"), std::string::npos);
}

TEST(TetMeshBuild, IsTheSameForEveryThreadCount) {
  const auto soup = fixtures::two_label_block(20);
  const auto links = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    const TetMesh mesh = soup.build();
    std::vector<std::uint32_t> all;
    for (std::uint32_t t = 0; t < mesh.tet_count(); ++t)
      for (int f = 0; f < 4; ++f) {
        const FaceLink link = mesh.link(TetId(t), f);
        all.push_back(link.is_boundary() ? link.patch().value : link.tet().value);
        all.push_back(mesh.patch(TetId(t), f).value);
      }
    return all;
  };
  EXPECT_EQ(links(1), links(8));
}

TEST(TetMesh, ViewSharesItsArrays) {
  const TetMesh mesh = fixtures::cube_of_5().build();
  const MeshView view = mesh.view();
  EXPECT_EQ(view.points.data(), mesh.points().data());
  EXPECT_EQ(view.tetrahedra.size(), 5u);
  EXPECT_EQ(view.info, &mesh.info());
}

TEST(TetMesh, GrowsWithoutMovingAndCompactsAway) {
  TetMesh mesh = fixtures::cube_grid(2).build();
  mesh.enable_metric();
  mesh.set_metric(VertexId(3), SymTensor::diagonal(1, 2, 3), SymTensor::diagonal(4, 5, 6));
  mesh.set_quality(TetId(5), 0.5f);
  const Vec3* const first_point = mesh.points().data();
  const std::uint32_t tets = mesh.tet_count(), vertices = mesh.vertex_count();
  mesh.set_owners(3, 8);
  std::vector<VertexId> added;
  for (int i = 0; i < 1000; ++i) added.push_back(mesh.add_vertex(Vec3(i, 0, 0), i % 3));
  const TetId extra = mesh.add_tet({0, 1, 2, 3}, 7, 1);
  EXPECT_EQ(mesh.points().data(), first_point);
  EXPECT_EQ(mesh.point(added[500]), Vec3(500, 0, 0));
  EXPECT_EQ(mesh.tet_count(), tets + 1);
  EXPECT_TRUE(mesh.alive(extra));
  EXPECT_FALSE(mesh.is_compact());
  mesh.free_tet(extra, 1);
  EXPECT_FALSE(mesh.alive(extra));
  EXPECT_EQ(mesh.add_tet({0, 1, 2, 3}, 7, 1), extra);  // The freeing owner gets the slot again.
  mesh.free_tet(extra, 1);
  for (std::size_t i = 0; i < added.size(); ++i) mesh.free_vertex(added[i], static_cast<int>(i % 3));
  mesh.compact();
  EXPECT_TRUE(mesh.is_compact());
  EXPECT_EQ(mesh.vertex_count(), vertices);
  EXPECT_EQ(mesh.tet_count(), tets);
  EXPECT_EQ(mesh.metric(VertexId(3)), SymTensor::diagonal(1, 2, 3));
  EXPECT_EQ(mesh.log_metric(VertexId(3)), SymTensor::diagonal(4, 5, 6));
  EXPECT_EQ(mesh.quality(TetId(5)), 0.5f);
  EXPECT_NEAR(volume(mesh), 8, 1e-12);
}

TEST(TetMesh, ReordersAlongTheCurveAndStaysTheSameMesh) {
  TetMesh mesh = fixtures::cube_grid(4).build();
  mesh.enable_metric();
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3& p = mesh.point(VertexId(v));
    mesh.set_metric(VertexId(v), SymTensor::diagonal(1 + p[0], 1 + p[1], 1 + p[2]), {});
  }
  const std::uint32_t vertices = mesh.vertex_count(), tets = mesh.tet_count();
  mesh.add_vertex(Vec3(1, 1, 1));  // Leaves a dead slot behind.
  mesh.free_vertex(VertexId(vertices));
  mesh.reorder_along_curve();
  EXPECT_EQ(mesh.vertex_count(), vertices);
  EXPECT_EQ(mesh.tet_count(), tets);
  EXPECT_TRUE(validate(mesh).ok()) << validate(mesh).text();
  EXPECT_NEAR(volume(mesh), 64, 1e-12);
  double jumps = 0;
  for (std::uint32_t v = 0; v < vertices; ++v) {
    const Vec3& p = mesh.point(VertexId(v));
    EXPECT_EQ(mesh.metric(VertexId(v)), SymTensor::diagonal(1 + p[0], 1 + p[1], 1 + p[2]));
    if (v > 0) jumps += (p - mesh.point(VertexId(v - 1))).norm();
  }
  EXPECT_LT(jumps / vertices, 1.6);  // Random order: about 2.6.
  for (std::uint32_t t = 1; t < tets; ++t) {
    const auto lowest = [&](std::uint32_t i) {
      return std::min({mesh.tets()[i][0], mesh.tets()[i][1], mesh.tets()[i][2], mesh.tets()[i][3]});
    };
    EXPECT_LE(lowest(t - 1), lowest(t));
  }
}

TEST(TetMesh, CompactClosesGapsInTheMiddle) {
  TetMesh mesh = fixtures::cube_of_6().build();
  // Takes away tetrahedron 0 (0, 1, 3, 7); its neighbours get a boundary instead.
  for (int f = 0; f < 4; ++f) {
    const FaceLink link = mesh.link(TetId(0), f);
    if (!link.is_boundary()) mesh.set_link(link.tet(), link.face(), FaceLink::boundary(PatchId(0)));
  }
  mesh.free_tet(TetId(0));
  mesh.compact();
  EXPECT_EQ(mesh.tet_count(), 5u);
  EXPECT_EQ(mesh.tets()[0], (Cell<4>{0, 3, 2, 7}));  // The order stays.
  EXPECT_NEAR(volume(mesh), 5.0 / 6, 1e-15);
  int links = 0;
  for (std::uint32_t t = 0; t < 5; ++t)
    for (int f = 0; f < 4; ++f)
      if (const FaceLink link = mesh.link(TetId(t), f); !link.is_boundary()) {
        ++links;
        EXPECT_EQ(mesh.link(link.tet(), link.face()), FaceLink::to(TetId(t), f));
      }
  EXPECT_EQ(links, 8);  // Five in a fan: four inner faces.
}

TEST(Walks, StarsOfTheLatticeHaveTwentyFourTetrahedra) {
  const TetMesh mesh = fixtures::bcc_block(4).build();
  VertexStar star;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 p = mesh.points()[v];
    if (!mesh.incident_tet(VertexId(v)).valid()) continue;
    const auto tets = star.gather(mesh, VertexId(v));
    for (const TetId t : tets) EXPECT_GE(mesh.index_of(t, VertexId(v)), 0);
    EXPECT_EQ(std::set<TetId>(tets.begin(), tets.end()).size(), tets.size());
    if (p.minCoeff() > 0.9 && p.maxCoeff() < 3.1) {
      EXPECT_EQ(tets.size(), 24u) << p.transpose();
    }
  }
}

TEST(Walks, StarCopesWithVeryManyTetrahedra) {
  // A fan of 3000 tetrahedra around the edge (0, 1).
  fixtures::TetSoup fan{{{0, 0, 0}, {0, 0, 1}}, {}, {}};
  const std::uint32_t count = 3000;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    fan.points.emplace_back(std::cos(angle), std::sin(angle), 0.5);
    fan.tets.push_back({0, 1, 2 + i, 2 + (i + 1) % count});
    fan.labels.push_back(1);
  }
  const TetMesh mesh = fan.build();
  std::size_t seen = 0;
  fixtures::for_each_tet_around(mesh, VertexId(1), [&](TetId) { ++seen; });
  EXPECT_EQ(seen, count);
  std::vector<TetId> ring;
  const fixtures::RingKind kind = fixtures::for_each_tet_around_edge(mesh, TetId(5), VertexId(0), VertexId(1),
                                                                     [&](TetId t) { ring.push_back(t); });
  EXPECT_EQ(kind, fixtures::RingKind::kClosed);
  EXPECT_EQ(std::set(ring.begin(), ring.end()).size(), count);
  EXPECT_EQ(ring.size(), count);
}

TEST(Walks, RingsCloseInsideAndOpenOnTheBoundary) {
  const TetMesh mesh = fixtures::cube_of_6().build();
  const auto ring_size = [&](TetId t, std::uint32_t a, std::uint32_t b, fixtures::RingKind expected) {
    std::set<TetId> ring;
    EXPECT_EQ(fixtures::for_each_tet_around_edge(mesh, t, VertexId(a), VertexId(b),
                                                 [&](TetId u) { EXPECT_TRUE(ring.insert(u).second); }),
              expected);
    return ring.size();
  };
  EXPECT_EQ(ring_size(TetId(2), 0, 7, fixtures::RingKind::kClosed), 6u);  // The diagonal.
  EXPECT_EQ(ring_size(TetId(0), 0, 1, fixtures::RingKind::kOpen), 2u);
  EXPECT_EQ(ring_size(TetId(0), 1, 3, fixtures::RingKind::kOpen), 1u);
}

TEST(TriangleMeshExtraction, GivesTheClosedOutside) {
  const TetMesh mesh = fixtures::two_label_block(4).build();
  const TriangleMesh surface = extract_boundary(mesh);
  double enclosed = 0;
  for (const auto& [a, b, c] : surface.triangles)
    enclosed += surface.points[a].dot(surface.points[b].cross(surface.points[c])) / 6;
  EXPECT_NEAR(enclosed, 64, 1e-12);  // The 4^3 block.
  std::size_t v = 0;                 // Points keep the order that they have in the mesh.
  for (const Vec3& point : surface.points) {
    while (v < mesh.points().size() && mesh.points()[v] != point) ++v;
    ASSERT_LT(v++, mesh.points().size());
  }
  EXPECT_EQ(surface.triangles.size(), 192u);
}

}  // namespace
}  // namespace lumesh
