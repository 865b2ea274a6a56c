#include <span>

#include "lumesh/core/option.hpp"
#include "lumesh/domain/usual_edge.hpp"
#include "lumesh/image/labels_named.hpp"
#include "lumesh/lattice/lattice.hpp"

namespace lumesh {

void LatticeOptions::describe(OptionList& list) {
  list.number("edge_length", spacing_mm, above(0),
              "Edge of the lattice's cubes, and so of triangles, at boundaries where the object is thick; a "
              "voxel counts as the geometric mean of its edges")
      .in("mm")
      .alias("spacing")
      .zero(usual_edge_text());
  list.number("fidelity", fidelity, between(0.1, 0.98),
              "At a boundary the spacing is at most 4 (1 - fidelity) times the local half thickness, in "
              "vessels at most 0.8 of their radius; edges, tips and clefts get half of the spacing at most");
  list.of_labels("label_fidelity", label_fidelity, between(0.1, 0.98),
                 "The fidelity of single labels; never given up for max_tetrahedra");
  list.number("coarsening", coarsening, between(0, 4),
              "Times that the spacing may double away from boundaries");
  list.number("max_refinement", max_refinement, between(0, 5),
              "Times that the spacing may halve in thin parts");
  list.number("max_tetrahedra", max_tetrahedra, at_least(1),
              "Refinement of thin parts is given up level by level until the prediction is below");
  list.number("min_dihedral", min_dihedral_deg, between(1, 25),
              "Least dihedral angle; a few may be smaller where a vertex would leave the image or an opening "
              "would not be flat")
      .in("degrees");
  list.number("max_dihedral", max_dihedral_deg, between(130, 175),
              "Ceiling of the dihedral angles, but for the same")
      .in("degrees");
  list.flag(
      "mixed", mixed,
      "Hexahedra where the lattice is regular and of one label, pyramids next to them, tetrahedra elsewhere; "
      "for meshes that are not adapted");
}

void LatticeOptions::validate() const {
  require_ranges_of(*this);
}

void LatticeOptions::require_labels_of(const LabelImage& image) const {
  require_labels(option_name("label_fidelity"), label_fidelity, std::span(image.values()).subspan(1));
}

}  // namespace lumesh
