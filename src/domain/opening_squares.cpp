#include "opening_squares.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "opening_names.hpp"

namespace lumesh {
namespace {

using Place = Eigen::Vector2d;  // In steps of rows and columns from the first square's centre.

double turn(const Place& a, const Place& b, const Place& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

/// Marks the squares whose centres lie in a triangle, those on its edges too.
void mark(const std::array<Place, 3>& t, OpeningSquares& squares) {
  const auto first = [](double least) { return std::max(0, static_cast<int>(std::ceil(least))); };
  const auto last = [](double most, int count) {
    return std::min(count - 1, static_cast<int>(std::floor(most)));
  };
  const Place low = t[0].cwiseMin(t[1]).cwiseMin(t[2]), high = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
  for (int row = first(low.y()); row <= last(high.y(), squares.rows); ++row)
    for (int column = first(low.x()); column <= last(high.x(), squares.columns); ++column) {
      const Place x(column, row);
      const double a = turn(t[0], t[1], x), b = turn(t[1], t[2], x), c = turn(t[2], t[0], x);
      if ((a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0))
        squares.is_inside[squares.square(column, row)] = 1;
    }
}

}  // namespace

std::shared_ptr<const OpeningSquares> squares_of(const FlatEnd& end) {
  constexpr int kMax = 256;
  auto squares = std::make_shared<OpeningSquares>();
  squares->u = end.normal.unitOrthogonal();
  squares->v = end.normal.cross(squares->u);
  const auto in_plane = [&](const Vec3& x) {
    return Place((x - end.centre_mm).dot(squares->u), (x - end.centre_mm).dot(squares->v));
  };
  Eigen::AlignedBox2d box;
  for (const auto& triangle : end.triangles_mm)
    for (const Vec3& corner : triangle) box.extend(in_plane(corner));
  const Place size = box.sizes();
  squares->step_mm = size.maxCoeff() / kMax;
  squares->columns = static_cast<int>(std::ceil(size.x() / squares->step_mm));
  squares->rows = static_cast<int>(std::ceil(size.y() / squares->step_mm));
  const Place first = box.center() - 0.5 * squares->step_mm * Place(squares->columns - 1, squares->rows - 1);
  squares->first_mm = end.centre_mm + first.x() * squares->u + first.y() * squares->v;
  squares->is_inside.assign(squares->square(0, squares->rows), 0);
  for (const auto& triangle : end.triangles_mm) {
    std::array<Place, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) corners[i] = (in_plane(triangle[i]) - first) / squares->step_mm;
    mark(corners, *squares);
  }
  return squares;
}

std::vector<double> OpeningSquares::hole_areas_mm2() const {
  const PiecesAround around(*this);
  std::vector<double> areas_mm2;
  for (const std::uint32_t piece : around.numbers) {
    if (piece <= PiecesAround::kOutside) continue;
    const std::size_t hole = piece - PiecesAround::kOutside - 1;
    if (hole >= areas_mm2.size()) areas_mm2.resize(hole + 1, 0);
    areas_mm2[hole] += step_mm * step_mm;
  }
  return areas_mm2;
}

double Opening::hole_mm2() const {
  if (!squares) return 0;
  const std::vector<double> holes_mm2 = squares->hole_areas_mm2();
  const double largest = holes_mm2.empty() ? 0 : *std::ranges::max_element(holes_mm2);
  return largest > kMinSurrounded * area_mm2 ? largest : 0;
}

double Opening::lumen_radius_mm() const {
  const double hole = hole_mm2();
  return hole > 0 ? std::sqrt(hole / std::numbers::pi) : radius_mm();
}

/// Cauchy and Crofton: a curve crosses the lines of a grid 4 / pi times per step of its length, on average.
double Opening::perimeter_mm() const {
  if (!squares) return 2 * std::numbers::pi * radius_mm();
  std::size_t crossings = 0;
  for (int row = -1; row < squares->rows; ++row)
    for (int column = -1; column < squares->columns; ++column) {
      const bool here = squares->hold(column, row);
      crossings += (squares->hold(column + 1, row) != here) + (squares->hold(column, row + 1) != here);
    }
  return std::numbers::pi / 4 * squares->step_mm * static_cast<double>(crossings);
}

}  // namespace lumesh
