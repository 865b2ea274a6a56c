#include "neighbourhoods.hpp"

namespace lumesh::operators {

std::array<int, 2> other_corners(int i, int j) {
  std::array<int, 2> others{};
  for (int k = 0, n = 0; k < 4; ++k)
    if (k != i && k != j) others[n++] = k;
  // (i, j, first, second) must be an even permutation of (0, 1, 2, 3).
  const std::array<int, 4> order = {i, j, others[0], others[1]};
  int inversions = 0;
  for (int k = 0; k < 4; ++k)
    for (int m = k + 1; m < 4; ++m) inversions += order[k] > order[m] ? 1 : 0;
  if (inversions % 2 != 0) std::swap(others[0], others[1]);
  return others;
}

}  // namespace lumesh::operators
