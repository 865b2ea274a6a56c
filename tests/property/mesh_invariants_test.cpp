// Breaks each invariant of a valid mesh at random places; validate() must notice every time.

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "fixtures/meshes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/validate.hpp"

namespace lumesh {
namespace {

using Random = std::mt19937;

/// A block with random interior vertices and random labels in slabs, still valid.
TetMesh random_mesh(Random& random) {
  auto soup = fixtures::two_label_block(2 * std::uniform_int_distribution(1, 3)(random));
  const double n = soup.points.back().x();
  std::uniform_real_distribution<double> jitter(-0.08, 0.08);
  for (Vec3& p : soup.points)
    if (p.minCoeff() > 0 && p.maxCoeff() < n) p += Vec3(jitter(random), jitter(random), jitter(random));
  return soup.build();
}

TetId random_tet(const TetMesh& mesh, Random& random) {
  return TetId(std::uniform_int_distribution<std::uint32_t>(0, mesh.tet_count() - 1)(random));
}

VertexId random_vertex(const TetMesh& mesh, Random& random) {
  return VertexId(std::uniform_int_distribution<std::uint32_t>(0, mesh.vertex_count() - 1)(random));
}

struct Face {
  TetId tet;
  int face;
};

/// A random face that `wanted` accepts.
Face random_face(const TetMesh& mesh, Random& random, const std::function<bool(const Face&)>& wanted) {
  for (;;) {
    const Face face{random_tet(mesh, random), std::uniform_int_distribution(0, 3)(random)};
    if (wanted(face)) return face;
  }
}

Face random_open_face(const TetMesh& mesh, Random& random) {
  return random_face(mesh, random, [&](const Face& f) { return mesh.link(f.tet, f.face).is_boundary(); });
}
Face random_shared_face(const TetMesh& mesh, Random& random) {
  return random_face(mesh, random, [&](const Face& f) { return !mesh.link(f.tet, f.face).is_boundary(); });
}
Face random_interface(const TetMesh& mesh, Random& random) {
  return random_face(mesh, random,
                     [&](const Face& f) { return mesh.interface_patch(f.tet, f.face).valid(); });
}

struct Damage {
  const char* name;
  std::function<void(TetMesh&, Random&)> apply;
  const char* expected;  ///< Must occur in the report.
};

std::ostream& operator<<(std::ostream& out, const Damage& damage) {
  return out << damage.name;
}

void swap_corners(TetMesh& mesh, Random& random) {
  const TetId t = random_tet(mesh, random);
  Cell<4> tet = mesh.tet(t);
  std::swap(tet[0], tet[3]);
  mesh.set_tet(t, tet);
}

void rotate_corners(TetMesh& mesh, Random& random) {
  const TetId t =
      random_tet(mesh, random);  // An even permutation: still positive, but the faces are renumbered.
  const Cell<4> tet = mesh.tet(t);
  mesh.set_tet(t, {tet[1], tet[2], tet[0], tet[3]});
}

void redirect_link(TetMesh& mesh, Random& random) {
  const Face face = random_shared_face(mesh, random);
  const FaceLink old = mesh.link(face.tet, face.face);
  const TetId other((old.tet().value + 1) % mesh.tet_count());
  mesh.set_link(face.tet, face.face, FaceLink::to(other, old.face()));
}

void turn_link_face(TetMesh& mesh, Random& random) {
  const Face face = random_shared_face(mesh, random);
  const FaceLink old = mesh.link(face.tet, face.face);
  mesh.set_link(face.tet, face.face, FaceLink::to(old.tet(), (old.face() + 1) % 4));
}

void link_beyond_the_end(TetMesh& mesh, Random& random) {
  const Face face = random_shared_face(mesh, random);
  mesh.set_link(face.tet, face.face, FaceLink::to(TetId(mesh.tet_slots() + 5), 0));
}

void open_one_side(TetMesh& mesh, Random& random) {
  const Face face = random_shared_face(mesh, random);
  mesh.set_link(face.tet, face.face, FaceLink::boundary(PatchId(0)));
}

void cut_both_sides(TetMesh& mesh, Random& random) {
  const Face face = random_face(mesh, random, [&](const Face& f) {
    return !mesh.link(f.tet, f.face).is_boundary() && !mesh.interface_patch(f.tet, f.face).valid();
  });
  const FaceLink other = mesh.link(face.tet, face.face);
  mesh.set_link(face.tet, face.face, FaceLink::boundary(PatchId(0)));
  mesh.set_link(other.tet(), other.face(), FaceLink::boundary(PatchId(0)));
}

void drop_wall_patch(TetMesh& mesh, Random& random) {
  const Face face = random_open_face(mesh, random);
  mesh.set_link(face.tet, face.face, FaceLink());
}

void unknown_wall_patch(TetMesh& mesh, Random& random) {
  const Face face = random_open_face(mesh, random);
  mesh.set_link(face.tet, face.face, FaceLink::boundary(PatchId(77)));
}

void drop_interface_patch(TetMesh& mesh, Random& random) {
  const Face face = random_interface(mesh, random);
  const FaceLink other = mesh.link(face.tet, face.face);
  mesh.set_interface_patch(face.tet, face.face, PatchId());
  mesh.set_interface_patch(other.tet(), other.face(), PatchId());
}

void differ_across_interface(TetMesh& mesh, Random& random) {
  const Face face = random_interface(mesh, random);
  mesh.set_interface_patch(face.tet, face.face,
                           PatchId(mesh.interface_patch(face.tet, face.face).value == 0 ? 1 : 0));
}

void patch_within_a_label(TetMesh& mesh, Random& random) {
  const Face face = random_face(mesh, random, [&](const Face& f) {
    return !mesh.link(f.tet, f.face).is_boundary() && !mesh.interface_patch(f.tet, f.face).valid();
  });
  mesh.set_interface_patch(face.tet, face.face, PatchId(0));
}

void change_label(TetMesh& mesh, Random& random) {
  const TetId t = random_tet(mesh, random);
  mesh.set_label(t, mesh.label(t) + 10);
}

void misdirect_vertex(TetMesh& mesh, Random& random) {
  const VertexId v = random_vertex(mesh, random);
  for (;;) {
    const TetId t = random_tet(mesh, random);
    if (mesh.index_of(t, v) < 0) return mesh.set_incident_tet(v, t);
  }
}

void forget_vertex(TetMesh& mesh, Random& random) {
  mesh.set_incident_tet(random_vertex(mesh, random), TetId());
}

void move_through_a_face(TetMesh& mesh, Random& random) {
  const TetId t = random_tet(mesh, random);
  const Vec3 center = (mesh.corner(t, 1) + mesh.corner(t, 2) + mesh.corner(t, 3)) / 3;
  mesh.set_point(mesh.vertex(t, 0), center + 0.5 * (center - mesh.corner(t, 0)));
}

void put_on_the_plane_of_a_face(TetMesh& mesh, Random& random) {
  const TetId t = random_tet(mesh, random);
  mesh.set_point(mesh.vertex(t, 0), mesh.corner(t, 1));
}

void lose_a_coordinate(TetMesh& mesh, Random& random) {
  const VertexId v = random_vertex(mesh, random);
  mesh.set_point(v, Vec3(mesh.point(v).x(), std::numeric_limits<double>::quiet_NaN(), 0));
}

/// Glues a second, separate block to the first at one vertex: every link stays consistent.
void pinch_a_vertex(TetMesh& mesh, Random& random) {
  const VertexId shared = random_vertex(mesh, random);
  const Vec3 at = mesh.point(shared);
  const auto at_offset = [&](double x, double y, double z) { return mesh.add_vertex(at + Vec3(x, y, z)); };
  const VertexId b = at_offset(50, 0, 0), c = at_offset(0, 50, 0), d = at_offset(0, 0, 50);
  const TetId t = mesh.add_tet({shared.value, b.value, c.value, d.value}, 1);
  for (const VertexId v : {b, c, d}) {
    mesh.set_incident_tet(v, t);
    mesh.set_dimension(v, VertexDimension::kSurface);
  }
  for (int f = 0; f < 4; ++f) mesh.set_link(t, f, FaceLink::boundary(PatchId(0)));
}

void add_a_stray_vertex(TetMesh& mesh, Random&) {
  mesh.add_vertex(Vec3(0.5, 0.5, 0.5));
}

void kill_a_tet_in_use(TetMesh& mesh, Random& random) {
  mesh.free_tet(random_tet(mesh, random));
}

void misjudge_a_dimension(TetMesh& mesh, Random& random) {
  const VertexId v = random_vertex(mesh, random);
  mesh.set_dimension(v, mesh.dimension(v) == VertexDimension::kVolume ? VertexDimension::kSurface
                                                                      : VertexDimension::kVolume);
}

class EveryDamage : public testing::TestWithParam<Damage> {};

TEST_P(EveryDamage, IsFoundByValidate) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    TetMesh mesh = random_mesh(random);
    const ValidationReport before = validate(mesh);
    ASSERT_TRUE(before.ok()) << "seed " << seed << "\n" << before.text();
    GetParam().apply(mesh, random);
    const ValidationReport after = validate(mesh);
    ASSERT_FALSE(after.ok()) << "seed " << seed;
    ASSERT_NE(after.text().find(GetParam().expected), std::string::npos) << "seed " << seed << "\n"
                                                                         << after.text();
  }
}

INSTANTIATE_TEST_SUITE_P(
    Invariants, EveryDamage,
    testing::Values(Damage{"SwapCorners", swap_corners, "is inverted"},
                    Damage{"RotateCorners", rotate_corners, "does not match"},
                    Damage{"RedirectLink", redirect_link, "is linked to"},
                    Damage{"TurnLinkFace", turn_link_face, "is linked to"},
                    Damage{"LinkBeyondTheEnd", link_beyond_the_end, "cannot be its neighbour"},
                    Damage{"OpenOneSide", open_one_side, "not linked back"},
                    Damage{"CutBothSides", cut_both_sides, "are not linked"},
                    Damage{"DropWallPatch", drop_wall_patch, "patch is not in the list"},
                    Damage{"UnknownWallPatch", unknown_wall_patch, "patch is not in the list"},
                    Damage{"DropInterfacePatch", drop_interface_patch, "no patch of the list"},
                    Damage{"DifferAcrossInterface", differ_across_interface, "another patch"},
                    Damage{"PatchWithinALabel", patch_within_a_label, "within one label"},
                    Damage{"ChangeLabel", change_label, "no patch of the list"},
                    Damage{"MisdirectVertex", misdirect_vertex, "does not contain it"},
                    Damage{"ForgetVertex", forget_vertex, "linked to no tetrahedron"},
                    Damage{"MoveThroughAFace", move_through_a_face, "is inverted"},
                    Damage{"PutOnThePlaneOfAFace", put_on_the_plane_of_a_face, "is flat"},
                    Damage{"LoseACoordinate", lose_a_coordinate, "not finite"},
                    Damage{"PinchAVertex", pinch_a_vertex, "connected through faces"},
                    Damage{"AddAStrayVertex", add_a_stray_vertex, "used by no tetrahedron"},
                    Damage{"KillATetInUse", kill_a_tet_in_use, "is linked to tetrahedron"},
                    Damage{"MisjudgeADimension", misjudge_a_dimension, "dimension is that of"}),
    [](const testing::TestParamInfo<Damage>& param) { return std::string(param.param.name); });

/// The same questions answered the plain way: by counting in maps.
struct PlainCount {
  bool face_crowded = false;  ///< A face with three tetrahedra, or two on one side.
  bool edge_crowded = false;  ///< An edge of the open faces with other than two of them.

  explicit PlainCount(const std::vector<Cell<4>>& tets) {
    std::map<std::set<std::uint32_t>, std::vector<Cell<3>>> faces;
    for (const auto& [a, b, c, d] : tets)
      for (const Cell<3>& face : {Cell<3>{b, c, d}, Cell<3>{a, d, c}, Cell<3>{a, b, d}, Cell<3>{a, c, b}})
        faces[{face[0], face[1], face[2]}].push_back(face);
    std::map<std::set<std::uint32_t>, int> open_edges;
    for (auto& [corners, sides] : faces) {
      for (Cell<3>& side : sides)
        std::rotate(side.begin(), std::min_element(side.begin(), side.end()), side.end());
      face_crowded |= sides.size() > 2 || (sides.size() == 2 && sides[0] == sides[1]);
      if (sides.size() == 1)
        for (int i = 0; i < 3; ++i) ++open_edges[{sides[0][i], sides[0][(i + 1) % 3]}];
    }
    for (const auto& [edge, count] : open_edges) edge_crowded |= count != 2;
  }
};

TEST(RandomSoup, IsRefusedOrFoundInvalidExactlyWhenCountingSaysSo) {
  // Random positively oriented tetrahedra on the corners of a cube: they share faces wrongly and pinch edges.
  int crowded = 0, pinched = 0, sound = 0;
  for (unsigned seed = 1; seed <= 3000; ++seed) {
    Random random(seed);
    fixtures::TetSoup soup{fixtures::unit_cube_corners(), {}, {}};
    std::uniform_int_distribution<std::uint32_t> corner(0, 7);
    const int wanted = std::uniform_int_distribution(1, 4)(random);
    while (static_cast<int>(soup.tets.size()) < wanted) {
      const Cell<4> tet = {corner(random), corner(random), corner(random), corner(random)};
      const Vec3 &a = soup.points[tet[0]], &b = soup.points[tet[1]], &c = soup.points[tet[2]],
                 &d = soup.points[tet[3]];
      if (tetrahedron_volume(a, b, c, d) <= 0) continue;
      soup.tets.push_back(tet);
      soup.labels.push_back(1);
    }
    const PlainCount truth(soup.tets);
    if (truth.face_crowded) {
      ++crowded;
      ASSERT_THROW(static_cast<void>(soup.build()), Error) << "seed " << seed;
      continue;
    }
    const std::string report = validate(soup.build()).text();
    const bool found = report.find("instead of 2") != std::string::npos;
    ASSERT_EQ(found, truth.edge_crowded) << "seed " << seed << "\n" << report;
    ++(truth.edge_crowded ? pinched : sound);
  }
  EXPECT_GT(crowded, 300);
  EXPECT_GT(pinched, 300);
  EXPECT_GT(sound, 300);
}

}  // namespace
}  // namespace lumesh
