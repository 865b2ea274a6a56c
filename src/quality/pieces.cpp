#include "pieces.hpp"

#include <algorithm>

#include "cell_faces.hpp"
#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/grid.hpp"

namespace lumesh::quality {

VoxelPieces::VoxelPieces(const LabelImage& image)
    : runs_(image::find_runs(image, image::RunLabels::kEach)), numbers_(image::voxel_starts(runs_)) {
  DisjointSets sets = image::connected(runs_);
  pieces_.resize(runs_.runs.size());
  for (std::uint32_t r = 0; r < pieces_.size(); ++r) pieces_[r] = sets.find(r);
}

std::size_t VoxelPieces::run_of(std::size_t number) const {
  return static_cast<std::size_t>(std::ranges::upper_bound(numbers_, number) - numbers_.begin()) - 1;
}

Index3 VoxelPieces::place_of(std::size_t number) const {
  const std::size_t run = run_of(number);
  const auto row = static_cast<std::size_t>(
      std::ranges::upper_bound(runs_.first, static_cast<std::uint32_t>(run)) - runs_.first.begin() - 1);
  Index3 place = grid_row(runs_.size, row);
  place.x() = runs_.runs[run].begin + static_cast<int>(number - numbers_[run]);
  return place;
}

std::size_t VoxelPieces::number_at(const Index3& voxel) const {
  if ((voxel.array() < 0).any() || (voxel.array() >= runs_.size.array()).any()) return voxel_count();
  const std::span<const image::Run> row = runs_.of_row(runs_.row(voxel.y(), voxel.z()));
  const auto run =
      std::partition_point(row.begin(), row.end(), [&](const image::Run& r) { return r.end <= voxel.x(); });
  if (run == row.end() || run->begin > voxel.x()) return voxel_count();
  return numbers_[static_cast<std::size_t>(&*run - runs_.runs.data())] +
         static_cast<std::size_t>(voxel.x() - run->begin);
}

CellPieces find_cell_pieces(const MeshView& mesh, std::span<const TopologyDifference> differences) {
  const AllCells cells(mesh);
  std::vector<char> is_asked(cells.size());
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    const Label label = cells.label(cell);
    is_asked[cell] =
        std::ranges::any_of(differences, [&](const TopologyDifference& d) { return d.label == label; });
  }
  std::vector<std::array<std::uint32_t, 2>> pairs;
  const parallel::KeyTable<CellFace> faces = collect_faces(mesh);
  faces.for_each_run(same_corners, [&](std::span<const CellFace> run) {
    if (run.size() == 2 && is_asked[run[0].cell] && cells.label(run[0].cell) == cells.label(run[1].cell))
      pairs.push_back({run[0].cell, run[1].cell});
  });
  CellPieces result;
  DisjointSets sets(cells.size());
  for (const auto& [a, b] : pairs) sets.merge(a, b);
  result.neighbours = parallel::cells_around(pairs, cells.size());
  for (std::uint32_t cell = 0; cell < cells.size(); ++cell)
    for (std::size_t i = result.neighbours.starts[cell]; i < result.neighbours.starts[cell + 1]; ++i) {
      const auto& [a, b] = pairs[result.neighbours.items[i]];
      result.neighbours.items[i] = a == cell ? b : a;
    }
  result.piece.resize(cells.size(), kNoPiece);
  for (std::uint32_t cell = 0; cell < cells.size(); ++cell)
    if (is_asked[cell]) result.piece[cell] = sets.find(cell);
  return result;
}

}  // namespace lumesh::quality
