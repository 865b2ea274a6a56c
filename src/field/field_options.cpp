#include "lumesh/core/option.hpp"
#include "lumesh/field/label_field.hpp"

namespace lumesh {

void LabelFieldOptions::describe(OptionList& list) {
  list.choice("boundary", fidelity,
              {{"smooth", BoundaryFidelity::kSmooth}, {"exact", BoundaryFidelity::kExact}},
              "smooth: voxels that noise explains better may change side; exact: every voxel's centre keeps "
              "its side");
}

}  // namespace lumesh
