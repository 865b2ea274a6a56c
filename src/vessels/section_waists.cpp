#include "section_waists.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/squares.hpp"
#include "lumesh/image/distance.hpp"

namespace lumesh {
namespace {

constexpr double kWaist = 0.9;       // Width, of the narrower part's diameter.
constexpr double kNarrow = 0.85;     // Width in one of the two sections that are looked at.
constexpr double kNarrowest = 1.5;   // Radius of a part in voxels: those of noise are narrower.
constexpr double kMostOfCircle = 2;  // Area of a part, of that of its inscribed circle.

/// Distance of each square from the outline, in steps, with a margin of one square around the grid; 0
/// outside.
std::vector<float> distances_from_outline(const OpeningSquares& squares) {
  LabelImage section({.size = {squares.columns + 2, squares.rows + 2, 1}}, {kBackground, 1});
  const Index3 size = section.frame().size;
  for (int row = 0; row < squares.rows; ++row)
    for (int column = 0; column < squares.columns; ++column)
      section.at({column + 1, row + 1, 0}) = squares.hold(column, row) ? 1 : 0;
  std::vector<float> distance =
      distance_to_label_change(section, Index3::Zero(), size, size.maxCoeff()).distance_mm;
  for (std::size_t s = 0; s < distance.size(); ++s)
    distance[s] = section.voxels()[s] == 0 ? 0 : distance[s] - 0.5F;  // The outline runs between centres.
  return distance;
}

/// Parts of a section by the watersheds of the distances from its outline, numbered by falling radii.
class SectionParts {
 public:
  /// @param narrowest_mm  Radius of the narrowest part that stays one of its own.
  SectionParts(const OpeningSquares& squares, double narrowest_mm)
      : step_mm_(squares.step_mm),
        narrowest_(narrowest_mm / squares.step_mm),
        columns_(static_cast<std::size_t>(squares.columns) + 2),
        distance_(distances_from_outline(squares)),
        sets_(distance_.size()),
        part_of_(distance_.size(), kNone) {
    std::vector<std::uint32_t> falling;
    for (std::uint32_t s = 0; s < distance_.size(); ++s)
      if (distance_[s] > 0) falling.push_back(s);
    std::ranges::stable_sort(falling, std::greater<>(), [&](std::uint32_t s) { return distance_[s]; });
    for (const std::uint32_t s : falling) add(s);
    areas_.assign(peaks_.size(), 0);
    for (const std::uint32_t s : falling) ++areas_[sets_.find(part_of_[s])];
  }

  /// The narrowest waist between two compact parts; of no width where nothing joins them.
  [[nodiscard]] std::optional<SectionWaist> narrowest_waist() {
    std::optional<SectionWaist> narrowest;
    std::set<std::pair<std::uint32_t, std::uint32_t>> known;
    const auto look = [&](std::uint32_t a, std::uint32_t b, double half_width) {
      if (a == b || !known.emplace(std::min(a, b), std::max(a, b)).second) return;
      if (!is_compact(a) || !is_compact(b)) return;
      const auto [less, more] = std::minmax({radius(a), radius(b)});
      const SectionWaist waist{2 * step_mm_ * half_width, {2 * step_mm_ * more, 2 * step_mm_ * less}};
      if (!narrowest || waist.share() < narrowest->share()) narrowest = waist;
    };
    DisjointSets joined(distance_.size());
    for (const Pass& pass : passes_) {  // The first one between two parts is the widest.
      const std::uint32_t a = sets_.find(pass.parts[0]), b = sets_.find(pass.parts[1]);
      joined.merge(a, b);
      look(a, b, pass.radius);
    }
    std::vector<std::uint32_t> roots;
    for (std::uint32_t a = 0; a < peaks_.size(); ++a)
      if (sets_.find(a) == a && is_compact(a)) roots.push_back(a);
    for (const std::uint32_t a : roots)
      for (const std::uint32_t b : roots)
        if (joined.find(a) != joined.find(b)) look(a, b, 0);
    return narrowest;
  }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  struct Pass {
    std::array<std::uint32_t, 2> parts;
    double radius;
  };

  void add(std::uint32_t square) {
    std::set<std::uint32_t> beside;
    for_each_square_beside(columns_, distance_.size(), square, [&](std::size_t s) {
      if (part_of_[s] != kNone) beside.insert(sets_.find(part_of_[s]));
    });
    if (beside.empty()) {
      part_of_[square] = static_cast<std::uint32_t>(peaks_.size());
      peaks_.push_back(square);
      return;
    }
    const std::uint32_t widest = part_of_[square] = *beside.begin();
    for (const std::uint32_t other : beside) {
      if (other == widest) continue;
      if (radius(other) < narrowest_ || distance_[square] > kWaist * radius(other))
        sets_.merge(widest, other);
      else
        passes_.push_back({{widest, other}, distance_[square]});
    }
  }
  /// Radius of its largest inscribed circle.
  [[nodiscard]] double radius(std::uint32_t part) const { return distance_[peaks_[part]]; }
  [[nodiscard]] bool is_compact(std::uint32_t part) const {
    return radius(part) >= narrowest_ &&
           static_cast<double>(areas_[part]) < kMostOfCircle * std::numbers::pi * radius(part) * radius(part);
  }

  double step_mm_, narrowest_;
  std::size_t columns_;
  std::vector<float> distance_;
  DisjointSets sets_;
  std::vector<std::uint32_t> part_of_;  // Part of each square.
  std::vector<std::uint32_t> peaks_;    // Square farthest from the outline, of each part.
  std::vector<std::size_t> areas_;      // Squares of each part.
  std::vector<Pass> passes_;
};

}  // namespace

OpeningSquares section_before(const Domain& domain, Label label, const OpeningSquares& section,
                              const Vec3& way_mm) {
  OpeningSquares before = section;
  before.first_mm += way_mm;
  for (int row = 0; row < before.rows; ++row)
    for (int column = 0; column < before.columns; ++column) {
      const Material m = domain.material_at(before.centre_of(column, row));
      const bool is_label = domain.is_meshed(m) && domain.label_of(m) == label;
      before.is_inside[before.square(column, row)] = is_label ? 1 : 0;
    }
  const std::vector<std::uint32_t> part =
      connected_squares(static_cast<std::size_t>(before.columns), before.is_inside.size(),
                        [&](std::size_t s) { return before.is_inside[s]; });
  std::set<std::uint32_t> is_before;
  for (std::size_t s = 0; s < part.size(); ++s)
    if (section.is_inside[s] != 0) is_before.insert(part[s]);
  for (std::size_t s = 0; s < part.size(); ++s)
    if (!is_before.contains(part[s])) before.is_inside[s] = 0;
  return before;
}

std::optional<SectionWaist> find_waist(const Domain& domain, const Opening& opening) {
  if (!opening.squares || opening.is_rim || opening.is_hollow()) return std::nullopt;
  const double narrowest_mm = kNarrowest * opening.voxel_mm;
  std::optional<SectionWaist> waist = SectionParts(*opening.squares, narrowest_mm).narrowest_waist();
  if (!waist) return waist;
  const double depth_mm = 0.5 * waist->diameters_mm[1];
  const std::optional<SectionWaist> before =
      SectionParts(section_before(domain, opening.label, *opening.squares, -depth_mm * opening.normal),
                   narrowest_mm)
          .narrowest_waist();
  const bool is_one = !before || std::min(waist->share(), before->share()) > kNarrow;
  return is_one ? std::nullopt : waist;
}

}  // namespace lumesh
