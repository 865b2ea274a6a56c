#pragma once
/// @file Image-to-mesh conversion on a body-centred cubic lattice, the role of CBC3D in the paper
/// (section 3.1).

#include <map>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

class OptionList;

/// Options of mesh_lattice(); describe() says what each means and which values it takes.
struct LatticeOptions {
  double spacing_mm = 0;  ///< 0: the usual one.
  double fidelity = 0.5;
  /// About so many edges go along the diameter of each vessel, whatever `fidelity` says; 0: as that says.
  double cells_per_diameter = 0;
  std::map<Label, double> label_fidelity;  ///< Labels without an entry take `fidelity`.
  int coarsening = 1;
  int max_refinement = 3;
  std::size_t max_tetrahedra = 1'500'000;
  double min_dihedral_deg = 15;
  double max_dihedral_deg = 150;
  bool mixed = false;

  void describe(OptionList& list);
  void validate() const;  ///< Throws Error{kUsage}, naming the field.
  /// @throws Error{kBadInput} for a fidelity of a label that the image does not have.
  void require_labels_of(const LabelImage& image) const;
};

/// Figures and notes for the report.
struct LatticeReport {
  std::size_t lattice_tetrahedra = 0;  ///< Before the boundary was chosen.
  std::size_t relabelled = 0;  ///< Tetrahedra that changed their material to make the boundary manifold.
  /// Points of the domain's boundary next to voxel faces, and triangles, that are more than 1.25 voxels off.
  std::size_t deviating_points = 0;
  /// Largest distance of these; a triangle counts as 2.25 of the smallest voxel edges at most.
  double furthest_deviation_mm = 0;
  int levels_given_up = 0;         ///< Refinement levels of thin parts given up to stay near max_tetrahedra.
  std::vector<Label> lost_labels;  ///< Labels without a single tetrahedron.
  std::vector<std::string> notes;  ///< Warnings, such as labels that were lost, with their voxel counts.
  bool complete = true;  ///< False if it was told to stop before it was made again for its openings.
};

struct LatticeResult {
  MixedMesh mesh;
  LatticeReport report;
};

/// Meshes every label of the image.
///
/// @param image    Labels; must outlive the call only.
/// @param domain   The oracle built from the same image.
/// @return         A conforming mesh, positively oriented, in mm (LPS); patches "wall", "inlet_1",
///                 "outlet_1" and on, "interface_A_B".
/// @throws Error{kBadInput} if nothing can be meshed, or as require_labels_of(), Error{kMemory} if the
/// lattice would not fit into memory. Threads: data-parallel, bitwise identical for every thread count. Cost:
/// linear in the number of tetrahedra. Reference: the paper's section 3.1; Molino et al. 2003 for the
/// red-green lattice.
[[nodiscard]] LatticeResult mesh_lattice(const LabelImage& image, const ImageDomain& domain,
                                         const LatticeOptions& options, Context& context);

/// Estimated number of tetrahedra of that mesh, from the sizes wanted at some places of the object.
/// @throws as mesh_lattice() does for its options and the memory.
[[nodiscard]] double estimated_tetrahedra(const LabelImage& image, const ImageDomain& domain,
                                          const LatticeOptions& options);

}  // namespace lumesh
