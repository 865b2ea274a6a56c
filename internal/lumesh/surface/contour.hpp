#pragma once
/// @file A closed surface around what is inside of a surface with faults, by marching cubes on a grid.

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

/// Places origin + spacing * (i, j, k) for i, j, k from 0 to size - 1.
struct PointGrid {
  Vec3 origin_mm = Vec3::Zero();
  double spacing_mm = 1;
  Index3 size = Index3::Zero();
};
/// The grid around points, with a place or two beyond them on each side.
[[nodiscard]] PointGrid grid_around(std::span<const Vec3> points, double spacing_mm);

/// A closed manifold that does not cross itself, turned outwards.
struct Contour {
  std::vector<Vec3> points;
  std::vector<Cell<3>> triangles;
  /// For each point the given triangle on which it lies; TriangleTree::kNone in holes of the given surface.
  std::vector<std::uint32_t> given;

  /// Vertices less edges and triangles: twice its parts less twice its handles.
  [[nodiscard]] std::int64_t euler_number() const;
  [[nodiscard]] std::uint32_t count_parts() const;
};

/// Boundary of what a surface winds around more than half (Jacobson et al. 2013,
/// doi:10.1145/2461912.2461916). Empty where nothing is inside.
///
/// Winding numbers are counted along rows of the grid by the triangles passed, with cones over open edges,
/// less the solid angles of the cones: docs/stages/repair.md, "Inside and outside". The surface is that of
/// marching cubes (Lorensen and Cline 1987, doi:10.1145/37402.37422) with the inside apart at faces that can
/// be read in two ways, and vertices where rows pass the given surface.
/// @param given  Triangles turned alike and outwards. @param grid  Around it.
/// Threads: parallel inside, the same for every thread count. Cost: about 10 ns per place of the grid, 0.3 us
/// per triangle.
[[nodiscard]] Contour contour_of_inside(const TriangleMesh& given, const PointGrid& grid);

/// Moves points towards the middles of their neighbours, along the given surface and no farther than a step.
/// Where triangles would turn over, lose their area or cross then, points stay where they were. Threads:
/// parallel inside, the same for every thread count. Cost: about 3 us per triangle.
/// @param tree  Of the given triangles. @param step_mm  Of the contour's grid.
void make_even(Contour& contour, const TriangleMesh& given, const TriangleTree& tree, double step_mm);

/// A contour with the patches of the given triangles on which it lies, or nearest in holes.
[[nodiscard]] TriangleMesh with_patches(Contour contour, const TriangleMesh& given, const TriangleTree& tree);

}  // namespace lumesh::surfaces
