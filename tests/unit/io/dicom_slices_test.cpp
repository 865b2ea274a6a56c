#include "../src/io/dicom_slices.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "io_fixtures.hpp"

namespace lumesh::io {
namespace {

/// Slices 2 mm apart along an oblique normal, in any order.
std::vector<DicomSlice> series() {
  const Vec3 row = Vec3(1, 0.2, 0).normalized(), normal = Vec3(-0.2, 1, 0.5).normalized(),
             column = normal.cross(row);
  std::vector<DicomSlice> slices;
  for (const int k : {3, 0, 1, 5, 2, 4})
    slices.push_back({"s" + std::to_string(k), Vec3(10, -4, 7) + 2 * k * row.cross(column).normalized(), row,
                      column.normalized(), Vec3(0.5, 0.5, 0)});
  return slices;
}

std::string fault_of(std::vector<DicomSlice> slices) {
  return fixtures::error_of([&] { check_slices("series", std::move(slices)); });
}

TEST(DicomSlices, ARegularGridIsTaken) {
  EXPECT_NO_THROW(check_slices("series", series()));
  std::vector<DicomSlice> rounded = series();
  for (DicomSlice& slice : rounded) slice.position_mm = (slice.position_mm * 100).array().round() / 100;
  EXPECT_NO_THROW(check_slices("series", rounded));
  EXPECT_NO_THROW(check_slices("series", {}));
}

TEST(DicomSlices, WhatMakesNoGridIsRefused) {
  std::vector<DicomSlice> missing = series();
  missing.erase(missing.begin() + 4);  // s2
  EXPECT_NE(fault_of(missing).find("4 mm between s1 and s3, 2 mm elsewhere"), std::string::npos);
  std::vector<DicomSlice> twice = series();
  twice.push_back(twice.front());
  EXPECT_NE(fault_of(twice).find("not evenly spaced: 0 mm between s3 and s3"), std::string::npos);
  std::vector<DicomSlice> cine(5, series().front());
  EXPECT_NE(fault_of(cine).find("lie in one place"), std::string::npos);
  std::vector<DicomSlice> tilted = series();
  for (DicomSlice& slice : tilted) slice.position_mm += 0.1 * (slice.file[1] - '0') * slice.along_column;
  EXPECT_NE(fault_of(tilted).find("tilted gantry"), std::string::npos);
  std::vector<DicomSlice> turned = series();
  std::swap(turned[2].along_row, turned[2].along_column);
  EXPECT_NE(fault_of(turned).find("different directions (s3 and s1)"), std::string::npos);
  std::vector<DicomSlice> coarse = series();
  coarse[1].pixel_mm.x() = 0.6;
  EXPECT_NE(fault_of(coarse).find("different sizes (s3 and s0)"), std::string::npos);
}

}  // namespace
}  // namespace lumesh::io
