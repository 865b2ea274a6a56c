#include "dicom_slices.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "file_fault.hpp"
#include "lumesh/core/value_of_rank.hpp"

namespace lumesh::io {
namespace {

constexpr double kSameDirection = 1e-3;  // Of unit vectors.
constexpr double kSameSize = 1e-3;       // Relative.
constexpr double kEven = 0.02, kRoundedMm = 0.02,
                 kMaxRounded = 0.2;  // Of the spacing, and what files round places to.
constexpr double kMaxTilted = 0.01;  // Sideways, of the way along the normal: 0.6 degrees.

void check_alike(const std::filesystem::path& path, const DicomSlice& first, const DicomSlice& other) {
  if ((first.along_row - other.along_row).norm() > kSameDirection ||
      (first.along_column - other.along_column).norm() > kSameDirection)
    fail(path, fmt::format("slices have different directions ({} and {}); these are several series",
                           first.file, other.file));
  if (((first.pixel_mm - other.pixel_mm).cwiseAbs().array() > kSameSize * first.pixel_mm.array()).any())
    fail(path, fmt::format("slices have pixels of different sizes ({} and {}); resample the series",
                           first.file, other.file));
}

}  // namespace

void check_slices(const std::filesystem::path& path, std::vector<DicomSlice> slices) {
  if (slices.size() < 2) return;
  for (const DicomSlice& slice : slices) check_alike(path, slices.front(), slice);
  const Vec3 normal = slices.front().along_row.cross(slices.front().along_column).normalized();
  const auto height = [&](const DicomSlice& slice) { return slice.position_mm.dot(normal); };
  std::ranges::stable_sort(slices,
                           [&](const DicomSlice& a, const DicomSlice& b) { return height(a) < height(b); });
  std::vector<double> gaps;
  for (std::size_t i = 1; i < slices.size(); ++i) gaps.push_back(height(slices[i]) - height(slices[i - 1]));
  const double usual = value_of_rank(gaps, gaps.size() / 2);
  if (!(usual > 0))
    fail(path,
         fmt::format(
             "several slices lie in one place, such as {} and {}: this is no volume, or one at several times",
             slices[0].file, slices[1].file));
  for (std::size_t i = 0; i < gaps.size(); ++i)
    if (std::abs(gaps[i] - usual) > std::max(kEven * usual, std::min(kRoundedMm, kMaxRounded * usual)))
      fail(path, fmt::format(
                     "slices are not evenly spaced: {:.4g} mm between {} and {}, {:.4g} mm elsewhere; is one "
                     "missing? Resample the series",
                     gaps[i], slices[i].file, slices[i + 1].file, usual));
  const Vec3 way = slices.back().position_mm - slices.front().position_mm;
  const Vec3 sideways = way - way.dot(normal) * normal;
  if (sideways.norm() > kMaxTilted * way.norm())
    fail(path,
         fmt::format(
             "slices are shifted by {:.3g} mm against each other (a tilted gantry); resample the series "
             "to a regular grid",
             sideways.norm()));
}

}  // namespace lumesh::io
