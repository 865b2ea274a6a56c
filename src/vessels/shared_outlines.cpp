#include "shared_outlines.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <utility>

#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"

namespace lumesh {
namespace {

/// Whether an opening is wide enough to have an outline, and may carry flow.
bool may_be_told(const Opening& opening) {
  constexpr double kFaces = 8;  // Of voxels, as sections at the border.
  return opening.squares && !opening.is_rim &&
         opening.area_mm2 > kFaces * opening.voxel_mm * opening.voxel_mm;
}

/// Whether two openings of different labels are in one plane, and near enough to touch.
bool may_share(const Opening& a, const Opening& b) {
  return a.label != b.label && are_nearly_coplanar(a, b) &&
         a.box_mm.exteriorDistance(b.box_mm) < std::min(a.voxel_mm, b.voxel_mm);
}

/// Share of the outline of an opening, in edges of its squares, that has another opening behind it.
double shared_outline(const Opening& own, const Opening& other) {
  constexpr std::array<std::array<int, 2>, 4> kBeside = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
  constexpr double kSteps = 1.5;  // Far enough to be past the outline as coarse squares have it.
  const OpeningSquares& squares = *own.squares;
  const double reach_mm = kSteps * std::max(squares.step_mm, other.squares->step_mm);
  std::size_t all = 0, shared = 0;
  for (int row = 0; row < squares.rows; ++row)
    for (int column = 0; column < squares.columns; ++column) {
      if (!squares.hold(column, row)) continue;
      for (const auto& [along, across] : kBeside) {
        if (squares.hold(column + along, row + across)) continue;
        const Vec3 beyond =
            squares.centre_of(column, row) + reach_mm * (along * squares.u + across * squares.v);
        ++all;
        shared += other.squares->hold(beyond) ? 1U : 0U;
      }
    }
  return all > 0 ? static_cast<double>(shared) / static_cast<double>(all) : 0;
}

/// Openings of two labels of which one shares the most.
struct SharedOutline {
  const Opening* own = nullptr;
  const Opening* other = nullptr;
  double share = 0;
  std::set<const Opening*> all;  ///< Openings that share enough to be told.
};

}  // namespace

bool are_nearly_coplanar(const Opening& a, const Opening& b) {
  constexpr double kAlike = 0.999;  // Cosine between normals of one direction.
  return a.normal.dot(b.normal) > kAlike &&
         std::abs(a.normal.dot(b.centre_mm - a.centre_mm)) < 0.5 * std::min(a.voxel_mm, b.voxel_mm);
}

std::vector<std::string> doubts_about_shared_outlines(std::span<const Opening> openings) {
  constexpr double kMuch = 1.0 / 3;
  std::map<std::pair<Label, Label>, SharedOutline> of_labels;
  for (const Opening& own : openings)
    for (const Opening& other : openings) {
      if (!may_be_told(own) || !may_be_told(other) || !may_share(own, other)) continue;
      const double share = shared_outline(own, other);
      if (share <= kMuch) continue;
      SharedOutline& most = of_labels[std::minmax(own.label, other.label)];
      most.all.insert(&own);
      if (share > most.share) most.own = &own, most.other = &other, most.share = share;
    }
  std::vector<std::string> doubts;
  for (const auto& [labels, most] : of_labels)
    doubts.push_back(fmt::format(
        "{} at {} shares {:.0f} % of its outline with {}{}: labels {} and {} lie in or beside one another "
        "there, and have openings both; where one of them is a wall or a thrombus, call its openings so with "
        "{} PATCH=wall_rim_1, or leave it out with {}",
        most.own->name, place_text(most.own->centre_mm), 100 * most.share, most.other->name,
        most.all.size() > 1 ? fmt::format(" (1 of {} such openings)", most.all.size()) : "", labels.first,
        labels.second, option_name("name"), option_name("labels")));
  return doubts;
}

}  // namespace lumesh
