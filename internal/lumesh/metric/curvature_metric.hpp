#pragma once
/// @file A metric from the curvature of a mesh's boundary.

#include <array>
#include <span>
#include <vector>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/sources.hpp"

namespace lumesh::metric {

/// How a smooth surface bends at a point of it.
struct SurfaceCurvature {
  Mat3 axes = Mat3::Identity();               ///< Principal directions and normal, orthonormal columns.
  std::array<double, 2> curvatures = {0, 0};  ///< Along the first two, per unit of length; either sign.
};

/// For each vertex of a triangle mesh of a smooth surface: the quadric through its neighbours and theirs, in
/// the frame of the normal of the triangles around it. Heights are taken along circles (z |p|^2 / rho^2 at
/// the distance rho from the normal), which makes spheres exact however coarse the mesh is.
/// @param triangles  Turned alike.
/// Parallel inside, bitwise identical for every thread count.
/// Source: osculating quadrics by least squares, Cazals and Pouget 2005, doi:10.1016/j.cagd.2004.09.004;
/// docs/stages/metric.md, "Curvature".
[[nodiscard]] std::vector<SurfaceCurvature> fit_curvatures(std::span<const Vec3> points,
                                                           std::span<const Cell<3>> triangles);

/// At boundary vertices sizes along the principal directions by the options, and along the normal the smaller
/// of the two; at others the largest one: limit_gradation() spreads what the boundary wants. Boundary and
/// interfaces fall into smooth pieces, at edges between patches and at those sharper than the feature angle;
/// where pieces meet a vertex gets the intersection of what they want.
/// @return One tensor per vertex of the compact mesh, per square of its unit.
/// @throws Error{kUsage} for options out of range. Parallel inside, bitwise identical for every thread count.
[[nodiscard]] std::vector<SymTensor> metric_from_curvature(const TetMesh& mesh,
                                                           const CurvatureOptions& options = {});

/// The same with the curvature of the domain's boundaries instead, next to the mesh's boundary vertices: from
/// the change of the normal over the domain's resolution. Openings are flat. Vertices that the domain's
/// boundary is more than three resolutions away from want the largest size.
/// @param domain  In the mesh's coordinates, with its labels.
/// @throws as above, and Error{kBadInput} if no vertex of the mesh's boundary lies at the domain's.
[[nodiscard]] std::vector<SymTensor> metric_from_curvature(const TetMesh& mesh, const Domain& domain,
                                                           const CurvatureOptions& options = {});

/// The metric at a place that bends so, as metric_from_curvature() says it.
/// @param largest  The size where nothing bends, finite.
[[nodiscard]] SymTensor metric_of_curvature(const SurfaceCurvature& curvature,
                                            const CurvatureOptions& options, double largest);

}  // namespace lumesh::metric
