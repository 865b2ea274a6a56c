#pragma once
/// @file The rules R1 to R5 and R7 of refinement, and the points that they ask for.

#include <array>
#include <optional>
#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"
#include "spacing.hpp"

namespace lumesh::delaunay {

struct RuleLimits {
  double radius_edge;
  double facet_angle_deg;
};

/// A point that a rule asks for.
struct Wish {
  Vec3 point;
  TetId tet;      ///< Whose it is.
  float urgency;  ///< Larger first: all of surfaces before those of volumes.
  VertexDimension dimension;
  double spacing;  ///< Of points of the surface there; 0 inside.
};

[[nodiscard]] bool is_more_urgent(const Wish& a, const Wish& b);

/// Of a point where so many materials meet.
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
  /// What such a face asks for. R1: its place on the surface is farther than the spacing from its corners.
  /// R3: an angle is too small, a corner is not of the surface, or the face crosses a curve where boundaries
  /// meet.
  /// @param sphere  Of t.
  [[nodiscard]] std::optional<Wish> wish_of_face(TetId t, int face, const Circumsphere& sphere) const;
  /// R7: an edge from the kept side of a cut plane to beyond it goes through an opening, whose points stand
  /// too far apart there: where it crosses.
  [[nodiscard]] std::optional<Wish> wish_of_crossed_opening(TetId t, const Circumsphere& sphere) const;
  /// Its place on the surface, if that is not too near to its corners.
  [[nodiscard]] std::optional<Wish> centre_of_face(TetId t, int face, const Circumsphere& sphere) const;
  /// R4: the circumradius is too large for the shortest edge. R5: for the wanted size; R2 is part of that,
  /// since sizes near surfaces are theirs. Or the sizing wants it finer.
  [[nodiscard]] std::optional<Wish> wish_of_tet(TetId t, const Circumsphere& sphere) const;

 private:
  /// An edge between the centres of two circumspheres and the materials there.
  struct DualEdge {
    Vec3 from, to;
    Material mine, other;
    double reach;  ///< No place of it is farther from the corners.
  };
  [[nodiscard]] std::optional<DualEdge> dual_of(TetId t, int face, const Circumsphere& sphere) const;
  [[nodiscard]] std::optional<Wish> wish_of_crossed_curve(TetId t, const DualEdge& dual,
                                                          const std::array<Vec3, 3>& corners,
                                                          double spacing) const;
  [[nodiscard]] Vec3 surface_centre(const DualEdge& dual, double close) const;
  [[nodiscard]] std::optional<Wish> at_surface(const Vec3& place, TetId t, const DualEdge& dual,
                                               double radius, double spacing) const;

  const TetMesh& mesh_;
  const Spacing& spacing_;
  const Domain& domain_;
  double radius_edge_, cosine_of_facet_angle_;
};

}  // namespace lumesh::delaunay
