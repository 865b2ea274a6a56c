// Places behind flat pieces of a surface.
#include "../src/domain/room_behind.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace lumesh::surfaces {
namespace {

/// A rectangle over [from, to] x [0, 4] at a height, turned upwards.
void add_rectangle(double from, double to, double height, std::uint32_t columns, std::uint32_t rows,
                   ClosedSurface& surface) {
  const auto first = static_cast<std::uint32_t>(surface.points.size());
  for (std::uint32_t i = 0; i <= columns; ++i)
    for (std::uint32_t j = 0; j <= rows; ++j)
      surface.points.emplace_back(from + (to - from) * i / columns, 4.0 * j / rows, height);
  for (std::uint32_t i = 0; i < columns; ++i)
    for (std::uint32_t j = 0; j < rows; ++j) {
      const std::uint32_t a = first + i * (rows + 1) + j, b = a + rows + 1;
      surface.triangles.push_back({a, b, b + 1});
      surface.triangles.push_back({a, b + 1, a + 1});
    }
}

/// Whether a piece of 4 by 6 is deep over which a floor lies 0.5 below a share of it.
bool is_deep_beside_a_floor(double share, std::uint32_t over_floor, std::uint32_t beside) {
  ClosedSurface surface;
  add_rectangle(0, 6 * share, 0, over_floor, over_floor, surface);
  add_rectangle(6 * share, 6, 0, beside, beside, surface);
  std::vector<std::uint32_t> piece(surface.triangles.size());
  std::iota(piece.begin(), piece.end(), 0U);
  add_rectangle(-1, 6 * share, -0.5, 1, 1, surface);
  return RoomBehind(surface).is_deep(piece, 0.02, 2);
}

TEST(RoomBehind, APieceIsDeepByItsAreaHoweverItIsDivided) {
  for (const std::uint32_t over_floor : {1U, 2U, 9U})
    for (const std::uint32_t beside : {1U, 2U, 9U})
      for (const double share : {0.05, 0.35, 0.65, 0.95})
        EXPECT_EQ(is_deep_beside_a_floor(share, over_floor, beside), share < 0.5)
            << share << ' ' << over_floor << ' ' << beside;
}

}  // namespace
}  // namespace lumesh::surfaces
