#pragma once
// Cubic B-splines on ever coarser grids over the band: a preconditioner (Bramble, Pasciak, Xu 1990,
// doi:10.1090/S0025-5718-1990-1023042-6), and averages over windows.

#include <array>
#include <vector>

#include "band.hpp"
#include "lanes.hpp"
#include "segment_grid.hpp"

namespace lumesh::field {

/// Between a grid and one of twice its spacing: node I of the coarse grid lies at node 2I - 2 of the fine
/// one.
class Transfer {
 public:
  /// The coarse grid has all nodes whose B-spline reaches a segment of the fine one.
  explicit Transfer(const SegmentGrid& fine);

  [[nodiscard]] const SegmentGrid& coarse() const { return coarse_; }
  /// coarse = transpose of the refinement of B-splines, times fine.
  void restrict_to_coarse(const LaneArray& fine, LaneArray& coarse);
  /// Values of the coarse grid's splines at the fine segments, through load_fine().
  void prolong(const LaneArray& coarse);
  /// The values that prolong() gave, in the lanes of a fine segment.
  [[gnu::always_inline]] inline Lanes load_fine(int segment) const;

 private:
  friend struct TransferLoops;
  void find_sources(const SegmentGrid& fine);
  void find_nodes();

  SegmentGrid along_x_;  // coarse along x, fine along y and z
  SegmentGrid coarse_;
  LaneArray half_way_;                                // of along_x_
  std::vector<std::array<std::int32_t, 3>> source_;   // by segment of along_x_: those of the fine grid
  std::vector<std::array<std::int32_t, 25>> gather_;  // by coarse segment: those of along_x_, y fastest
  std::vector<std::array<std::int32_t, 9>> spread_;   // by segment of along_x_: the coarse ones, y fastest
  std::vector<std::uint8_t> parity_;                  // of along_x_: bit 0 y odd, bit 1 z odd
  std::vector<std::int32_t> offset_;                  // by fine segment: into half_way_, in floats
};

/// Coarse levels of a preconditioner: on level l the energy of a B-spline stands for the diagonal. The band's
/// own grid is level 0, which the solver itself treats.
class Multilevel {
 public:
  static constexpr int kLevels = 5;

  explicit Multilevel(const Band& band) : Multilevel(band.grid(), band.alive(), kLevels) {}
  /// Refers to the lanes that are alive.
  Multilevel(const SegmentGrid& grid, const std::vector<std::uint8_t>& alive, int levels);

  /// Takes the diagonals of the levels from that of the differences and the weights of single voxels
  /// (`mass`), both 0 outside the band.
  /// @param whole  What `diagonal` is where the stiffness is 1 and the band all around.
  /// @param third, second  Weights of third and second derivatives.
  /// @param edges  Of a voxel.
  void set_energy(const LaneArray& diagonal, float whole, const LaneArray& mass, double third, double second,
                  const Vec3& edges);
  /// Starts z = M r: afterwards finest().load_fine() gives the coarse levels' part. Returns r . z of that
  /// part.
  double precondition(const LaneArray& residual);
  [[nodiscard]] const Transfer& finest() const { return levels_.front().transfer; }

  /// Sums over a window of about Gaussian shape, normalised alike everywhere: values are 0 outside the band.
  /// kNarrow has a standard deviation of 2 voxels, kWide of 3.2, kFar of 6.5.
  enum class Window : std::uint8_t { kNarrow, kWide, kFar };
  void sum_over_window(const LaneArray& values, Window window, LaneArray& sums);

 private:
  struct Level {
    explicit Level(const SegmentGrid& fine);
    void find_beside();
    Transfer transfer;
    LaneArray residual, correction, inverse;
    /// By segment: those beside it, before and after along x, y and z. Windows alone do without.
    std::vector<std::array<std::int32_t, 6>> beside;
  };
  void smooth(const LaneArray& values, int levels, LaneArray& out);

  const std::vector<std::uint8_t>& alive_;
  std::vector<Level> levels_;
};

Lanes Transfer::load_fine(int segment) const {
  using Four = float __attribute__((vector_size(16)));
  constexpr std::int32_t kShift = 4;
  const float* const from = half_way_.data() + offset_[static_cast<std::size_t>(segment)];
  const auto four = [](const float* p) __attribute__((always_inline)) {
    Four v;
    std::memcpy(&v, p, sizeof v);
    return v;
  };
  const Four before = four(from), own = four(from + 1), after = four(from + 2);
  const Four even = 0.75F * own + 0.125F * (before + after), odd = 0.5F * (own + after);
  return __builtin_shufflevector(even, odd, 0, kShift, 1, kShift + 1, 2, kShift + 2, 3, kShift + 3);
}

}  // namespace lumesh::field
