#pragma once
/// @file Rows of numbers in text, such as .csv.

#include <array>
#include <optional>
#include <string_view>
#include <vector>

namespace lumesh::io {

/// The whole word as a number, also infinite or not a number; none if it is anything else.
[[nodiscard]] std::optional<double> real_from(std::string_view word);

/// Where x, y and z stand in a row.
using PlaceColumns = std::array<std::size_t, 3>;

/// The columns that a line of names gives to the places, in any case: x, y and z, or as ParaView calls them;
/// the first three if it gives none.
[[nodiscard]] PlaceColumns place_columns(const std::vector<std::string_view>& header);

}  // namespace lumesh::io
