#include "lumesh/mesh/patch_naming.hpp"

#include <algorithm>

#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/mesh/patch_words.hpp"

namespace lumesh {

PatchNaming::PatchNaming(const std::map<Label, std::string>& label_names)
    : words_(label_words(label_names)) {}

std::string PatchNaming::word(Label label) const {
  const auto at = words_.find(label);
  return at != words_.end() ? at->second : std::to_string(label);
}

std::string PatchNaming::wall(Label label, bool is_only) const {
  return is_only ? kWallName : "wall_" + word(label);
}

std::string PatchNaming::between(Label a, Label b) const {
  const std::string name = word(std::min(a, b)) + "_" + word(std::max(a, b));
  // Of other labels, too, such as a_b and c for a and b_c: numbers tell them apart.
  const auto is_word = [&](const std::string& text) {
    return (!text.empty() && text.find_first_not_of("0123456789") == std::string::npos) ||
           std::ranges::any_of(words_, [&](const auto& one) { return one.second == text; });
  };
  int readings = 0;
  for (std::size_t at = name.find('_'); at != std::string::npos; at = name.find('_', at + 1))
    readings += is_word(name.substr(0, at)) && is_word(name.substr(at + 1)) ? 1 : 0;
  return readings > 1 ? name_between(a, b) : "interface_" + name;
}

std::string PatchNaming::label(Label label) const {
  return words_.contains(label) ? word(label) : "label_" + std::to_string(label);
}

}  // namespace lumesh
