#pragma once
// Deformation of the lattice mesh onto the domain's boundaries, with a floor on the dihedral angles.

#include <vector>

#include "work_mesh.hpp"

namespace lumesh {

/// One face between two materials; points out of `inside`.
struct BoundaryTriangle {
  std::array<std::uint32_t, 3> vertices;
  Material inside;   ///< A meshed material.
  Material outside;  ///< Another; the larger of the two where both are meshed.
};

/// What the fit needs to know of the boundary.
struct BoundaryModel {
  std::vector<BoundaryTriangle> triangles;
  std::vector<MaterialSet> sets;  ///< Per vertex: materials that meet there; fewer than two inside.
};

struct FitOptions {
  double min_dihedral_deg = 15;
  double max_dihedral_deg = 150;
};

struct FitReport {
  std::size_t off_boundary_vertices = 0;  ///< Further than a tenth of a voxel.
  double largest_offset_mm = 0;
};

/// Moves vertices only; tetrahedra keep positive volume and, once they have them, dihedral angles within the limits.
/// Same bits for every thread count: vertices move colour by colour, no two of a colour sharing a tetrahedron.
FitReport fit_to_domain(WorkMesh& mesh, const BoundaryModel& boundary, const ImageDomain& domain,
                        const FitOptions& options);

}  // namespace lumesh
