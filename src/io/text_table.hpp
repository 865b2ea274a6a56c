#pragma once
/// @file Rows of numbers in text, such as .csv.

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

namespace lumesh::io {

/// The whole word as a number, also infinite or not a number; none if it is anything else.
[[nodiscard]] std::optional<double> real_from(std::string_view word);

/// Calls visit(line, its number from 1) for each line of a text.
template <class Visit>
void for_each_line(std::string_view content, const Visit& visit) {
  std::size_t number = 0;
  for (std::size_t begin = 0; begin < content.size();) {
    const std::size_t end = std::min(content.find('\n', begin), content.size());
    visit(content.substr(begin, end - begin), ++number);
    begin = end + 1;
  }
}

/// Where x, y and z stand in a row.
using PlaceColumns = std::array<std::size_t, 3>;

/// The columns that a line of names gives to the places, in any case: x, y and z, or as ParaView calls them;
/// the first three if it gives none.
[[nodiscard]] PlaceColumns place_columns(const std::vector<std::string_view>& header);

}  // namespace lumesh::io
