// What meshes are measured against (lumesh/stages/evaluation_stage.hpp).
#include "lumesh/stages/evaluation_stage.hpp"

#include <gtest/gtest.h>

#include "lumesh/core/error.hpp"

namespace lumesh {
namespace {

TEST(EvaluationInput, AxesAreNoneWithoutAnImageOrLines) {
  const LabelImage image;
  Polylines axes;
  EXPECT_EQ(evaluation_input(&image, nullptr, nullptr, {}, {}, axes).axes, nullptr);
  axes.lines.push_back({0, 1});
  EXPECT_EQ(evaluation_input(&image, nullptr, nullptr, {}, {}, axes).axes, &axes);
  EXPECT_EQ(evaluation_input(nullptr, nullptr, nullptr, {}, {}, axes).axes, nullptr);
}

TEST(EvaluationInput, ThePhantomIsTheTruthOfAWholeObjectOnlyWhichPlanesLeave) {
  const Phantom phantom{PhantomSpec{}};
  InputCuts cuts;
  cuts.planes.push_back({Vec3::Zero(), Vec3::UnitZ()});
  const auto truth = [&] {
    return evaluation_input(nullptr, nullptr, &phantom, cuts, cuts.planes, {}).phantom;
  };
  EXPECT_EQ(truth(), &phantom);
  cuts.ends = local_length_from("1r");
  EXPECT_EQ(truth(), nullptr);
}

TEST(EvaluationRequest, WhatBelongsToAnImageIsRefusedWithoutOne) {
  EvaluationRequest request;
  request.centerline = "lines.vtp";
  EXPECT_THROW(request.validate(), Error);
  request.image = "image.nrrd";
  EXPECT_NO_THROW(request.validate());
}

}  // namespace
}  // namespace lumesh
