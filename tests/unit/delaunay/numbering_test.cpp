// What is done to a triangulation hangs on its points, not on the numbers of its elements: the same points,
// put in in another order, get the same treatment.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>

#include "../src/delaunay/bad_faces.hpp"
#include "../src/delaunay/flat_tets.hpp"
#include "../src/delaunay/topology.hpp"
#include "fixtures/images.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/operators/delaunay_execution.hpp"

namespace lumesh::delaunay {
namespace {

using Place = std::array<double, 3>;
Place place_of(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

/// Lumps of five labels, a few voxels large.
ImageDomain crumbs() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(0, 19);
  std::vector<Vec3> middles;
  for (int i = 0; i < 120; ++i) middles.emplace_back(place(random), place(random), place(random));
  const LabelImage image =
      fixtures::voxels_of(fixtures::frame_of({20, 20, 20}), {0, 1, 2, 3, 4}, [=](const Vec3& p) {
        const auto nearest = std::min_element(
            middles.begin(), middles.end(),
            [&](const Vec3& a, const Vec3& b) { return (a - p).squaredNorm() < (b - p).squaredNorm(); });
        return static_cast<int>((nearest - middles.begin()) % 5);
      });
  return ImageDomain(image, {});
}

using Points = std::vector<operators::DelaunayExecution::NewVertex>;
Points random_points() {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(0, 19);
  Points points;
  for (int i = 0; i < 3000; ++i)
    points.push_back({Vec3(place(random), place(random), place(random)),
                      i % 3 == 0   ? VertexDimension::kCurve
                      : i % 3 == 1 ? VertexDimension::kSurface
                                   : VertexDimension::kVolume,
                      {}});
  return points;
}

/// With materials as labels, as refinement gives them.
struct Triangulation {
  TetMesh mesh = operators::triangulation_around(Vec3::Constant(9.5), 20);
  Spacing spacing;
  Rules rules;

  Triangulation(const Domain& domain, const Points& points)
      : spacing(domain, 1, 1.3, std::numeric_limits<double>::infinity(), nullptr),
        rules(mesh, spacing, {2, 30}) {
    operators::DelaunayExecution(mesh, {}).insert(points, 1);
    for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
      if (const TetId t(i); mesh.alive(t))
        mesh.set_label(t, static_cast<Label>(rules.material_at(circumsphere(mesh, t))));
  }
  Triangulation(const Triangulation&) = delete;

  [[nodiscard]] std::vector<Place> places(const std::vector<VertexId>& vertices) const {
    std::vector<Place> places;
    for (const VertexId v : vertices) places.push_back(place_of(mesh.point(v)));
    return places;
  }
  [[nodiscard]] std::map<std::array<Place, 4>, Label> labels() const {
    std::map<std::array<Place, 4>, Label> labels;
    for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
      const TetId t(i);
      if (!mesh.alive(t)) continue;
      std::array<Place, 4> corners{};
      for (int k = 0; k < 4; ++k) corners[static_cast<std::size_t>(k)] = place_of(mesh.corner(t, k));
      std::sort(corners.begin(), corners.end());
      labels[corners] = mesh.label(t);
    }
    return labels;
  }
};

class Numbering : public testing::Test {
 protected:
  static Points reversed(Points points) {
    std::reverse(points.begin(), points.end());
    return points;
  }
  const ImageDomain domain_ = crumbs();
  Triangulation one_{domain_, random_points()}, other_{domain_, reversed(random_points())};
};

TEST_F(Numbering, OfTheTwoTriangulationsDiffers) {
  ASSERT_EQ(one_.labels(), other_.labels());
  bool differs = false;
  for (std::uint32_t v = 4; v < one_.mesh.vertex_slots(); ++v)
    differs |= one_.mesh.point(VertexId(v)) != other_.mesh.point(VertexId(v));
  EXPECT_TRUE(differs);
}

TEST_F(Numbering, DoesNotDecideWhichVerticesOfBadFacesGo) {
  for (const bool first : {true, false}) {
    const auto gone = one_.places(vertices_of_bad_faces(one_.mesh, one_.rules, one_.spacing, 25, first));
    EXPECT_GT(gone.size(), 100U);
    EXPECT_EQ(gone,
              other_.places(vertices_of_bad_faces(other_.mesh, other_.rules, other_.spacing, 25, first)));
  }
}

/// Bit by bit: an opening's points came out in other last bits where an edge was seen from its other end.
TEST_F(Numbering, DoesNotDecideWhichPointsAreAskedFor) {
  const auto asked = [](const Triangulation& t) {
    std::vector<Place> places;
    for (std::uint32_t i = 0; i < t.mesh.tet_slots(); ++i) {
      const TetId tet(i);
      if (!t.mesh.alive(tet)) continue;
      const Circumsphere sphere = circumsphere(t.mesh, tet);
      for (const auto& candidate :
           {t.rules.candidate_for_crossed_opening(tet, sphere), t.rules.candidate_for_tet(tet, sphere)})
        if (candidate) places.push_back(place_of(candidate->point));
    }
    std::sort(places.begin(), places.end());
    return places;
  };
  EXPECT_GT(asked(one_).size(), 100U);
  EXPECT_EQ(asked(one_), asked(other_));
}

TEST_F(Numbering, DoesNotDecideWhatIsRelabelled) {
  const auto before = one_.labels();
  for (Triangulation* t : {&one_, &other_}) {
    EXPECT_GT(relabel_pinched(t->mesh, domain_, pinched_vertices(t->mesh, domain_)), 100U);
    EXPECT_TRUE(pinched_vertices(t->mesh, domain_).empty());
  }
  EXPECT_NE(one_.labels(), before);
  EXPECT_EQ(one_.labels(), other_.labels());
}

TEST_F(Numbering, DoesNotDecideWhichFlatTetrahedraGetAnotherLabel) {
  std::size_t counts[2];
  for (Triangulation* t : {&one_, &other_}) {
    relabel_pinched(t->mesh, domain_, pinched_vertices(t->mesh, domain_));
    counts[t == &one_ ? 0 : 1] = relabel_flat(t->mesh, domain_);
    EXPECT_TRUE(pinched_vertices(t->mesh, domain_).empty());
  }
  EXPECT_GT(counts[0], 10U);
  EXPECT_EQ(counts[0], counts[1]);
  EXPECT_EQ(one_.labels(), other_.labels());
}

}  // namespace
}  // namespace lumesh::delaunay
