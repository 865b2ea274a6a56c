#include "opening_names.hpp"

#include <algorithm>
#include <set>

#include "lumesh/mesh/patch_list.hpp"

namespace lumesh {
namespace {

/// Least share of a ring's own area: walls are up to 1.2 radii of the lumen thick, and what lies in a lumen
/// is thinner.
constexpr double kMinSurrounded = 0.25;

/// The squares around a part that are joined to the edge of the grid: neither the part nor its holes.
std::vector<std::uint8_t> squares_around(const OpeningSquares& part) {
  const int columns = part.columns, rows = part.rows;
  std::vector<std::uint8_t> is_around(part.is_inside.size(), 0);
  std::vector<std::array<int, 2>> open;
  const auto enter = [&](int column, int row) {
    if (column < 0 || row < 0 || column >= columns || row >= rows) return;
    const std::size_t at = part.square(column, row);
    if (part.is_inside[at] != 0 || is_around[at] != 0) return;
    is_around[at] = 1;
    open.push_back({column, row});
  };
  for (int column = 0; column < columns; ++column) enter(column, 0), enter(column, rows - 1);
  for (int row = 0; row < rows; ++row) enter(0, row), enter(columns - 1, row);
  while (!open.empty()) {
    const auto [column, row] = open.back();
    open.pop_back();
    enter(column - 1, row), enter(column + 1, row), enter(column, row - 1), enter(column, row + 1);
  }
  return is_around;
}

/// Area of other labels' openings in the holes of one.
double surrounded_mm2(const Opening& ring, std::span<const Opening> all) {
  const OpeningSquares& own = *ring.squares;
  const std::vector<std::uint8_t> is_around = squares_around(own);
  double area_mm2 = 0;
  for (const Opening& other : all) {
    if (other.label == ring.label || !other.squares) continue;
    const OpeningSquares& part = *other.squares;
    for (int row = 0; row < part.rows; ++row)
      for (int column = 0; column < part.columns; ++column) {
        if (part.is_inside[part.square(column, row)] == 0) continue;
        const auto square = own.square_at(part.centre_of(column, row));
        const bool is_in_hole = square && own.is_inside[*square] == 0 && is_around[*square] == 0;
        area_mm2 += is_in_hole ? part.step_mm * part.step_mm : 0;
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
