#pragma once
/// @file Lists as texts.

#include <string>

namespace lumesh {

/// Texts of the items with commas between them; empty for none. @param text  Makes the text of an item.
template <class Items, class Text>
[[nodiscard]] std::string joined(const Items& items, const Text& text) {
  std::string list;
  for (const auto& item : items) list += (list.empty() ? "" : ", ") + text(item);
  return list;
}

}  // namespace lumesh
