#pragma once
/// @file Grids of squares, and what is connected in them over sides. Square `column + columns * row`.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lumesh {

/// Calls visit(square) for the squares beside one, at most four.
/// @param count  Of all squares.
template <class Visit>
void for_each_square_beside(std::size_t columns, std::size_t count, std::size_t square, const Visit& visit) {
  if (square % columns > 0) visit(square - 1);
  if (square % columns + 1 < columns) visit(square + 1);
  if (square >= columns) visit(square - columns);
  if (square + columns < count) visit(square + columns);
}

/// Goes from one square to those beside it, and on from each that enter(square) says yes to.
/// @param count  Of all squares.
template <class Enter>
void flood_squares(std::size_t columns, std::size_t count, std::size_t start, const Enter& enter) {
  std::vector<std::size_t> open;
  const auto look_at = [&](std::size_t square) {
    if (enter(square)) open.push_back(square);
  };
  look_at(start);
  while (!open.empty()) {
    const std::size_t at = open.back();
    open.pop_back();
    for_each_square_beside(columns, count, at, look_at);
  }
}

/// Connected squares of one kind: a number for each square, by first squares from 1 on; 0 for none.
/// @param kind_of  kind_of(square); what equals a kind made without arguments, as 0 does, is none.
template <class KindOf>
[[nodiscard]] std::vector<std::uint32_t> connected_squares(std::size_t columns, std::size_t count,
                                                           const KindOf& kind_of) {
  std::vector<std::uint32_t> part(count, 0);
  std::uint32_t next = 0;
  for (std::size_t start = 0; start < count; ++start) {
    const auto kind = kind_of(start);
    if (part[start] != 0 || kind == decltype(kind)()) continue;
    ++next;
    flood_squares(columns, count, start, [&](std::size_t square) {
      if (part[square] != 0 || kind_of(square) != kind) return false;
      part[square] = next;
      return true;
    });
  }
  return part;
}

}  // namespace lumesh
