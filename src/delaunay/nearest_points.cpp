#include "nearest_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::delaunay {
namespace {

/// A block of cells with no more candidates is not split: they are compared as fast as two loads from memory.
constexpr std::size_t kFewCandidates = 8;
/// Cells along each axis: 2^6 and, from so many points on, 2^7 (16 MB).
constexpr std::uint32_t kCoarseLevels = 6, kFineLevels = 7;
constexpr std::size_t kManyPoints = 1000;

using CellPlace = std::array<std::uint32_t, 3>;

}  // namespace

/// The cells of one block, with a list of candidates of their own.
struct NearestPoints::Builder {
  /// A box of cells: at level n, place p holds 2^(levels - n) cells along each axis.
  struct Block {
    Vec3 centre;
    Vec3 half;
    std::uint32_t level;
    CellPlace place;

    [[nodiscard]] Block child(unsigned octant) const {
      Block inner{centre, half / 2, level + 1, {}};
      for (unsigned a = 0; a < 3; ++a) {
        const unsigned above = octant >> a & 1U;
        inner.centre[a] += above != 0 ? inner.half[a] : -inner.half[a];
        inner.place[a] = 2 * place[a] + above;
      }
      return inner;
    }
  };

  const std::vector<Vec3>& points;
  DistanceRange range;
  std::uint32_t levels;
  std::vector<std::pair<Block, List>> blocks = {};
  std::vector<Vec3> candidates = {};

  /// True if q is nearer than (1 + error) times p all over the block. The difference of squared distances is
  /// linear there, or concave: its tangent at the centre bounds it.
  [[nodiscard]] bool beats(std::uint32_t q, std::uint32_t p, const Block& block, double error) const {
    const Vec3 to_q = block.centre - points[q], to_p = block.centre - points[p];
    const double scale = (1 + error) * (1 + error), p2 = scale * to_p.squaredNorm();
    const double bound = to_q.squaredNorm() - p2 + 2 * block.half.dot((to_q - scale * to_p).cwiseAbs());
    constexpr double kRounding = 1e-12;  // Relative to what was subtracted; a tie may keep both.
    return bound < -kRounding * p2;
  }

  [[nodiscard]] std::uint32_t nearest(std::span<const std::uint32_t> from, const Vec3& x) const {
    return *std::ranges::min_element(from, [&](std::uint32_t a, std::uint32_t b) {
      return (points[a] - x).squaredNorm() < (points[b] - x).squaredNorm();
    });
  }

  /// The points of `from` that may be the nearest of a place in the block, and some more.
  [[nodiscard]] std::vector<std::uint32_t> remaining(std::span<const std::uint32_t> from, std::uint32_t best,
                                                     const Block& block) const {
    std::vector<std::uint32_t> kept;
    for (const std::uint32_t p : from)
      if (p == best || !beats(best, p, block, 0)) kept.push_back(p);
    return kept;
  }

  /// The points of `kept` that stand for all of them within kMaxError, or none if it takes more than
  /// `max_count`.
  [[nodiscard]] std::vector<std::uint32_t> reduced(std::span<const std::uint32_t> kept, std::uint32_t best,
                                                   const Block& block, std::size_t max_count) const {
    std::vector<std::uint32_t> few = {best};
    for (const std::uint32_t p : kept) {
      if (p == best ||
          std::ranges::any_of(few, [&](std::uint32_t q) { return beats(q, p, block, kMaxError); }))
        continue;
      if (few.size() == max_count) return {};
      few.push_back(p);
    }
    return few;
  }

  void build(std::span<const std::uint32_t> from, const Block& block) {
    const std::uint32_t best = nearest(from, block.centre);
    const double at_centre = (points[best] - block.centre).norm(), reach = block.half.norm();
    if (at_centre + reach <= range.smallest || at_centre - reach >= range.largest) {
      blocks.emplace_back(block, List{at_centre + reach <= range.smallest ? kNear : kFar, 0});
      return;
    }
    const std::vector<std::uint32_t> kept = remaining(from, best, block);
    const bool is_cell = block.level == levels;
    const std::vector<std::uint32_t> few = reduced(kept, best, block, is_cell ? kept.size() : kFewCandidates);
    if (few.empty()) {
      for (unsigned octant = 0; octant < 8; ++octant) build(kept, block.child(octant));
      return;
    }
    blocks.emplace_back(
        block, List{static_cast<std::uint32_t>(candidates.size()), static_cast<std::uint32_t>(few.size())});
    for (const std::uint32_t p : few) candidates.push_back(points[p]);
  }

  /// Writes the lists to all cells of the blocks; candidates are moved back by `first`.
  void fill(std::vector<List>& cells, std::uint32_t first) const {
    for (const auto& [block, list] : blocks) {
      const std::uint32_t shift = levels - block.level, edge = 1U << shift;
      const List moved = {list.count > 0 ? list.first + first : list.first, list.count};
      for (std::uint32_t k = 0; k < edge; ++k) {
        for (std::uint32_t j = 0; j < edge; ++j) {
          const std::size_t row =
              ((((std::size_t{block.place[2]} << shift) + k) << levels) + (block.place[1] << shift) + j)
              << levels;
          std::fill_n(cells.begin() + static_cast<std::ptrdiff_t>(row + (block.place[0] << shift)), edge,
                      moved);
        }
      }
    }
  }
};

NearestPoints::NearestPoints(std::span<const Vec3> points, const Box3& region, DistanceRange range)
    : range_(range), points_(points.begin(), points.end()) {
  sort_unique(points_, precedes);
  Box3 box = bounding_box(points_);
  const Vec3 around = Vec3::Constant(0.1 * box.diagonal().norm() + 1e-3);
  box = Box3(box.min() - around, box.max() + around).merged(region);
  levels_ = points_.size() < kManyPoints ? kCoarseLevels : kFineLevels;
  low_ = box.min();
  cells_per_mm_ = std::ldexp(1, static_cast<int>(levels_)) / box.sizes().array();

  std::vector<std::uint32_t> all(points_.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint32_t>(i);
  // Blocks of the second level are built at the same time.
  constexpr std::size_t kParts = 64;
  const Builder::Block root{box.center(), 0.5 * box.sizes(), 0, {0, 0, 0}};
  std::vector<Builder> parts(kParts, Builder{points_, range_, levels_});
  parallel::for_each_index(kParts, 1, [&](std::size_t i) {
    const auto octants = static_cast<unsigned>(i);
    parts[i].build(all, root.child(octants / 8).child(octants % 8));
  });
  cells_.resize(std::size_t{1} << (3 * levels_));
  for (const Builder& part : parts) {
    part.fill(cells_, static_cast<std::uint32_t>(candidates_.size()));
    candidates_.insert(candidates_.end(), part.candidates.begin(), part.candidates.end());
  }
}

double NearestPoints::held(double squared_distance) const {
  return std::clamp(std::sqrt(squared_distance), range_.smallest, range_.largest);
}

double NearestPoints::distance(const Vec3& x) const {
  const Vec3 place = (x - low_).cwiseProduct(cells_per_mm_);
  double smallest2 = std::numeric_limits<double>::infinity();
  if (!(place.minCoeff() >= 0 && place.maxCoeff() < static_cast<double>(1U << levels_))) {
    for (const Vec3& p : points_) smallest2 = std::min(smallest2, (p - x).squaredNorm());
    return held(smallest2);
  }
  const List list =
      cells_[((static_cast<std::size_t>(place.z()) << levels_ | static_cast<std::size_t>(place.y()))
              << levels_) |
             static_cast<std::size_t>(place.x())];
  if (list.count == 0) return list.first == kNear ? range_.smallest : range_.largest;
  for (std::uint32_t i = 0; i < list.count; ++i)
    smallest2 = std::min(smallest2, (candidates_[list.first + i] - x).squaredNorm());
  return held(smallest2);
}

}  // namespace lumesh::delaunay
