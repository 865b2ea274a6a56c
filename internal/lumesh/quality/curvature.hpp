#pragma once
/// @file Mean curvature of the wall of a mesh: what shows voxel stairs, ripples and creases.

#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/quality/measures.hpp"
#include "lumesh/quality/surface.hpp"

namespace lumesh::quality {

/// At the points of a mesh; zero area and a value that is not a number where there is none.
struct WallCurvature {
  std::vector<double> mean_per_mm;  ///< Half the sum of both principal curvatures, > 0 where the wall is
                                    ///< convex: 1 / R of a ball, 1 / (2 R) of a straight vessel.
  std::vector<double> area_mm2;     ///< The part of the wall that belongs to the point.
};

/// Discrete mean curvature at the vertices of the outer surface, by cotangents over mixed areas. Vertices of
/// openings, their rims among them, and those at open edges have none.
/// Source: Meyer, Desbrun, Schroeder, Barr 2003, doi:10.1007/978-3-662-05105-4_2, section 3.5.
/// Threads: parallel inside, bitwise identical for every thread count. Cost: about 0.5 us per triangle and
/// core.
[[nodiscard]] WallCurvature wall_curvature(const MeshView& mesh, const MeshSurface& surface);

[[nodiscard]] CurvatureSummary summarise(const WallCurvature& curvature);

}  // namespace lumesh::quality
