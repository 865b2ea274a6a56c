#pragma once
// Parts of the object's wall that face each other across a narrow gap though the way through the object
// between them is long, as of vessels that run side by side. No smooth function suits both walls, so each
// part is fitted as if the others were not there.

#include <array>
#include <cstdint>
#include <vector>

#include "band.hpp"
#include "label_pairs.hpp"
#include "lumesh/parallel/adjacency.hpp"

namespace lumesh::field {

/// A part of the wall as an object of its own, in a box of the image.
struct WallPart {
  /// kInner for voxels whose function is the part's, kMargin for others that continue it, 0 elsewhere.
  LabelImage image;
  Index3 first = Index3::Zero();  ///< Voxel of the whole image that is the box's first.
  PairFaces faces;

  static constexpr LabelIndex kMargin = 1, kInner = 2;
};

/// Supervoxels: object voxels of the band in one cube that hang together by faces. Parts are sets of
/// supervoxels that hang together, none of which faces another one of the same part.
class FacingWalls {
 public:
  /// Cost: linear in the band. @param band  Of the outer wall.
  explicit FacingWalls(const Band& band);

  [[nodiscard]] std::size_t part_count() const { return parts_.size(); }
  [[nodiscard]] WallPart part(std::size_t number) const;
  /// Whether the supervoxel nearest to a lane is one that part() of this number has as an object.
  [[nodiscard]] bool is_of_part(Lane lane, std::size_t number) const;

 private:
  using Cell = std::uint32_t;  // Number of a supervoxel, from 1.
  /// A supervoxel near a part, and how many others are on the way to those of the part that face another one.
  struct NearCell {
    Cell cell = 0;
    int steps = 0;
  };

  void find_cells();
  void find_neighbours();
  [[nodiscard]] bool are_neighbours(Cell a, Cell b) const;
  /// Pairs of supervoxels, more than two steps apart, that meet when they grow into the background,
  /// ascending.
  [[nodiscard]] std::vector<std::array<Cell, 2>> met_cells();
  /// Of each supervoxel those that it meets though they do not hang together near by, specks left out.
  [[nodiscard]] parallel::Adjacency facing_cells();
  void choose_parts(const parallel::Adjacency& facing);
  [[nodiscard]] std::vector<NearCell> with_surroundings(std::vector<Cell> core,
                                                        const parallel::Adjacency& facing) const;
  [[nodiscard]] std::vector<NearCell> around(const std::vector<Cell>& start, int max_steps) const;

  const Band& band_;
  std::size_t cell_count_ = 1;  // Supervoxels, and one for none.
  std::vector<Cell> cell_of_;   // By lane: of the object its own one, of the background the nearest.
  std::vector<std::uint32_t> voxels_of_;      // How many each supervoxel has.
  parallel::Adjacency neighbours_;            // Of each supervoxel.
  parallel::Adjacency lanes_;                 // Of each supervoxel.
  std::vector<std::vector<NearCell>> parts_;  // Each ascending by cell.
};

}  // namespace lumesh::field
