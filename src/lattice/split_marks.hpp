#pragma once
// Marks where lattice edges were split, so that only leaves near by must be looked at again.

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "bcc.hpp"
#include "lumesh/core/grid.hpp"
#include "refinement.hpp"

namespace lumesh {

/// Marks on cubes as large as the spacing of each level; of the finer levels, on those of the last level that
/// has not too many cubes. A leaf stays within half a spacing of the middle of its first edge along each
/// axis, so that leaves with a common point lie in the same cube of the coarser one's level or in adjacent
/// ones.
class SplitMarks {
 public:
  explicit SplitMarks(const LatticeFrame& frame) : frame_(frame) {
    constexpr std::size_t kMaxCubes = std::size_t{1} << 23;
    while (static_cast<int>(grids_.size()) < frame.levels &&
           (grids_.empty() || 8 * grids_.back().marks.size() <= kMaxCubes))
      grids_.push_back(Grid(frame.cells * (1 << grids_.size())));
  }

  /// The cube, for its level, of a leaf or of another place, by its midpoint.
  [[nodiscard]] std::uint32_t cube_of(bcc::Key middle, int level) const {
    const std::size_t g = grid_of(level);
    return grids_[g].number(cube_at(middle, g));
  }
  /// Whether an edge of this level or a finer one was split in a cube or next to it before the last renewal,
  /// but not before the one before it.
  [[nodiscard]] bool is_marked(std::uint32_t cube, int level) const {
    return Grid::near(grids_[grid_of(level)].marks[cube]) > level;
  }
  /// The same for all edges noted before the last renewal.
  [[nodiscard]] bool ever_marked(std::uint32_t cube, int cubes_level, int level) const {
    return Grid::ever(grids_[grid_of(cubes_level)].marks[cube]) > level;
  }

  /// An edge of a leaf was split; it concerns leaves of the same level and of coarser ones.
  /// @param middle  Midpoint of the leaf or of the edge.
  void note(bcc::Key middle, int level) { noted_.push_back({middle, level}); }

  /// Replaces the marks by those of the edges noted since the last time.
  void renew() {
    for (Grid& grid : grids_) grid.clear();
    for (const auto& [middle, level] : noted_) {
      for (std::size_t g = 0; g <= grid_of(level); ++g) grids_[g].mark_around(cube_at(middle, g), level);
    }
    noted_.clear();
  }

 private:
  /// A mark has four bits each for one more than the finest level split near the cube since the last time, in
  /// the cube itself since then, and ever near it.
  struct Grid {
    Index3 size;
    std::vector<std::uint16_t> marks;
    std::vector<std::uint32_t> marked;

    static int near(std::uint16_t mark) { return mark & 15; }
    static int here(std::uint16_t mark) { return mark >> 4 & 15; }
    static int ever(std::uint16_t mark) { return mark >> 8; }
    static std::uint16_t mark_of(int near, int here, int ever) {
      return static_cast<std::uint16_t>(near | here << 4 | ever << 8);
    }

    explicit Grid(const Index3& cubes) : size(cubes), marks(grid_count(cubes)) {}

    [[nodiscard]] std::uint32_t number(const Index3& c) const {
      return static_cast<std::uint32_t>(grid_offset(size, c));
    }
    void clear() {
      for (const std::uint32_t c : marked) marks[c] = mark_of(0, 0, ever(marks[c]));
      marked.clear();
    }
    void mark_around(const Index3& cube, int level) {
      std::uint16_t& own = marks[number(cube)];
      if (here(own) > level) return;
      const Index3 low = (cube - Index3::Ones()).cwiseMax(0);
      const Index3 high = (cube + Index3::Ones()).cwiseMin(size - Index3::Ones());
      for_each_place(low, high, [&](const Index3& c) {
        std::uint16_t& m = marks[number(c)];
        if (near(m) == 0) marked.push_back(number(c));
        m = mark_of(std::max(near(m), level + 1), here(m), std::max(ever(m), level + 1));
      });
      own = mark_of(near(own), level + 1, ever(own));
    }
  };

  [[nodiscard]] std::size_t grid_of(int level) const {
    return std::min(static_cast<std::size_t>(level), grids_.size() - 1);
  }
  /// A cube's edge is a power of two.
  [[nodiscard]] Index3 cube_at(bcc::Key middle, std::size_t grid) const {
    const int shift = frame_.levels + 2 - static_cast<int>(grid);
    const Index3 at = bcc::unpack(middle);
    return Index3(at.x() >> shift, at.y() >> shift, at.z() >> shift)
        .cwiseMin(grids_[grid].size - Index3::Ones());
  }

  const LatticeFrame& frame_;
  std::vector<Grid> grids_;  // one per level, from the coarsest
  std::vector<std::pair<bcc::Key, int>> noted_;
};

}  // namespace lumesh
