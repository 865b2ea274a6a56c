#pragma once
/// @file Boundary layers as front ends ask for them: labels by name or number.

#include <string>

#include "lumesh/layers/layers.hpp"

namespace lumesh {

struct LayerRequest {
  LayerOptions options;  ///< Without the labels.
  std::string into;   ///< Name or number of the label that is deformed; empty: the only one at the patches.
  std::string label;  ///< "wall=2", "wall" or "2"; empty: LayerOptions' own.

  [[nodiscard]] bool is_wanted() const { return options.first_height > 0; }
  void describe(OptionList& list);
  /// @throws Error{kBadInput} or Error{kUsage} that names the option.
  void validate() const;
  /// The options with the labels. @param info  Of the mesh that gets the layers.
  /// @throws Error{kBadInput} that names the option for a label that is none.
  [[nodiscard]] LayerOptions resolved(const MixedMesh& mesh) const;
  /// The options with the label of the layers alone.
  [[nodiscard]] LayerOptions with_label() const;
};

}  // namespace lumesh
