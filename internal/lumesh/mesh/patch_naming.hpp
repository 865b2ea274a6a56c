#pragma once
/// @file Names of the patches of labels.

#include <map>
#include <string>

#include "lumesh/core/types.hpp"

namespace lumesh {

/// Names of the patches of labels.
class PatchNaming {
 public:
  /// @param label_names  What the input calls its labels; characters that solvers do not take become '_'.
  explicit PatchNaming(const std::map<Label, std::string>& label_names);

  /// "wall" of the only label, else "wall_3", or with the label's name "wall_LICA".
  [[nodiscard]] std::string wall(Label label, bool is_only) const;
  /// "interface_1_3", the lower number first.
  [[nodiscard]] std::string between(Label a, Label b) const;
  /// "label_3", or its name.
  [[nodiscard]] std::string label(Label label) const;

 private:
  [[nodiscard]] std::string word(Label label) const;

  std::map<Label, std::string> words_;  // Each once.
};

}  // namespace lumesh
