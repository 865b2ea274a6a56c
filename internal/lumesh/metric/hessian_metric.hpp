#pragma once
/// @file The metric that keeps the interpolation error of a solution low: multiscale, in an Lp norm.

#include <span>
#include <vector>

#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/sources.hpp"

namespace lumesh::metric {

/// Second derivatives at the vertices of a function given there: those of the quadratic polynomial through
/// the vertex's value that fits its neighbours' and their neighbours' best, weighed by the inverse square of
/// the distance; exact for quadratic functions, at the boundary too. Directions that the neighbours leave
/// open get 0.
/// @param values  One per vertex of the compact mesh, finite.
/// @throws Error{kBadInput} that names the vertex if a value is not finite.
/// Parallel inside, bitwise identical for every thread count. Cost: about 10 us per vertex.
[[nodiscard]] std::vector<SymTensor> recover_hessians(const TetMesh& mesh, std::span<const double> values);

/// M = c det(|H|)^(-1/(2p + 3)) |H| with the Hessian's eigenvalues made positive and at least 10^-6 of the
/// mesh's largest, and c such that the mesh sees half as many units of complexity as it has vertices, about
/// what it can resolve; another complexity is the caller's to set. Of a function that is constant or linear
/// the tensors are the same everywhere and in all directions.
///
/// @throws as recover_hessians(), and Error{kUsage} for options out of range.
/// Source: Loseille and Alauzet 2011, doi:10.1137/10078654X, the optimal metric in Lp norm for n = 3; derived
/// in docs/stages/metric.md, "Hessian".
[[nodiscard]] std::vector<SymTensor> metric_from_hessian(const TetMesh& mesh, std::span<const double> values,
                                                         const HessianMetricOptions& options = {});

}  // namespace lumesh::metric
