#include "../src/layers/directions.hpp"

#include <gtest/gtest.h>

#include <random>

namespace lumesh::layers {
namespace {

TEST(MostNormalDirection, OfACornerIsItsDiagonal) {
  const std::vector<Vec3> normals = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  EXPECT_LT((max_normal_direction(normals) - Vec3::Ones().normalized()).norm(), 1e-3);
}

TEST(MostNormalDirection, IsNotDrawnByManyTrianglesOnOneSide) {
  std::vector<Vec3> normals(20, Vec3::UnitX());
  normals.push_back(Vec3::UnitY());
  EXPECT_LT((max_normal_direction(normals) - Vec3(1, 1, 0).normalized()).norm(), 1e-3);
}

TEST(MostNormalDirection, IsNoneWhereNothingSeesAll) {
  EXPECT_TRUE(max_normal_direction(std::vector<Vec3>{Vec3::UnitX(), -Vec3::UnitX()}).isZero(0));
  EXPECT_TRUE(max_normal_direction(std::vector<Vec3>{}).isZero(0));
}

TEST(MostNormalDirection, SeesNoLessThanAnyOfManyTriedOnes) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto smallest = [](const std::vector<Vec3>& normals, const Vec3& d) {
    double worst = 1;
    for (const Vec3& n : normals) worst = std::min(worst, n.dot(d));
    return worst;
  };
  for (int round = 0; round < 30; ++round) {
    std::vector<Vec3> normals;
    for (int i = 0; i < 7; ++i)
      normals.push_back(Vec3(normal(random), normal(random), 1.5 + std::abs(normal(random))).normalized());
    const double found = smallest(normals, max_normal_direction(normals));
    for (int i = 0; i < 300; ++i)
      EXPECT_GE(found + 1e-3,
                smallest(normals, Vec3(normal(random), normal(random), normal(random)).normalized()));
  }
}

}  // namespace
}  // namespace lumesh::layers
