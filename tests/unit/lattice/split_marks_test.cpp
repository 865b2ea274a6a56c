#include "../src/lattice/split_marks.hpp"

#include <gtest/gtest.h>

#include <random>

#include "unit/lattice/lattice_blocks.hpp"

namespace lumesh {
namespace {

struct Leaf {
  bcc::Corners corners;
  int level;

  [[nodiscard]] bcc::Key middle() const { return bcc::midpoint(corners[0], corners[1]); }
};

/// Lattice tetrahedra of random levels somewhere in the frame.
std::vector<Leaf> random_leaves(const LatticeFrame& frame, std::size_t count, std::mt19937& random) {
  const std::vector<bcc::Corners> coarse = test::lattice_block(frame.cells, frame.step(0));
  std::vector<Leaf> leaves;
  while (leaves.size() < count) {
    Leaf leaf{coarse[random() % coarse.size()], 0};
    const int level = static_cast<int>(random() % static_cast<unsigned>(frame.levels));
    for (; leaf.level < level; ++leaf.level) leaf.corners = bcc::red_children(leaf.corners)[random() % 8];
    leaves.push_back(leaf);
  }
  return leaves;
}

bool boxes_touch(const Leaf& a, const Leaf& b) {
  const auto box = [](const Leaf& leaf) {
    Index3 low = bcc::unpack(leaf.corners[0]), high = low;
    for (const bcc::Key key : leaf.corners) {
      low = low.cwiseMin(bcc::unpack(key));
      high = high.cwiseMax(bcc::unpack(key));
    }
    return std::pair{low, high};
  };
  const auto [low_a, high_a] = box(a);
  const auto [low_b, high_b] = box(b);
  return (low_a.array() <= high_b.array()).all() && (low_b.array() <= high_a.array()).all();
}

TEST(SplitMarks, NoLeafNextToASplitOneOfItsLevelOrAFinerOneIsOverlooked) {
  std::mt19937 random(11);
  for (const int levels : {1, 3, 5}) {
    LatticeFrame frame;
    frame.cells = Index3(5, 4, 6);
    frame.levels = levels;
    const std::vector<Leaf> leaves = random_leaves(frame, 600, random);
    SplitMarks marks(frame);
    int touching = 0, unmarked = 0;
    for (std::size_t n = 0; n < 20; ++n) {
      const Leaf& split = leaves[n];
      marks.note(split.middle(), split.level);
      marks.renew();
      for (const Leaf& leaf : leaves) {
        const std::uint32_t cube = marks.cube_of(leaf.middle(), leaf.level);
        const bool marked = marks.is_marked(cube, leaf.level);
        unmarked += marked ? 0 : 1;
        if (leaf.level > split.level || !boxes_touch(leaf, split)) continue;
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
