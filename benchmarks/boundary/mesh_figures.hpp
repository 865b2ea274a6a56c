#pragma once
/// @file The wall of a mesh against the surface that its labels were made from.

#include "field.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "shapes.hpp"

namespace lumesh::boundary {

struct MeshFigures {
  std::size_t tetrahedra = 0, wall_vertices = 0;
  double distance_max_mm = 0;  ///< From vertices of the wall to the domain's boundary, away from the border.
  double distance_rms_mm = 0;
  double border_distance_max_mm = 0;  ///< Near the border, where walls end.
  Vec3 border_worst_mm = Vec3::Zero();
  double lift_mm =
      0;  ///< Mean distance, > 0 outwards: meshers lift vertices to make up for the flat facets' volume.
  Deviation wall;  ///< Of the wall's vertices and the normals there, the facets' weighted by angle.
  Deviation
      floor;  ///< The same once the vertices have been moved onto the exact surface: what flat facets cost.
  double volume_percent = 0;                ///< Against the exact volume.
  double voxel_volume_percent = 0;          ///< Of the voxels, against the same.
  double section_radius_percent = 0;        ///< Mean over plane sections, by their area; NaN but for tubes.
  double floor_section_radius_percent = 0;  ///< With the vertices on the exact surface.
  double seconds = 0;                       ///< For the mesh.
};

/// Volume of the shape between the outer faces of the image's border voxels, in mm3.
[[nodiscard]] double exact_volume_mm3(const Shape& shape);

/// @param spacing_mm  Of the mesh's vertices. All but volumes is of places farther than this and 4 voxels
/// from
///                    the image's border, or said to be of the others.
[[nodiscard]] MeshFigures measure_mesh(const Shape& shape, const LabelImage& image, const ImageDomain& domain,
                                       const MixedMesh& mesh, double spacing_mm);

}  // namespace lumesh::boundary
