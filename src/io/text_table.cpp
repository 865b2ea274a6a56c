#include "text_table.hpp"

#include <algorithm>
#include <cctype>

#include "lumesh/core/parse_number.hpp"

namespace lumesh::io {

std::optional<double> real_from(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  return parse_number<double>(word);
}

PlaceColumns place_columns(const std::vector<std::string_view>& header) {
  PlaceColumns columns = {0, 1, 2};
  constexpr std::array<std::array<std::string_view, 3>, 3> kNames = {
      {{"x", "y", "z"}, {"points:0", "points:1", "points:2"}, {"points_0", "points_1", "points_2"}}};
  for (const auto& names : kNames) {
    PlaceColumns found = {};
    bool all = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto at = std::ranges::find_if(header, [&](std::string_view word) {
        return std::equal(word.begin(), word.end(), names[axis].begin(), names[axis].end(),
                          [](unsigned char a, char b) { return std::tolower(a) == b; });
      });
      all = all && at != header.end();
      found[axis] = static_cast<std::size_t>(at - header.begin());
    }
    if (all) return found;
  }
  return columns;
}

}  // namespace lumesh::io
