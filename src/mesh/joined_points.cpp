#include "joined_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::detail {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

struct Extent {
  Box3 box;
  double shortest_edge = kInfinite;
};

Extent extent_of(std::span<const PartSurface> parts) {
  Extent all;
  for (const PartSurface& part : parts) {
    const std::vector<Vec3>& points = part.mesh->points;
    for (const std::uint32_t v : part.points) all.box.extend(points[v]);
    for (const FaceCorners& face : part.faces)
      for (std::size_t i = 0; i < 4; ++i)
        if (const double length = (points[face[i]] - points[face[(i + 1) % 4]]).norm();
            face[i] != face[(i + 1) % 4])
          all.shortest_edge = std::min(all.shortest_edge, length);
  }
  return all;
}

double tolerance_for(const Extent& extent, std::optional<double> wanted) {
  constexpr double kMaxOfEdge = 0.5;
  if (!wanted) {
    const double largest = extent.box.min().cwiseAbs().cwiseMax(extent.box.max().cwiseAbs()).maxCoeff();
    return std::min(kUsualOfCoordinate * largest, kUsualOfEdge * extent.shortest_edge);
  }
  if (!(*wanted >= 0) || !std::isfinite(*wanted))
    throw Error(ErrorKind::kBadInput, "the tolerance must be a number of 0 or more");
  if (*wanted > kMaxOfEdge * extent.shortest_edge)
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("the tolerance {:g} is more than half of the shortest edge of the surfaces, {:.4g}; "
                    "give a smaller one",
                    *wanted, extent.shortest_edge));
  return *wanted;
}

/// Points sorted by the cell of a grid that they lie in.
class PointGrid {
 public:
  PointGrid(std::span<const Vec3> points, std::span<const std::uint32_t> numbers, const Extent& extent,
            double tolerance)
      : points_(points), low_(extent.box.min()), tolerance_(tolerance) {
    constexpr double kCellsPerAxis = 1 << 20, kTolerances = 4;
    const double size = extent.box.diagonal().maxCoeff();
    width_ = std::max({size / kCellsPerAxis, kTolerances * tolerance, std::numeric_limits<double>::min()});
    entries_.reserve(numbers.size());
    for (const std::uint32_t v : numbers) entries_.emplace_back(key_at(cell_of(points[v])), v);
    parallel::sort(entries_.begin(), entries_.end());
  }

  /// The nearest point within the tolerance, the lowest of equally near ones; kNone if there is none.
  [[nodiscard]] std::uint32_t nearest(const Vec3& place) const {
    const Cells low = cell_of(place - Vec3::Constant(tolerance_)),
                high = cell_of(place + Vec3::Constant(tolerance_));
    std::pair<double, std::uint32_t> best = {kInfinite, VertexId::kNone};
    for (std::uint64_t i = low[0]; i <= high[0]; ++i)
      for (std::uint64_t j = low[1]; j <= high[1]; ++j)
        for (std::uint64_t k = low[2]; k <= high[2]; ++k) best = std::min(best, nearest_in({i, j, k}, place));
    return best.first <= tolerance_ ? best.second : VertexId::kNone;
  }

 private:
  using Cells = std::array<std::uint64_t, 3>;

  [[nodiscard]] Cells cell_of(const Vec3& place) const {
    constexpr double kMax = (1 << 21) - 1;
    Cells cell;
    for (int a = 0; a < 3; ++a)
      cell[static_cast<std::size_t>(a)] =
          static_cast<std::uint64_t>(std::clamp(std::floor((place[a] - low_[a]) / width_), 0.0, kMax));
    return cell;
  }
  static std::uint64_t key_at(const Cells& cell) { return cell[0] << 42 | cell[1] << 21 | cell[2]; }
  [[nodiscard]] std::pair<double, std::uint32_t> nearest_in(const Cells& cell, const Vec3& place) const {
    const std::uint64_t key = key_at(cell);
    std::pair<double, std::uint32_t> best = {kInfinite, VertexId::kNone};
    auto entry = std::ranges::lower_bound(entries_, std::pair(key, std::uint32_t{0}));
    for (; entry != entries_.end() && entry->first == key; ++entry)
      best = std::min(best, {(points_[entry->second] - place).norm(), entry->second});
    return best;
  }

  std::span<const Vec3> points_;
  Vec3 low_;
  double tolerance_;
  double width_ = 1;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> entries_;  // Cell and point.
};

/// Joins one part after the other to those before.
class PointJoiner {
 public:
  PointJoiner(const Extent& extent, double tolerance) : extent_(extent) { joined_.tolerance = tolerance; }

  void add(const PartSurface& part) {
    const std::vector<std::uint32_t> found = found_before(part);
    require_distinct(part, found);
    const std::vector<Vec3>& points = part.mesh->points;
    std::vector<std::uint32_t>& numbers = joined_.numbers.emplace_back(points.size(), VertexId::kNone);
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (found[i] == VertexId::kNone) continue;
      numbers[part.points[i]] = found[i];
      joined_.is_shared[found[i]] = 1;
      joined_.farthest =
          std::max(joined_.farthest, (points[part.points[i]] - joined_.points[found[i]]).norm());
    }
    for (std::size_t v = 0; v < points.size(); ++v) {
      if (numbers[v] != VertexId::kNone) continue;
      numbers[v] = static_cast<std::uint32_t>(joined_.points.size());
      joined_.points.push_back(points[v]);
    }
    joined_.is_shared.resize(joined_.points.size(), 0);
    for (std::size_t i = 0; i < found.size(); ++i)
      if (found[i] == VertexId::kNone) on_surface_.push_back(numbers[part.points[i]]);
  }
  [[nodiscard]] JoinedPoints take() { return std::move(joined_); }

 private:
  /// For each point of the surface, the one it becomes; kNone: a new one.
  [[nodiscard]] std::vector<std::uint32_t> found_before(const PartSurface& part) const {
    std::vector<std::uint32_t> found(part.points.size());
    const PointGrid grid(joined_.points, on_surface_, extent_, joined_.tolerance);
    parallel::for_each_index(
        found.size(), [&](std::size_t i) { found[i] = grid.nearest(part.mesh->points[part.points[i]]); });
    return found;
  }
  void require_distinct(const PartSurface& part, std::vector<std::uint32_t> found) const {
    std::ranges::sort(found);
    for (std::size_t i = 1; i < found.size() && found[i] != VertexId::kNone; ++i)
      if (found[i] == found[i - 1])
        throw Error(
            ErrorKind::kBadInput,
            fmt::format("{}: has two points within {:.3g} of one of the others, at {}; give a smaller "
                        "tolerance, or join them first",
                        part.name, joined_.tolerance, coordinates_text(joined_.points[found[i]])));
  }

  Extent extent_;
  JoinedPoints joined_;
  std::vector<std::uint32_t> on_surface_;  // Of the parts so far.
};

}  // namespace

JoinedPoints join_points(std::span<const PartSurface> parts, std::optional<double> tolerance) {
  const Extent extent = extent_of(parts);
  PointJoiner joiner(extent, tolerance_for(extent, tolerance));
  std::size_t count = 0;
  for (const PartSurface& part : parts) count += part.mesh->points.size();
  if (count >= VertexId::kNone)
    throw Error(ErrorKind::kBadInput, "the meshes have more than 4 billion points together; coarsen them");
  for (const PartSurface& part : parts) joiner.add(part);
  return joiner.take();
}

}  // namespace lumesh::detail
