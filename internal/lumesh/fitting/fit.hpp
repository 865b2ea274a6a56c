#pragma once
/// @file Deformation of the lattice mesh onto the domain's boundaries, with a floor on the dihedral angles.

#include <vector>

#include "lumesh/fitting/boundary_model.hpp"
#include "lumesh/fitting/probes.hpp"
#include "lumesh/fitting/work_mesh.hpp"

namespace lumesh::fitting {

struct FitOptions {
  double min_dihedral_deg = 0, max_dihedral_deg = 180;  ///< Limits of dihedral angles; these are none.
  std::vector<Probe> probes;  ///< Points of the domain's boundary that the surface shall come close to.
};

struct FitReport {
  /// Number of probes of the domain's boundary, and of triangles, that are more than 1.25 voxels off.
  std::size_t deviating_points = 0;
  /// Largest distance of these; a triangle counts as 2.25 of the smallest voxel edges at most.
  double furthest_deviation_mm = 0;
  /// Vertices that lie more than a hundredth of a voxel beyond the image's border or a cut plane, and how
  /// far.
  std::size_t vertices_beyond = 0;
  double furthest_beyond_mm = 0;
};

/// Moves vertices; tetrahedra keep positive volume and, once they have them, dihedral angles within the
/// limits. Drops the few exposed tetrahedra (exposed_tetrahedra.hpp) and adds, drops or joins a few where no
/// vertex could be moved to the boundary (defects.hpp). Bitwise identical for every thread count
/// (vertex_blocks.hpp).
FitReport fit_to_domain(WorkMesh& mesh, BoundaryModel& boundary, const LabelImage& image,
                        const ImageDomain& domain, const FitOptions& options);

}  // namespace lumesh::fitting
