#include "lumesh/mesh/patch_renaming.hpp"

#include <gtest/gtest.h>

#include "lumesh/core/error.hpp"
#include "lumesh/mesh/patch_words.hpp"

namespace lumesh {
namespace {

TEST(PatchRenaming, IsReadFromTexts) {
  const PatchRenaming by_name = renaming_from("outlet_2=left_ica");
  EXPECT_EQ(by_name.patch, "outlet_2");
  EXPECT_EQ(by_name.name, "left_ica");
  EXPECT_FALSE(by_name.near_mm);
  const PatchRenaming by_place = renaming_from("12.5,-40,3e1=R.ICA-1");
  ASSERT_TRUE(by_place.near_mm);
  EXPECT_EQ(*by_place.near_mm, Vec3(12.5, -40, 30));
  EXPECT_EQ(by_place.name, "R.ICA-1");
  for (const char* wrong : {"", "=", "a", "a=", "=b", "outlet_1=a b", "outlet_1=1st", "outlet_1=a/b",
                            "1,2,3=é", "1,2=x", "1,2,nan=x", "1;2;3=x"})
    EXPECT_THROW((void)renaming_from(wrong), Error) << wrong;
  EXPECT_EQ(*renaming_from("1, 2, 3=x").near_mm, Vec3(1, 2, 3));
}

const std::vector<NamedOpening> kTwo = {{"inlet_1", {0, 0, 0}, 3}, {"outlet_1", {10, 0, 0}, 1}};

TEST(PatchRenaming, PlacesMeanTheNearestOpening) {
  const auto found = with_patches({renaming_from("9,1,0=left"), renaming_from("0,4,0=aorta")}, kTwo);
  EXPECT_EQ(found[0].patch, "outlet_1");
  EXPECT_EQ(found[1].patch, "inlet_1");
}

TEST(PatchRenaming, APlaceMeansTheOpeningNotTheRimOfTheWallAroundIt) {
  const std::vector<NamedOpening> openings = {{"wall_rim_1", {0, 0, 0}, 4, true}, {"inlet_1", {0, 0, 0}, 3}};
  EXPECT_EQ(with_patches({renaming_from("0,1,0=aorta")}, openings)[0].patch, "inlet_1");
  EXPECT_EQ(with_patches({renaming_from("wall_rim_1=cut")}, openings)[0].patch, "wall_rim_1");
}

TEST(PatchWords, AreEachOnceAndBeginAsWordsDo) {
  PatchWords words;
  for (const auto& [name, word] :
       {std::pair("a/b", "a_b"), std::pair("a b", "a_b_2"), std::pair("a_b_2", "a_b_2_2"),
        std::pair("1st", "_1st"), std::pair(".hidden", "hidden"), std::pair("動脈", "patch_3"),
        std::pair("", "patch_3_2")})
    EXPECT_EQ(words.add(name, "patch_3"), word);
}

TEST(PatchWords, OfLabelsDependOnTheirNamesAlone) {
  const std::map<Label, std::string> names = {{1, "a/b"}, {2, "a_b_2"},   {3, "a_b"}, {4, "rim_1"},
                                              {5, "7"},   {6, "label_9"}, {9, "?"},   {10, "Gefäß"}};
  const std::map<Label, std::string> words = {{1, "a_b"}, {2, "a_b_2"}, {3, "a_b_3"}, {10, "Gef"}};
  EXPECT_EQ(label_words(names), words);
}

TEST(PatchWord, HasOnlyWhatSolversTake) {
  EXPECT_EQ(patch_word("left ICA (C7)"), "left_ICA_C7");
  EXPECT_EQ(patch_word("Ärtery/2"), "rtery_2");
  EXPECT_EQ(patch_word("R-MCA.M1"), "R-MCA.M1");
  EXPECT_EQ(patch_word(" ?"), "");
  EXPECT_EQ(patch_word("Gefäß äußere Wand"), "Gef_u_ere_Wand");
  for (const char* taken : {"a__b", "_1st", "wall-2.1_"}) EXPECT_EQ(patch_word(taken), taken);
}

TEST(PatchRenaming, WhatNoOpeningIsMeantByIsRefusedWithTheOpeningsThatThereAre) {
  for (const char* wrong : {"13,0,0=far", "outlet_2=none", "Outlet1=none"}) {
    try {
      (void)with_patches({renaming_from(wrong)}, kTwo);
      ADD_FAILURE() << wrong;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
      EXPECT_NE(std::string(error.what()).find("outlet_1 at (10.0, 0.0, 0.0)"), std::string::npos)
          << error.what();
    }
  }
  EXPECT_THROW((void)with_patches({renaming_from("outlet_1=a"), renaming_from("10,0,0=b")}, kTwo), Error)
      << "one opening, two names";
  EXPECT_NO_THROW((void)with_patches({renaming_from("wall=vessel")}, kTwo)) << "walls are not known yet";
  EXPECT_THROW((void)with_patches({renaming_from("0,0,0=a")}, {}), Error);
}

TEST(PatchRenaming, AllAtOnceOrNothing) {
  MeshInfo info;
  info.patches = {{"wall", PatchKind::kWall, {1, 0}},
                  {"inlet_1", PatchKind::kOpening, {1, 0}},
                  {"outlet_1", PatchKind::kOpening, {1, 0}}};
  const auto names = [&] { return info.patches[1].name + " " + info.patches[2].name; };
  rename_patches(info, std::vector{renaming_from("inlet_1=outlet_1"), renaming_from("outlet_1=inlet_1")});
  EXPECT_EQ(names(), "outlet_1 inlet_1") << "swapped";
  EXPECT_EQ(info.patches[1].kind, PatchKind::kOpening);
  EXPECT_THROW(rename_patches(info, std::vector{renaming_from("inlet_1=a"), renaming_from("outlet_7=b")}),
               Error);
  EXPECT_THROW(rename_patches(info, std::vector{renaming_from("inlet_1=wall")}), Error) << "taken";
  EXPECT_EQ(names(), "outlet_1 inlet_1") << "nothing changed";
}

TEST(PatchRenaming, WallsWithNamesOfOpeningsAreOpenings) {
  MeshInfo info;
  info.patches = {{"patch_1", PatchKind::kWall, {1, 0}},
                  {"patch_2", PatchKind::kWall, {1, 0}},
                  {"inlet_wall", PatchKind::kWall, {1, 0}}};
  rename_patches(info, std::vector{renaming_from("patch_1=inlet"), renaming_from("patch_2=vessel")});
  EXPECT_EQ(info.patches[0].kind, PatchKind::kOpening);
  EXPECT_EQ(info.patches[1].kind, PatchKind::kWall);
  EXPECT_EQ(info.patches[2].kind, PatchKind::kWall) << "what is not renamed stays";
}

TEST(PatchRenaming, OpeningsOfAMeshHaveTheirCentresAndRadii) {
  MixedMesh mesh;
  mesh.points = {{0, 0, 5}, {2, 0, 5}, {2, 2, 5}, {0, 2, 5}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.triangle_patches = {1, 1};
  mesh.info.patches = {{"wall", PatchKind::kWall, {1, 0}}, {"outlet_1", PatchKind::kOpening, {1, 0}}};
  const std::vector<NamedOpening> openings = named_openings(mesh.view());
  ASSERT_EQ(openings.size(), 1u);
  EXPECT_EQ(openings[0].name, "outlet_1");
  EXPECT_LT((openings[0].centre_mm - Vec3(1, 1, 5)).norm(), 1e-12);
  EXPECT_NEAR(M_PI * openings[0].radius_mm * openings[0].radius_mm, 4, 1e-12);
}

}  // namespace
}  // namespace lumesh
