#pragma once
/// @file The complete check of a mesh. Tests call it after everything that builds or changes one.

#include <cstdint>
#include <string>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh {

/// End of what is said of a point.
inline constexpr const char* kNotFinite = " has a coordinate that is not finite";

/// Counts of validate(), per label.
struct LabelBoundary {
  Label label = kBackground;
  std::uint32_t tet_count = 0;
  double volume = 0;                     ///< In the cube of the points' unit.
  std::uint32_t surface_components = 0;  ///< Closed surfaces that bound the label: outer ones and cavities.
  std::int64_t surface_euler = 0;        ///< V - E + F over all of them; 2 per sphere, 0 per torus.
};

struct ValidationReport {
  static constexpr std::size_t kMaxListed = 50;

  std::vector<std::string> problems;  ///< One readable line each, at most kMaxListed.
  std::size_t problem_count = 0;      ///< Number of all problems.
  std::vector<LabelBoundary> labels;  ///< By ascending label; empty if the mesh is too broken to count.

  [[nodiscard]] bool ok() const { return problem_count == 0; }
  [[nodiscard]] std::string text() const;  ///< The problems, one per line; "valid" if there are none.
};

/// Checks everything a valid mesh promises:
/// - coordinates are finite; every live vertex is used and its incident tetrahedron contains it; its
/// dimension is below
///   kVolume exactly on faces with a patch;
/// - every live tetrahedron has live vertices and is positively oriented by the exact predicate;
/// - neighbours name each other, share three vertices and see them from opposite sides; no two faces with the
/// same
///   vertices are unlinked;
/// - faces on the outside and between labels have a patch of info(), the same on both sides; no other face
/// has one;
/// - around each vertex the tetrahedra are connected by faces and its link is a sphere, or a disc on the
/// outside;
/// - the surface of every label is a closed 2-manifold: two faces at each edge, one ring of faces around each
/// vertex,
///   even Euler number;
/// - the volume of every label is the integral over its surface, to rounding;
/// - the outside does not cross or touch itself, by exact predicates, and no piece lies within another: no
/// two
///   tetrahedra overlap.
/// A stage of checks whose ground is broken is left out (no walks over bad adjacency).
/// Threads: const, parallel inside; the same report for every thread count. Cost: about 1 s per million
/// tetrahedra.
[[nodiscard]] ValidationReport validate(const TetMesh& mesh);

/// The same for a mesh that was read or is about to be written: builds a TetMesh from it first; what build()
/// refuses is the one problem reported.
[[nodiscard]] ValidationReport validate(const MeshView& view);

}  // namespace lumesh
