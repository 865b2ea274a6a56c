#pragma once
/// @file The rules R1 to R5 of refinement, and the points that they ask for.

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
};

struct Circumsphere {
  Vec3 centre;  ///< Not finite if the tetrahedron is flat.
  double radius;
};
[[nodiscard]] Circumsphere circumsphere(const TetMesh& mesh, TetId t);

/// Labels of tetrahedra are materials here: that of the domain at the centre of the circumsphere.
class Rules {
 public:
  Rules(const TetMesh& mesh, const Spacing& spacing, const RuleLimits& limits)
      : mesh_(mesh), spacing_(spacing), domain_(spacing.domain()), limits_(limits) {}

  [[nodiscard]] Material material_of(TetId t) const;
  /// What the face asks for that lies between two materials, seen from t. R1: its place on the surface is
  /// farther than the spacing from its corners. R3: an angle is too small, or a corner is not of the surface.
  [[nodiscard]] std::optional<Wish> wish_of_face(TetId t, int face) const;
  /// R4: the circumradius is too large for the shortest edge. R5: for the wanted size; R2 is part of that,
  /// since sizes near surfaces are theirs.
  [[nodiscard]] std::optional<Wish> wish_of_tet(TetId t) const;
  /// True for a face that the mesh will have as one of its boundary.
  [[nodiscard]] bool is_boundary(TetId t, int face) const;

 private:
  [[nodiscard]] Vec3 surface_centre(TetId t, int face, Material mine, Material other) const;
  [[nodiscard]] std::optional<Wish> at_surface(const Vec3& place, TetId t, Material mine, Material other,
                                               double radius, double spacing) const;

  const TetMesh& mesh_;
  const Spacing& spacing_;
  const Domain& domain_;
  RuleLimits limits_;
};

}  // namespace lumesh::delaunay
