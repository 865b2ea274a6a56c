#pragma once
/// @file Hollows inside the voxels of a label.

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/image/runs.hpp"
#include "lumesh/image/topology.hpp"

namespace lumesh::image {

/// Pieces of what is not the label, joined through faces, edges or corners, that do not reach the outside;
/// beyond the image is outside. Cost: linear in the rows of the box and the runs in them.
/// @param box  That of the label's voxels.
[[nodiscard]] std::size_t count_cavities(const RunImage& runs, LabelImage::Index label, const VoxelBox& box);

inline constexpr std::uint32_t kOutsideSet = 0;

/// Joins the sets of background in neighbouring rows of a box, and those of its outer rows with kOutsideSet.
/// Pieces of rows touch if they share an i or have neighbouring ones: corners join the background.
/// @param row  row(j, k): pieces [begin, end) in order. @param set_of  The set of one of them.
template <class Row, class SetOf>
void join_background(int rows, int slices, const Row& row, const SetOf& set_of, DisjointSets& sets) {
  const auto join = [&](const auto& first, const auto& second) {
    for (std::size_t a = 0, b = 0; a < first.size() && b < second.size();) {
      if (first[a].begin <= second[b].end && second[b].begin <= first[a].end)
        sets.merge(set_of(first[a]), set_of(second[b]));
      if (first[a].end < second[b].end)
        ++a;
      else
        ++b;
    }
  };
  for (int k = 0; k < slices; ++k)
    for (int j = 0; j < rows; ++j) {
      if (j == 0 || k == 0 || j + 1 == rows || k + 1 == slices)
        for (const auto& piece : row(j, k)) sets.merge(kOutsideSet, set_of(piece));
      if (j > 0) join(row(j, k), row(j - 1, k));
      for (int beside = std::max(0, j - 1); k > 0 && beside <= std::min(j + 1, rows - 1); ++beside)
        join(row(j, k), row(beside, k - 1));
    }
}

}  // namespace lumesh::image
