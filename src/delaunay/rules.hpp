#pragma once
/// @file The rules R1 to R5 and R7 of refinement, and the points that they ask for.

#include <array>
#include <optional>

#include "lumesh/mesh/tet_mesh.hpp"
#include "spacing.hpp"

namespace lumesh::delaunay {

struct RuleLimits {
  double radius_edge;
  double facet_angle_deg;
};

/// A refinement point (Steiner candidate) that a rule asks for.
struct Candidate {
  Vec3 point;
  TetId tet;       ///< The tetrahedron that it is for.
  float priority;  ///< Larger first: all of surfaces before those of volumes.
  VertexDimension dimension;
  double spacing;  ///< Wanted spacing of the surface's points there; 0 inside.
};

[[nodiscard]] bool has_higher_priority(const Candidate& a, const Candidate& b);

/// Dimension of a point where these materials meet.
[[nodiscard]] VertexDimension dimension_of(const MaterialSet& materials);

struct Circumsphere {
  Vec3 centre;  ///< Not finite if the tetrahedron is flat.
  double radius;
};
[[nodiscard]] Circumsphere circumsphere(const TetMesh& mesh, TetId t);

/// Labels of tetrahedra are materials here: that of the domain at the centre of the circumsphere.
class Rules {
 public:
  Rules(const TetMesh& mesh, const Spacing& spacing, const RuleLimits& limits);

  /// The material of a tetrahedron with that circumsphere.
  [[nodiscard]] Material material_at(const Circumsphere& sphere) const;
  /// True for a face between materials of which one is meshed: the mesh will have it on its boundary.
  [[nodiscard]] bool is_boundary(TetId t, int face) const;
  /// The point that a boundary face asks for. R1: its centre on the surface is farther than the spacing from
  /// its corners. R3: an angle is too small, a corner is not of the surface, or the face crosses a curve
  /// where boundaries meet.
  /// @param sphere  Circumsphere of t.
  [[nodiscard]] std::optional<Candidate> candidate_for_face(TetId t, int face,
                                                            const Circumsphere& sphere) const;
  /// R7: the crossing of an opening with an edge from the kept side of a cut plane to beyond it, where points
  /// of the opening stand too far apart.
  [[nodiscard]] std::optional<Candidate> candidate_for_crossed_opening(TetId t,
                                                                       const Circumsphere& sphere) const;
  /// The face's centre on the surface, if that is not too near to its corners.
  [[nodiscard]] std::optional<Candidate> centre_of_face(TetId t, int face, const Circumsphere& sphere) const;
  /// R4: the circumradius is too large for the shortest edge. R5: for the wanted size; R2 is part of that,
  /// since sizes near surfaces are theirs. Or the sizing wants it finer; near a surface that asks for a point
  /// of it.
  [[nodiscard]] std::optional<Candidate> candidate_for_tet(TetId t, const Circumsphere& sphere) const;

 private:
  /// An edge between the centres of two circumspheres and the materials there.
  struct DualEdge {
    Vec3 from, to;
    Material mine, other;
    double reach;  ///< Largest distance of any place of the edge from the corners.
  };
  [[nodiscard]] std::optional<DualEdge> dual_of(TetId t, int face, const Circumsphere& sphere) const;
  [[nodiscard]] bool has_small_angle(const std::array<Vec3, 3>& corners, const DualEdge& dual) const;
  [[nodiscard]] std::optional<Candidate> candidate_for_crossed_curve(TetId t, const DualEdge& dual,
                                                                     const std::array<Vec3, 3>& corners,
                                                                     double spacing) const;
  [[nodiscard]] std::optional<Candidate> nearest_of_surface(TetId t, const Circumsphere& sphere) const;
  [[nodiscard]] Vec3 surface_centre(const DualEdge& dual, double close) const;
  /// A place on a boundary, and what lies on both of its sides.
  struct BoundaryPlace {
    Vec3 point;
    MaterialSet sides;
  };
  [[nodiscard]] std::optional<BoundaryPlace> project_near(const Vec3& place, const DualEdge& dual,
                                                          double spacing) const;
  [[nodiscard]] std::optional<Candidate> at_surface(const Vec3& place, TetId t, const DualEdge& dual,
                                                    double radius, double spacing) const;

  const TetMesh& mesh_;
  const Spacing& spacing_;
  const Domain& domain_;
  double radius_edge_, cosine_of_facet_angle_, cosine_of_usual_angle_;
};

}  // namespace lumesh::delaunay
