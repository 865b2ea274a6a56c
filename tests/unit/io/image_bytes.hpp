#pragma once
/// @file Image files made byte by byte, so that tests do not rest on our own writers.

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace lumesh::fixtures {

template <class Value>
std::string bytes_of(const std::vector<Value>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value)};
}

/// A header of NRRD with raw voxels; every line can be replaced.
struct NrrdText {
  std::string type = "uint8";
  std::string dimension = "3";
  std::string sizes = "3 4 5";
  std::string frame =
      "space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n";
  std::string extra = "";

  [[nodiscard]] std::string with(const std::string& voxels) const {
    return "NRRD0004\ntype: " + type + "\ndimension: " + dimension + "\nsizes: " + sizes + "\n" + frame +
           extra + "encoding: raw\nendian: little\n\n" + voxels;
  }
};

/// A NIfTI-1 file in one piece. Field offsets: nifti1.h.
struct NiftiBytes {
  std::array<std::int16_t, 8> dimensions = {3, 3, 4, 5, 1, 1, 1, 1};
  std::int16_t data_type = 2;  ///< 2 uint8, 4 int16, 16 float32.
  std::array<float, 4> pixel_size = {1, 1, 1, 1};
  float slope = 0, intercept = 0;
  char units = 2;  ///< Millimetres.
  std::int16_t qform_code = 0, sform_code = 1;
  std::array<float, 6> qform = {};  ///< b, c, d, then the offset.
  std::array<float, 12> sform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  [[nodiscard]] std::string with(const std::string& voxels) const {
    std::string header(352, '\0');
    const auto put = [&](std::size_t at, const auto& value) {
      std::memcpy(&header[at], &value, sizeof(value));
    };
    put(0, std::int32_t{348});
    put(40, dimensions);
    put(70, data_type);
    put(76, pixel_size);
    put(108, 352.0F);
    put(112, slope);
    put(116, intercept);
    header[123] = units;
    put(252, qform_code);
    put(254, sform_code);
    put(256, qform);
    put(280, sform);
    std::memcpy(&header[344], "n+1", 4);
    return header + voxels;
  }
};

/// 60 voxels of 3 x 4 x 5: label 1, but 2 at (2, 0, 0) and 0 at (0, 0, 0).
template <class Value = std::uint8_t>
std::vector<Value> sixty_voxels() {
  std::vector<Value> voxels(60, Value{1});
  voxels[0] = 0;
  voxels[2] = 2;
  return voxels;
}

}  // namespace lumesh::fixtures
