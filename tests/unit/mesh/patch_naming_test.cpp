// Names of patches of labels that have names.
#include "lumesh/mesh/patch_naming.hpp"

#include <gtest/gtest.h>

namespace lumesh {
namespace {

TEST(PatchNaming, TellsSegmentsApartWhoseNamesAreEqualWhenCleaned) {
  const PatchNaming naming({{1, "a/b"}, {2, "a_b"}});
  EXPECT_EQ(naming.wall(1, false), "wall_a_b");
  EXPECT_EQ(naming.wall(2, false), "wall_a_b_2");
  EXPECT_EQ(naming.label(2), "a_b_2");
}

TEST(PatchNaming, TheWallOfASegmentIsNoRim) {
  const PatchNaming naming({{4, "rim_1"}});
  EXPECT_EQ(naming.wall(4, false), "wall_4");
  EXPECT_EQ(naming.label(4), "label_4");
}

TEST(PatchNaming, InterfacesThatCouldBeOfOtherSegmentsHaveNumbers) {
  const PatchNaming naming({{1, "a"}, {2, "b_c"}, {3, "a_b"}, {4, "c"}, {5, "left ICA"}, {6, "left MCA"}});
  EXPECT_EQ(naming.between(1, 2), "interface_1_2");
  EXPECT_EQ(naming.between(4, 3), "interface_3_4");
  EXPECT_EQ(naming.between(5, 6), "interface_left_ICA_left_MCA");
  EXPECT_EQ(naming.between(1, 4), "interface_a_c");
  EXPECT_EQ(naming.between(8, 7), "interface_7_8");
}

}  // namespace
}  // namespace lumesh
