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

TEST(PatchRenaming, KindsAreReadBehindNames) {
  const auto kind = [](const char* text) { return renaming_from(text).kind.value(); };
  EXPECT_FALSE(renaming_from("outlet_2=left_ica").kind);
  EXPECT_EQ(renaming_from("outlet_2=left_ica:inlet").name, "left_ica");
  EXPECT_EQ(kind("outlet_2=left_ica:inlet").kind, PatchKind::kOpening);
  EXPECT_EQ(kind("outlet_2=left_ica:inlet").flow, FlowSide::kInlet);
  EXPECT_EQ(kind("1,2,3=left_ica:outlet").flow, FlowSide::kOutlet);
  EXPECT_EQ(kind("outlet_2=stump:wall").kind, PatchKind::kWall);
  EXPECT_EQ(kind("wall=middle:symmetry").kind, PatchKind::kSymmetry);
  for (const char* word : {"inlet", "outlet", "wall", "symmetry"})
    EXPECT_EQ(kind((std::string("a=b:") + word).c_str()).word(), word);
  for (const char* wrong : {"a=b:", "a=b:door", "a=:wall", "a=b:Inlet", "a=outlet_1:wall", "a=Inlet:outlet",
                            "a=outlet:inlet", "a=symmetry_1:wall", "a=inlet_1:symmetry"})
    EXPECT_THROW((void)renaming_from(wrong), Error) << wrong;
  EXPECT_NO_THROW((void)renaming_from("outlet_1=outlet_1:outlet"));
}

const std::vector<NamedOpening> kTwo = {{"inlet_1", {0, 0, 0}, 3}, {"outlet_1", {10, 0, 0}, 1}};

TEST(PatchRenaming, PlacesMeanTheNearestOpening) {
  const auto found = with_patches({renaming_from("9,1,0=left"), renaming_from("0,4,0=aorta")}, kTwo);
  EXPECT_EQ(found[0].patch, "outlet_1");
  EXPECT_EQ(found[1].patch, "inlet_1");
}

TEST(PatchRenaming, PlacesWhereExtensionsBeginMeanTheirOpenings) {
  const std::vector<NamedOpening> beginnings = {{"inlet_1", {30, 0, 0}, 3}, {"outlet_1", {10, 0, 5}, 1}};
  EXPECT_EQ(with_patches({renaming_from("31,0,0=aorta")}, kTwo, beginnings)[0].patch, "inlet_1");
  EXPECT_EQ(with_patches({renaming_from("0,1,0=aorta")}, kTwo, beginnings)[0].patch, "inlet_1");
  EXPECT_EQ(with_patches({renaming_from("10,0,4=left")}, kTwo, beginnings)[0].patch, "outlet_1");
  EXPECT_THROW((void)with_patches({renaming_from("40,0,0=x")}, kTwo, beginnings), Error);
}

TEST(PatchRenaming, AnAreaMeansTheOnlyOpeningOfAboutThatArea) {
  EXPECT_EQ(*renaming_from("28.3mm2=aorta").area_mm2, 28.3);
  EXPECT_EQ(with_patches({renaming_from("27mm2=aorta:inlet")}, kTwo)[0].patch, "inlet_1");  // 9 pi
  EXPECT_EQ(with_patches({renaming_from("3.2mm2=left")}, kTwo)[0].patch, "outlet_1");       // pi
  EXPECT_EQ(renaming_from("28.3=x").patch, "28.3") << "an area has a unit";
  const std::vector<NamedOpening> alike = {{"inlet_1", {0, 0, 0}, 3}, {"outlet_1", {9, 0, 0}, 2.95}};
  EXPECT_THROW((void)with_patches({renaming_from("28mm2=x")}, alike), Error) << "either";
  EXPECT_THROW((void)with_patches({renaming_from("10mm2=x")}, kTwo), Error) << "none";
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

TEST(PatchRenaming, KindsThatUsersGiveAreThoseOfThePatches) {
  MeshInfo info;
  info.patches = {{"wall", PatchKind::kWall, {1, 0}},
                  {"outlet_1", PatchKind::kOpening, {1, 0}},
                  {"outlet_1_layer", PatchKind::kOpening, {2, 0}},
                  {"outlet_2", PatchKind::kOpening, {1, 0}},
                  {"interface_1_2", PatchKind::kInterface, {1, 2}}};
  const std::vector<std::string> texts = {"wall=middle:symmetry", "outlet_1=left_ica:inlet",
                                          "outlet_2=stump:wall"};
  EXPECT_TRUE(rename_found(info, renamings_from(texts)).empty());
  EXPECT_EQ(info.patches[0].kind, PatchKind::kSymmetry);
  EXPECT_EQ(info.patches[1].kind, PatchKind::kOpening);
  EXPECT_EQ(info.patches[1].flow, FlowSide::kInlet);
  EXPECT_EQ(info.patches[2].name, "left_ica_layer");
  EXPECT_EQ(info.patches[2].flow, FlowSide::kInlet) << "the ring of layers is part of the opening";
  EXPECT_EQ(info.patches[3].kind, PatchKind::kWall);
  rename_patches(info, std::vector{renaming_from("left_ica=outlet_9"), renaming_from("stump=symmetry")});
  EXPECT_EQ(info.patches[1].flow, FlowSide::kUnknown) << "the new name says so";
  EXPECT_EQ(info.patches[3].kind, PatchKind::kSymmetry) << "the name says so";
  EXPECT_THROW(rename_patches(info, std::vector{renaming_from("interface_1_2=a:wall")}), Error);
  EXPECT_EQ(rename_found(info, std::vector{renaming_from("interface_1_2=a:wall")}).size(), 1u);
  EXPECT_EQ(info.patches[4].name, "interface_1_2") << "nothing changed";
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
