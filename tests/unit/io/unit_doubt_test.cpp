// Which sizes draw a doubt: of models of vessels in other units, and of those in mm that are like them.
#include "lumesh/io/unit_doubt.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace lumesh {
namespace {

TEST(UnitDoubt, IsOfLengthsThatNoVesselHasInMillimetres) {
  EXPECT_NE(unit_doubt({0.3}).find("`unit` m says so"), std::string::npos);
  EXPECT_NE(unit_doubt({250000}).find("`unit` um says so"), std::string::npos);
  EXPECT_NE(unit_doubt({34.5, 1.0}).find("`unit` cm says so"), std::string::npos);  // An aorta.
  EXPECT_NE(unit_doubt({15, 0.3}).find("`unit` cm says so"), std::string::npos);    // A carotid artery.
  EXPECT_NE(unit_doubt({3.4, 0.1}).find("`unit` cm says so"), std::string::npos);
  EXPECT_NE(unit_doubt({3.5, 0.25}).find("`unit` cm says so"), std::string::npos);
}

TEST(UnitDoubt, AsksForAnotherUnitThanTheOneThatAFileStates) {
  const std::string micrometres = unit_doubt({.longest_mm = 0.04, .stated_unit = "um"});
  EXPECT_NE(micrometres.find("states, um; is it in mm? `unit` mm says so, `unit` um"), std::string::npos)
      << micrometres;
  const std::string metres = unit_doubt({.longest_mm = 40000, .stated_unit = "m"});
  EXPECT_NE(metres.find("states, m; is it in mm?"), std::string::npos) << metres;
  const std::string millimetres = unit_doubt({.longest_mm = 0.04, .stated_unit = "mm"});
  EXPECT_NE(millimetres.find("states, mm; is it in m?"), std::string::npos) << millimetres;
  const std::string none = unit_doubt({.longest_mm = 1e-6, .stated_unit = "mm"});
  EXPECT_NE(none.find("`unit` mm that this is right"), std::string::npos) << none;
  EXPECT_EQ(unit_doubt({.longest_mm = 40, .stated_unit = "um"}), "");
}

TEST(UnitDoubt, IsOfShortModelsWithNumberedFaces) {
  const std::vector<Patch> numbered = {{"face_1"}}, named = {{"wall"}};
  EXPECT_TRUE(has_numbered_faces(numbered));
  EXPECT_FALSE(has_numbered_faces(named));
  EXPECT_NE(unit_doubt({5, 1.5, true}).find("SimVascular"), std::string::npos);  // Its two cylinders.
  EXPECT_EQ(unit_doubt({152, 6.4, true}), "");                                   // Its bifurcation.
}

TEST(UnitDoubt, IsNotOfCerebralAndCoronaryArteriesInMillimetres) {
  EXPECT_EQ(unit_doubt({49.6, 1.72}), "");  // fenics-aneurysm.
  EXPECT_EQ(unit_doubt({12.1, 0.94}), "");  // A short piece of a small one.
  EXPECT_EQ(unit_doubt({4.8, 1.63}), "");   // VaMPy's artery.
  EXPECT_EQ(unit_doubt({20, 1.0}), "");
  EXPECT_EQ(unit_doubt({30, 0.75}), "");
  EXPECT_EQ(unit_doubt({120, 1.6}), "");
  EXPECT_EQ(unit_doubt({400, 12}), "");
}

}  // namespace
}  // namespace lumesh
