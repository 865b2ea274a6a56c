#include "../src/lattice/split_marks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "lumesh/geometry/tetrahedron.hpp"
#include "unit/lattice/lattice_blocks.hpp"

namespace lumesh {
namespace {

struct Leaf {
  bcc::Corners corners;
  int level;

  [[nodiscard]] bcc::Key middle() const { return bcc::midpoint(corners[0], corners[1]); }
};

/// Lattice tetrahedra of random levels in the first cubes of the frame, so that many have common points.
std::vector<Leaf> random_leaves(const LatticeFrame& frame, std::size_t count, std::mt19937& random) {
  const std::vector<bcc::Corners> coarse = test::lattice_block(frame.cells, frame.step(0));
  std::vector<Leaf> leaves;
  while (leaves.size() < count) {
    Leaf leaf{coarse[random() % std::min<std::size_t>(coarse.size(), 300)], 0};
    const int level = static_cast<int>(random() % static_cast<unsigned>(frame.levels));
    for (; leaf.level < level; ++leaf.level) leaf.corners = bcc::red_children(leaf.corners)[random() % 8];
    leaves.push_back(leaf);
  }
  return leaves;
}

struct Box {
  Index3 low, high;

  explicit Box(const std::vector<bcc::Key>& points) : low(bcc::unpack(points[0])), high(low) {
    for (const bcc::Key key : points) {
      low = low.cwiseMin(bcc::unpack(key));
      high = high.cwiseMax(bcc::unpack(key));
    }
  }
  [[nodiscard]] bool touches(const Box& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
};

TEST(SplitMarks, NoLeafNextToASplitOneOfItsLevelOrAFinerOneIsOverlooked) {
  std::mt19937 random(11);
  struct Case {
    Index3 cells;
    int levels;
  };
  // The last has too many cubes for grids of all its levels.
  for (const Case& c : {Case{{5, 4, 6}, 1}, Case{{5, 4, 6}, 3}, Case{{5, 4, 6}, 5}, Case{{100, 3, 100}, 5}}) {
    LatticeFrame frame;
    frame.cells = c.cells;
    frame.levels = c.levels;
    const std::vector<Leaf> leaves = random_leaves(frame, 600, random);
    SplitMarks marks(frame);
    int touching = 0, unmarked = 0;
    for (std::size_t n = 0; n < 40; ++n) {
      const Leaf& split = leaves[n];
      const auto& [first, second] = kTetEdges[random() % 6];
      const bcc::Key edge = bcc::midpoint(split.corners[first], split.corners[second]);
      const bool whole = n % 2 == 0;  // or one of its edges
      marks.note(whole ? split.middle() : edge, split.level);
      marks.renew();
      const Box changed(whole ? std::vector(split.corners.begin(), split.corners.end()) : std::vector{edge});
      for (const Leaf& leaf : leaves) {
        const std::uint32_t cube = marks.cube_of(leaf.middle(), leaf.level);
        const bool marked = marks.is_marked(cube, leaf.level);
        unmarked += marked ? 0 : 1;
        const Box box(std::vector(leaf.corners.begin(), leaf.corners.end()));
        if (leaf.level > split.level || !box.touches(changed)) continue;
        ++touching;
        ASSERT_TRUE(marked) << "levels " << leaf.level << " and " << split.level;
        ASSERT_TRUE(marks.ever_marked(cube, leaf.level, split.level));
      }
    }
    EXPECT_GT(touching, 100);
    EXPECT_GT(unmarked, 1000);  // marks are of use
  }
}

TEST(SplitMarks, RenewingForgetsButNotForever) {
  LatticeFrame frame;
  frame.cells = Index3(4, 4, 4);
  frame.levels = 2;
  SplitMarks marks(frame);
  const Leaf leaf{test::lattice_block(frame.cells, frame.step(0))[20], 0};
  const std::uint32_t cube = marks.cube_of(leaf.middle(), 0);
  marks.note(leaf.middle(), 1);
  EXPECT_FALSE(marks.is_marked(cube, 0));  // not yet
  marks.renew();
  EXPECT_TRUE(marks.is_marked(cube, 0));
  EXPECT_FALSE(marks.ever_marked(cube, 0, 2));  // nothing so fine was split
  marks.renew();
  EXPECT_FALSE(marks.is_marked(cube, 0));
  EXPECT_TRUE(marks.ever_marked(cube, 0, 1));
}

}  // namespace
}  // namespace lumesh
