#include "opening_names.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "lumesh/core/squares.hpp"
#include "lumesh/mesh/patch_list.hpp"

namespace lumesh {
namespace {

/// Calls visit(x) for the centres of an opening's squares that are in a box or less than a voxel beside it.
template <class Visit>
void for_each_square_in(const Box3& box_mm, const Opening& opening, const Visit& visit) {
  const OpeningSquares& part = *opening.squares;
  const double margin_mm = 2 * opening.voxel_mm;
  std::array<int, 2> first, last;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const Vec3& along = axis == 0 ? part.u : part.v;
    const double middle = along.dot(box_mm.center() - part.first_mm),
                 half = 0.5 * along.cwiseAbs().dot(box_mm.sizes()) + margin_mm;
    const int count = axis == 0 ? part.columns : part.rows;
    first[axis] = static_cast<int>(std::clamp(std::floor((middle - half) / part.step_mm), 0.0, 1.0 * count));
    last[axis] = static_cast<int>(std::clamp(std::ceil((middle + half) / part.step_mm), -1.0, count - 1.0));
  }
  for (int row = first[1]; row <= last[1]; ++row)
    for (int column = first[0]; column <= last[0]; ++column)
      if (part.hold(column, row)) visit(part.centre_of(column, row));
}

/// Whether squares of one opening are within a voxel of the other's, also in planes that meet there.
bool lies_beside(const Opening& own, const Opening& other) {
  const OpeningSquares& squares = *own.squares;
  bool found = false;
  for_each_square_in(own.box_mm, other, [&](const Vec3& x) {
    if (found || std::abs(own.normal.dot(x - own.centre_mm)) > own.voxel_mm) return;
    for (const Vec3& step : {squares.u, squares.v})
      found = found || squares.hold(x + own.voxel_mm * step) || squares.hold(x - own.voxel_mm * step);
  });
  return found;
}

/// Whether two openings meet where their planes do, as the parts of a section through an edge of the image.
bool meet_at_edge(const Opening& a, const Opening& b) {
  constexpr double kAlike = 0.999;  // Cosine between normals of one direction.
  return a.squares && b.squares && std::abs(a.normal.dot(b.normal)) <= kAlike && lies_beside(a, b);
}

/// Marks openings that meet a rim of their label at an edge of the image: parts of the same ring.
void mark_parts_of_rims(std::span<Opening> openings) {
  bool was_marked = true;
  while (was_marked) {
    was_marked = false;
    for (Opening& own : openings) {
      if (own.is_rim) continue;
      own.is_rim = std::ranges::any_of(openings, [&](const Opening& rim) {
        return rim.is_rim && rim.label == own.label && meet_at_edge(rim, own);
      });
      was_marked |= own.is_rim;
    }
  }
}

/// Area of an opening in the holes of another one.
double area_in_holes_mm2(const Opening& own, const PiecesAround& around, const Opening& other) {
  const std::size_t columns = static_cast<std::size_t>(own.squares->columns);
  std::size_t count = 0;
  for_each_square_in(own.box_mm, other, [&](const Vec3& x) {
    const auto square = own.squares->square_at(x);
    if (!square) return;
    const std::uint32_t piece =
        around.at(static_cast<int>(*square % columns), static_cast<int>(*square / columns));
    count += piece > PiecesAround::kOutside ? 1U : 0U;
  });
  return static_cast<double>(count) * other.squares->step_mm * other.squares->step_mm;
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

std::vector<OpeningNeighbours> neighbours_in_plane(std::span<const Opening> openings) {
  std::vector<OpeningNeighbours> all(openings.size());
  for (std::size_t i = 0; openings.size() > 1 && i < openings.size(); ++i) {
    const Opening& own = openings[i];
    if (!own.squares) continue;
    const PiecesAround around(*own.squares);
    for (const Opening& other : openings) {
      if (other.label == own.label || !other.squares) continue;
      if (own.box_mm.exteriorDistance(other.box_mm) > 2 * own.voxel_mm) continue;
      const double area_mm2 = area_in_holes_mm2(own, around, other);
      all[i].surrounded_mm2 += area_mm2;
      if (area_mm2 > 0) all[i].surrounded.insert(other.label);
      if (lies_beside(own, other)) all[i].beside.insert(other.label);
    }
  }
  return all;
}

void mark_rims(std::span<const OpeningNeighbours> neighbours, std::span<Opening> openings) {
  struct Rings {
    double area_mm2 = 0, surrounded_mm2 = 0;
    std::set<Label> surrounded = {};
    [[nodiscard]] bool are_of_wall() const { return surrounded_mm2 > kMinSurrounded * area_mm2; }
  };
  std::map<Label, Rings> of_labels;
  for (std::size_t i = 0; i < openings.size(); ++i) {
    if (!(neighbours[i].surrounded_mm2 > 0)) continue;
    Rings& rings = of_labels[openings[i].label];
    rings.area_mm2 += openings[i].area_mm2;
    rings.surrounded_mm2 += neighbours[i].surrounded_mm2;
    rings.surrounded.insert(neighbours[i].surrounded.begin(), neighbours[i].surrounded.end());
  }
  for (std::size_t i = 0; i < openings.size(); ++i) {
    const Rings& rings = of_labels[openings[i].label];
    openings[i].is_rim = rings.are_of_wall() && (neighbours[i].surrounded_mm2 > 0 ||
                                                 std::ranges::any_of(neighbours[i].beside, [&](Label label) {
                                                   return rings.surrounded.contains(label);
                                                 }));
  }
  mark_parts_of_rims(openings);
}

void name_openings(const PatchNaming& naming, std::span<Opening> openings) {
  name_members(
      naming, openings, [](const Opening& o) { return !o.is_rim; }, opening_name);
  name_members(
      naming, openings, [](const Opening& o) { return o.is_rim; }, wall_rim_name);
}

}  // namespace lumesh
