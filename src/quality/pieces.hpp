#pragma once
// Pieces of labels in the voxels and in the mesh, and which holds centres of which.

#include <cstdint>
#include <vector>

#include "lumesh/image/label_image.hpp"
#include "lumesh/image/runs.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "lumesh/parallel/key_table.hpp"
#include "lumesh/quality/topology_places.hpp"

namespace lumesh::quality {

constexpr std::uint32_t kNoPiece = 0xFFFFFFFFu;

/// The object's voxels with numbers in the order of memory, and their pieces, joined through faces.
class VoxelPieces {
 public:
  explicit VoxelPieces(const LabelImage& image);

  [[nodiscard]] std::size_t voxel_count() const { return numbers_.back(); }
  [[nodiscard]] const image::RunImage& runs() const { return runs_; }
  [[nodiscard]] std::size_t first_number(std::size_t run) const { return numbers_[run]; }
  /// The piece of a run: the number of the first run of that piece.
  [[nodiscard]] std::uint32_t piece_of_run(std::size_t run) const { return pieces_[run]; }
  [[nodiscard]] std::size_t run_of(std::size_t number) const;
  [[nodiscard]] Index3 place_of(std::size_t number) const;
  /// Number of the voxel there; voxel_count() if it is none of the object, or outside the image.
  [[nodiscard]] std::size_t number_at(const Index3& voxel) const;

 private:
  image::RunImage runs_;
  std::vector<std::size_t> numbers_;   // Per run, plus one at the end.
  std::vector<std::uint32_t> pieces_;  // Per run.
};

/// Cells joined through faces within their label. Cells of labels that are not asked for have kNoPiece.
struct CellPieces {
  std::vector<std::uint32_t> piece;  ///< Per cell: the first cell of its piece.
  parallel::Adjacency neighbours;    ///< Cells of one piece that share a face.
};
[[nodiscard]] CellPieces find_cell_pieces(const MeshView& mesh,
                                          std::span<const TopologyDifference> differences);

/// Extra and missing pieces, joins and splits of the labels that differ in their number of components.
[[nodiscard]] std::vector<TopologyPlace> find_piece_places(const MeshView& mesh, const LabelImage& image,
                                                           std::span<const TopologyDifference> differences);

/// Handles and cavities of one label.
[[nodiscard]] std::vector<TopologyPlace> find_warping_places(const MeshView& mesh, const LabelImage& image,
                                                             const TopologyDifference& difference);

}  // namespace lumesh::quality
