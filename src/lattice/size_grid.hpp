#pragma once
// How fine the lattice must be, place by place: from the local thickness of the labels at their boundaries.

#include <optional>
#include <vector>

#include "lumesh/core/grid.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/domain/opening_sizes.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/lattice/lattice.hpp"

namespace lumesh {

/// Lowest refinement level wanted near each boundary, on a grid of 2^3 voxels. The thickness of a label at a
/// boundary voxel is the chord through the label along the field's normal; the background's counts
/// as well, so that two vessels side by side are kept apart.
class SizeGrid {
 public:
  /// @param coarsest_mm  Spacing of level 0. @param at_openings  Of the domain.
  /// @throws Error{kMemory} if the mesh would not fit into the free memory.
  SizeGrid(const LabelImage& image, const ImageDomain& domain, const LatticeOptions& options,
           double coarsest_mm, std::size_t object_voxels, const OpeningSizes& at_openings);

  /// The spacing at boundaries where the object is thick. With LatticeOptions::cells_per_diameter it is at
  /// most half finer than asked for, such that halving it meets the number over most of the boundary.
  [[nodiscard]] static double boundary_spacing_mm(const LabelImage& image, const ImageDomain& domain,
                                                  const LatticeOptions& options);

  /// Levels given up to stay within LatticeOptions::max_tetrahedra.
  [[nodiscard]] int levels_given_up() const { return max_level_ - cap_; }

  /// Largest level wanted by a boundary within `radius_mm` of the point; -1 where there is no boundary.
  [[nodiscard]] int level_wanted(const Vec3& point_mm, double radius_mm) const;

  /// Whether some boundary may lie within `radius_mm` of the point.
  [[nodiscard]] bool boundary_within(const Vec3& point_mm, double radius_mm) const;

 private:
  SizeGrid(const LabelImage& image, const ImageDomain& domain, const LatticeOptions& options,
           double coarsest_mm);

  [[nodiscard]] IndexBox cells_around(const Vec3& point_mm, double radius_mm) const;
  [[nodiscard]] IndexBox cells_between(const Vec3& low, const Vec3& high) const;  ///< In voxels.
  [[nodiscard]] std::size_t cell_number(const Index3& cell) const { return grid_offset(cells_, cell); }
  /// Whether is_found(cell) is true for one of the wanted cells of a box.
  template <class IsFound>
  bool any_cell(const IndexBox& box, const IsFound& is_found) const;
  static constexpr int kCell = 2;
  static constexpr std::uint8_t kFirm =
      0x80;  // flag: wanted by a label with a fidelity of its own or at an opening, never given up

  [[nodiscard]] int voxel_level(const Index3& voxel) const;
  /// Largest spacing that a voxel allows; none where it is at no boundary.
  [[nodiscard]] std::optional<double> allowed_mm(const Index3& voxel) const;
  /// Unit direction (mm, along the image's axes) into the label; none where the field has no slope.
  [[nodiscard]] std::optional<Vec3> inwards_at(const Index3& voxel, LabelImage::Index label) const;
  /// The plane that ends what lies along a direction, which is nearly its normal; null if there is none.
  [[nodiscard]] const CutPlane* faced_cut(const Vec3& direction) const;
  /// Through the label, from a voxel at its boundary; unlimited through a plane that is not faced: there a
  /// vessel goes on.
  [[nodiscard]] double chord_mm(const Index3& voxel, const Vec3& inwards, LabelImage::Index label,
                                double limit_mm) const;
  /// How far the label goes on from a place along a unit direction; `limit_mm` too where it leaves the image.
  [[nodiscard]] double ray_mm(const Vec3& start_mm, const Vec3& direction, LabelImage::Index label,
                              double limit_mm) const;
  /// Edge of which kEdgesAround go around the label's section, of which the chord is the width.
  [[nodiscard]] double edge_around_section_mm(const Index3& voxel, const Vec3& inwards, double chord_mm,
                                              LabelImage::Index label, double limit_mm) const;
  /// Stands in for the chord where the field has no slope, as in the middle of plates and lines of one voxel.
  [[nodiscard]] double shortest_run_mm(const Index3& voxel, LabelImage::Index label, double limit_mm) const;
  /// Notes what a voxel at a boundary wants. Cells never reach across bricks.
  void note_voxel(const Index3& voxel);
  void note_opening(const Opening& opening);
  void note_size(const OpeningSize& size);
  /// Notes a level in a cell that is at a boundary. @param firm  kFirm or 0.
  void note_level(const Index3& cell, int level, std::uint8_t firm);
  [[nodiscard]] int level_for(double edge_mm) const;
  void coarsen_to(std::size_t max_tetrahedra, std::size_t object_voxels);
  [[nodiscard]] double predict(int cap, double object_mm3) const;

  const LabelImage& image_;
  const ImageDomain& domain_;
  double coarsest_mm_;
  int min_level_;
  int max_level_;
  int cap_;
  bool has_cells_;                        // LatticeOptions::cells_per_diameter says the spacings
  std::vector<std::uint8_t> firm_;        // per label: kFirm or 0
  std::vector<double> thickness_factor_;  // per label: spacing allowed per unit of chord
  Index3 cells_;
  std::vector<std::uint8_t> wanted_;  // 1 + level and kFirm; 0 = no boundary
};

}  // namespace lumesh
