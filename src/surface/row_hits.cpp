#include "row_hits.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lumesh/geometry/predicates.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::surfaces {
namespace {

int sign_of(double x) {
  return (x > 0) - (x < 0);
}

/// On which side of a line a place lies that is moved by (e, e^2), e > 0 beyond all measure; 0 where the line
/// is a point.
int side_of_line(const Vec2& from, const Vec2& to, const Vec2& place) {
  const int side = orient2d(from, to, place);
  if (side != 0) return side;
  return from.y() != to.y() ? sign_of(from.y() - to.y()) : sign_of(to.x() - from.x());
}

struct Range {
  int first, last;
};

/// Whole numbers in a range, of those from 0 to count - 1.
Range whole_numbers(double low, double high, int count) {
  return {static_cast<int>(std::clamp(std::ceil(low), 0.0, static_cast<double>(count))),
          static_cast<int>(std::clamp(std::floor(high), -1.0, count - 1.0))};
}

/// A triangle seen along an axis.
class FlatTriangle {
 public:
  explicit FlatTriangle(const std::array<Vec2, 3>& corners) : corners_(corners) {}

  /// 1 or -1 as the triangle runs around a place, 0 where it does not.
  [[nodiscard]] int turn_around(const Vec2& place) const {
    const int side = side_of_line(corners_[0], corners_[1], place);
    return side == side_of_line(corners_[1], corners_[2], place) &&
                   side == side_of_line(corners_[2], corners_[0], place)
               ? side
               : 0;
  }
  /// What of a line y is within it, rounded outwards.
  [[nodiscard]] std::pair<double, double> extent_at(double y) const {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec2 &a = corners_[i], &b = corners_[(i + 1) % 3];
      const double length = b.y() - a.y();
      const double share = length == 0 ? 0 : std::clamp((y - a.y()) / length, 0.0, 1.0);
      const double x = a.x() + share * (b.x() - a.x());
      if (std::min(a.y(), b.y()) > y || std::max(a.y(), b.y()) < y) continue;
      low = std::min({low, x, length == 0 ? b.x() : x});
      high = std::max({high, x, length == 0 ? b.x() : x});
    }
    constexpr double kRounding = 1e-6;
    return {low - kRounding, high + kRounding};
  }
  /// Shares of the corners in a place, not more than rounding off.
  [[nodiscard]] Vec3 shares_at(const Vec2& place) const {
    Vec3 shares;
    for (int i = 0; i < 3; ++i) {
      const auto n = static_cast<std::size_t>(i);
      const Vec2 to_next = corners_[(n + 1) % 3] - place, to_last = corners_[(n + 2) % 3] - place;
      shares[i] = to_next.x() * to_last.y() - to_next.y() * to_last.x();
    }
    const double sum = shares.sum();
    return sum != 0 ? Vec3(shares / sum) : Vec3(Vec3::Constant(1.0 / 3));
  }

 private:
  std::array<Vec2, 3> corners_;
};

}  // namespace

RowHits::RowHits(std::span<const Vec3> points, std::span<const Cell<3>> triangles, const Index3& size,
                 int axis)
    : axis_(axis),
      across_{(axis + 1) % 3, (axis + 2) % 3},
      size_(size),
      table_(parallel::collect_blocks<RowHit>(
                 triangles.size(), 256,
                 [&](std::size_t begin, std::size_t end, std::vector<RowHit>& out) {
                   for (std::size_t t = begin; t < end; ++t)
                     collect(points, triangles[t], static_cast<std::uint32_t>(t), out);
                 }),
             row_of(0, size[across_[1]]), [](const RowHit& hit) { return hit.row; }) {}

void RowHits::collect(std::span<const Vec3> points, const Cell<3>& corners, std::uint32_t triangle,
                      std::vector<RowHit>& out) const {
  std::array<Vec2, 3> flat;
  Vec3 along, second;
  for (int i = 0; i < 3; ++i) {
    const auto n = static_cast<std::size_t>(i);
    const Vec3& p = points[corners[n]];
    flat[n] = {p[across_[0]], p[across_[1]]};
    along[i] = p[axis_];
    second[i] = p[across_[1]];
  }
  const FlatTriangle shape(flat);
  const Range lines = whole_numbers(second.minCoeff(), second.maxCoeff(), size_[across_[1]]);
  for (int y = lines.first; y <= lines.last; ++y) {
    const auto [low, high] = shape.extent_at(y);
    const Range places = whole_numbers(low, high, size_[across_[0]]);
    for (int x = places.first; x <= places.last; ++x) {
      const Vec2 place(x, y);
      const int turn = shape.turn_around(place);
      if (turn == 0) continue;
      const double at = std::clamp(shape.shares_at(place).dot(along), along.minCoeff(), along.maxCoeff());
      out.push_back({static_cast<std::uint32_t>(row_of(x, y)), at, triangle, -turn});
    }
  }
}

}  // namespace lumesh::surfaces
