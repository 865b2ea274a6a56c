#include "opening_names.hpp"

#include <set>

#include "lumesh/core/squares.hpp"
#include "lumesh/mesh/patch_list.hpp"

namespace lumesh {
namespace {

/// Area of other labels' openings in the holes of one.
double surrounded_mm2(const Opening& ring, std::span<const Opening> all) {
  const OpeningSquares& own = *ring.squares;
  const PiecesAround around(own);
  double area_mm2 = 0;
  for (const Opening& other : all) {
    if (other.label == ring.label || !other.squares) continue;
    const OpeningSquares& part = *other.squares;
    for (int row = 0; row < part.rows; ++row)
      for (int column = 0; column < part.columns; ++column) {
        if (part.is_inside[part.square(column, row)] == 0) continue;
        const auto square = own.square_at(part.centre_of(column, row));
        if (!square) continue;
        const std::size_t columns = static_cast<std::size_t>(own.columns);
        const std::uint32_t piece =
            around.at(static_cast<int>(*square % columns), static_cast<int>(*square / columns));
        area_mm2 += piece > PiecesAround::kOutside ? part.step_mm * part.step_mm : 0;
      }
  }
  return area_mm2;
}

/// Names of one kind, with the label where they are of several, for those that have none.
template <class IsMember, class NameOf>
void name_members(const PatchNaming& naming, std::span<Opening> openings, const IsMember& is_member,
                  const NameOf& name_of) {
  std::set<Label> labels;
  std::set<std::string> names;
  for (const Opening& o : openings) {
    if (is_member(o)) labels.insert(o.label);
    names.insert(o.name);
  }
  std::size_t number = 0;
  for (Opening& o : openings) {
    if (!is_member(o) || !o.name.empty()) continue;
    do {
      o.name = name_of(number++);
      if (labels.size() > 1) o.name += "_" + naming.label(o.label);
    } while (names.contains(o.name));
  }
}

}  // namespace

PiecesAround::PiecesAround(const OpeningSquares& opening)
    : columns(static_cast<std::size_t>(opening.columns) + 2),
      numbers(connected_squares(
          columns, columns * (static_cast<std::size_t>(opening.rows) + 2), [&](std::size_t square) {
            const int column = static_cast<int>(square % columns), row = static_cast<int>(square / columns);
            return opening.hold(column - 1, row - 1) ? 0 : 1;
          })) {}

void mark_rims(std::span<Opening> openings) {
  if (openings.size() < 2) return;
  for (Opening& o : openings)
    o.is_rim = o.squares != nullptr && surrounded_mm2(o, openings) > kMinSurrounded * o.area_mm2;
}

void name_openings(const PatchNaming& naming, std::span<Opening> openings) {
  name_members(
      naming, openings, [](const Opening& o) { return !o.is_rim; }, opening_name);
  name_members(
      naming, openings, [](const Opening& o) { return o.is_rim; }, wall_rim_name);
}

}  // namespace lumesh
