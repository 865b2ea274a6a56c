#include "section_changes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "section_waists.hpp"

namespace lumesh {
namespace {

constexpr double kWidest = 6;  // Radius in voxels.
constexpr double kDoubtful = 0.04,
                 kMouth = 0.2;    // Changes within a voxel: mouths of branches change by more.
constexpr double kSteady = 0.08;  // Change per voxel further in, of a vessel.
constexpr double kSteps = 6;      // Squares along a voxel.
constexpr double kMargin = 5;     // Voxels around the opening: sections further in lie beside it.

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

std::optional<double> doubtful_change(const Domain& domain, const Opening& opening) {
  if (!opening.squares || opening.is_rim || opening.is_hollow()) return std::nullopt;
  const double voxel_mm = opening.voxel_mm;
  if (opening.area_mm2 > std::numbers::pi * kWidest * kWidest * voxel_mm * voxel_mm) return std::nullopt;
  const OpeningSquares wide = wider(*opening.squares, voxel_mm);
  const auto area = [&](double voxels) {
    const OpeningSquares squares =
        section_before(domain, opening.label, wide, -voxels * voxel_mm * opening.normal);
    return static_cast<double>(std::ranges::count(squares.is_inside, std::uint8_t{1}));
  };
  // Not at the border itself, where half of the samples are rounded to lie outside.
  const double last = area(0.02), next = area(1), third = area(2), fifth = area(4);
  if (!(next > 0 && third > 0 && fifth > 0)) return std::nullopt;
  const double trend = 0.5 * (third / fifth - 1), change = last / next - 1 - trend;
  if (std::abs(change) < kDoubtful || std::abs(change) > kMouth || std::abs(trend) > kSteady)
    return std::nullopt;
  return change;
}

}  // namespace lumesh
