#include "section_changes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "lumesh/field/section_error.hpp"
#include "section_waists.hpp"

namespace lumesh {
namespace {

constexpr double kWidest = 6;        // Radius in voxels: errors of wider ones are less.
constexpr double kDoubtful = 0.085;  // Expected error of an area.
constexpr double kSteps = 6;         // Squares along a voxel.
constexpr double kMargin = 5;        // Voxels around the opening: sections further in lie beside it.

/// The squares of an opening on a wider and coarser grid.
OpeningSquares wider(const OpeningSquares& own, double voxel_mm) {
  OpeningSquares squares = own;
  squares.step_mm = std::max(own.step_mm, voxel_mm / kSteps);
  const double margin_mm = kMargin * voxel_mm;
  const auto count = [&](int of_own) {
    return static_cast<int>(std::ceil((of_own * own.step_mm + 2 * margin_mm) / squares.step_mm));
  };
  squares.columns = count(own.columns), squares.rows = count(own.rows);
  squares.first_mm -= margin_mm * (own.u + own.v);
  squares.is_inside.assign(static_cast<std::size_t>(squares.columns) * static_cast<std::size_t>(squares.rows),
                           0);
  for (int row = 0; row < squares.rows; ++row)
    for (int column = 0; column < squares.columns; ++column)
      squares.is_inside[squares.square(column, row)] = own.hold(squares.centre_of(column, row)) ? 1 : 0;
  return squares;
}

}  // namespace

std::optional<SectionDoubt> doubtful_change(const Domain& domain, const Opening& opening,
                                            const VoxelsOfOpening& voxels) {
  if (!opening.squares || opening.is_rim || opening.is_hollow()) return std::nullopt;
  const double voxel_mm = opening.voxel_mm, radius = opening.radius_mm() / voxel_mm;
  if (radius > kWidest || !(voxels.area_mm2 > 0)) return std::nullopt;
  const OpeningSquares wide = wider(*opening.squares, voxel_mm);
  const double step_mm = std::max(voxel_mm, domain.resolution_along_mm(opening.normal));
  const auto area_mm2 = [&](double steps) {
    const OpeningSquares squares =
        section_before(domain, opening.label, wide, -steps * step_mm * opening.normal);
    return static_cast<double>(std::ranges::count(squares.is_inside, std::uint8_t{1})) * wide.step_mm *
           wide.step_mm;
  };
  const double half_voxel = 0.5 * domain.resolution_along_mm(opening.normal) / step_mm;
  // Not at the border itself, where half of the samples are rounded to lie outside.
  const double last = area_mm2(0.02), layer = area_mm2(half_voxel), further = area_mm2(2);
  if (!(last > 0 && layer > 0 && further > 0)) return std::nullopt;
  const double growth = last / further - 1, too_much = std::log(layer / voxels.area_mm2);
  if (std::abs(too_much) > field::kMostError) return std::nullopt;
  const auto [mean, deviation] = field::section_error(radius, -std::log1p(growth), too_much, voxels.chance);
  const double error = std::hypot(mean, deviation);
  if (error < kDoubtful) return std::nullopt;
  const bool has_sign = std::abs(mean) > deviation;
  return SectionDoubt{growth, has_sign ? std::copysign(error, mean) : error, has_sign};
}

}  // namespace lumesh
