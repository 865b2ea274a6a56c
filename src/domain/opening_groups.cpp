#include "opening_groups.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

bool are_in_one_plane(const Opening& a, const Opening& b) {
  constexpr double kTiny = 1e-6;
  return a.normal.dot(b.normal) > 1 - kTiny &&
         std::abs(a.normal.dot(b.centre_mm - a.centre_mm)) < kTiny * (1 + a.box_mm.diagonal().norm());
}

namespace {

/// Squares of an opening with a neighbour outside.
std::vector<Vec3> rim_places(const Opening& opening) {
  std::vector<Vec3> places;
  const OpeningSquares& squares = *opening.squares;
  const auto holds = [&](int i, int j) { return squares.hold(i, j); };
  for (int j = 0; j < squares.rows; ++j)
    for (int i = 0; i < squares.columns; ++i)
      if (is_at_rim(holds, i, j)) places.push_back(squares.centre_of(i, j));
  return places;
}

bool do_touch(const Opening& a, const Opening& b, std::span<const Vec3> rim_of_a) {
  constexpr double kSteps = 1.5;
  const double reach_mm = kSteps * std::max(a.squares->step_mm, b.squares->step_mm);
  return std::ranges::any_of(rim_of_a, [&](const Vec3& x) {
    const Vec3 u = reach_mm * a.squares->u, v = reach_mm * a.squares->v;
    return b.squares->hold(x + u) || b.squares->hold(x - u) || b.squares->hold(x + v) ||
           b.squares->hold(x - v);
  });
}

double nearest_mm(std::span<const Vec3> places, const Vec3& x) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3& p : places) least = std::min(least, (p - x).squaredNorm());
  return std::sqrt(least);
}

}  // namespace

std::vector<OpeningGroup> group_openings(std::span<const Opening> openings) {
  DisjointSets sets(openings.size());
  std::vector<std::vector<Vec3>> rims;
  for (const Opening& o : openings) rims.push_back(rim_places(o));
  for (std::size_t a = 0; a < openings.size(); ++a)
    for (std::size_t b = a + 1; b < openings.size(); ++b)
      if (are_in_one_plane(openings[a], openings[b]) && do_touch(openings[a], openings[b], rims[a]))
        sets.merge(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
  std::map<std::uint32_t, std::size_t> group_of;
  std::vector<OpeningGroup> groups;
  for (std::size_t o = 0; o < openings.size(); ++o) {
    const auto [at, is_new] = group_of.try_emplace(sets.find(static_cast<std::uint32_t>(o)), groups.size());
    if (is_new) groups.emplace_back();
    groups[at->second].members.push_back(o);
  }
  for (OpeningGroup& group : groups) {
    EndSection& section = group.section;
    section.plane.normal = openings[group.members[0]].normal;
    for (const std::size_t m : group.members) {
      section.area_mm2 += openings[m].area_mm2;
      section.plane.point_mm += openings[m].area_mm2 * openings[m].centre_mm;
    }
    section.plane.point_mm /= section.area_mm2;
    for (const std::size_t m : group.members)
      for (const Vec3& x : rims[m])
        section.reach_mm = std::max(section.reach_mm, (x - section.plane.point_mm).norm());
  }
  return groups;
}

std::shared_ptr<CarriedSection> section_of(std::span<const Opening> openings,
                                           std::span<const OpeningGroup> groups, std::size_t group,
                                           const Vec3& direction, double air_mm, double voxel_mm) {
  constexpr double kFine = 0.5, kSquares = 24;  // Voxels; along the reach.
  const OpeningGroup& own = groups[group];
  const CutPlane& plane = own.section.plane;
  std::vector<Vec3> rim, others;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (!are_in_one_plane(openings[own.members[0]], openings[groups[g].members[0]])) continue;
    for (const std::size_t m : groups[g].members) {
      const std::vector<Vec3> places = rim_places(openings[m]);
      std::vector<Vec3>& to = g == group ? rim : others;
      to.insert(to.end(), places.begin(), places.end());
    }
  }
  auto section = std::make_shared<CarriedSection>();
  section->centre_mm = plane.point_mm;
  section->normal = plane.normal;
  section->direction = direction;
  section->u = plane.normal.unitOrthogonal();
  section->v = plane.normal.cross(section->u);
  section->step_mm = std::max(kFine * voxel_mm, own.section.reach_mm / kSquares);
  const int half = static_cast<int>(std::ceil((own.section.reach_mm + air_mm) / section->step_mm)) + 1;
  section->columns = section->rows = 2 * half + 1;
  section->first_mm = plane.point_mm - half * section->step_mm * (section->u + section->v);
  section->inside.resize(static_cast<std::size_t>(section->columns) *
                         static_cast<std::size_t>(section->rows));
  parallel::for_each_index(section->inside.size(), 64, [&](std::size_t s) {
    const auto columns = static_cast<std::size_t>(section->columns);
    const std::size_t row = s / columns, column = s % columns;
    const Vec3 x = section->first_mm + section->step_mm * (static_cast<double>(column) * section->u +
                                                           static_cast<double>(row) * section->v);
    const bool is_own =
        std::ranges::any_of(own.members, [&](std::size_t m) { return openings[m].squares->hold(x); });
    const double off_mm = is_own ? 0 : nearest_mm(rim, x);
    section->inside[s] = static_cast<float>(std::min(air_mm - off_mm, (nearest_mm(others, x) - off_mm) / 2));
  });
  return section;
}

}  // namespace lumesh
