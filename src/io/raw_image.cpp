#include "raw_image.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <string>
#include <vector>

#include "file_fault.hpp"
#include "lumesh/core/angles.hpp"
#include "lumesh/core/memory.hpp"
#include "lumesh/io/unit_doubt.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::io {

namespace {

namespace fs = std::filesystem;

/// Files round direction cosines to about 6 digits; less than this is not worth a warning.
constexpr double kSilentAngleDeg = 0.01;
/// More than this is a sheared grid, not rounding: a voxel at the far side would be displaced by 5 % of the
/// image.
constexpr double kLargestAngleDeg = 3.0;

/// Nearest orthonormal matrix: the orthogonal factor of the polar decomposition (Higham 1986,
/// doi:10.1137/0907079), U V^T of the singular value decomposition U S V^T. Keeps the sign of the
/// determinant.
Mat3 nearest_orthonormal(const fs::path& path, const Mat3& direction, Context& context) {
  if (!direction.allFinite()) fail(path, "its direction cosines are not numbers; correct the header");
  Mat3 unit = direction;
  for (int i = 0; i < 3; ++i) {
    const double length = unit.col(i).norm();
    if (!(length > 0)) fail(path, "one of its axes has no direction; correct the header");
    unit.col(i) /= length;
  }
  const Eigen::JacobiSVD<Mat3> svd(unit, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Mat3 repaired = svd.matrixU() * svd.matrixV().transpose();
  double worst_sine = 0;
  for (int i = 0; i < 3; ++i) worst_sine = std::max(worst_sine, unit.col(i).cross(repaired.col(i)).norm());
  const double angle_deg = degrees(std::asin(std::min(1.0, worst_sine)));
  if (std::abs(unit.determinant()) < 0.5 || angle_deg > kLargestAngleDeg)
    fail(path, fmt::format(
                   "its axes are not perpendicular (off by {:.1f} degrees); resample the image to a regular "
                   "grid",
                   angle_deg));
  if (angle_deg > kSilentAngleDeg)
    context.warn(
        fmt::format("{}: direction cosines are not orthonormal; used the nearest ones ({:.2g} degrees off)",
                    path.string(), angle_deg));
  return repaired;
}

/// Axes whose spacing is a guess, and the guess; empty if there are none.
std::string text_of_axes_without_spacing(const ImageHeader& header) {
  std::vector<int> axes;
  double taken_mm = 0;
  for (int i = 0; i < 3; ++i) {
    if (header.has_spacing.at(static_cast<std::size_t>(i))) continue;
    axes.push_back(i + 1);
    taken_mm = header.spacing_mm[i];
  }
  if (axes.empty()) return "";
  if (axes.size() == 3) return fmt::format("; taken as {} mm", taken_mm);
  return fmt::format(" along {} {}; taken as {} mm", axes.size() == 1 ? "axis" : "axes",
                     fmt::join(axes, " and "), taken_mm);
}

void warn_of_size(const fs::path& path, const ImageHeader& header, const ImageFrame& frame,
                  Context& context) {
  const std::string doubt =
      unit_doubt({.longest_mm = frame.spacing_mm.cwiseProduct(frame.size.cast<double>()).maxCoeff(),
                  .stated_unit = header.stated_unit});
  const std::string axes = text_of_axes_without_spacing(header);
  if (!axes.empty())
    context.warn(path.string() + ": says nothing of the size of voxels" + axes);
  else if (!doubt.empty() && !header.unit_is_given)
    context.warn(path.string() + ": " + doubt);
}

}  // namespace

void swap_bytes(RawImage& image) {
  const std::size_t width = voxel_bytes(image.type);
  if (width == 1) return;
  std::byte* const voxels = image.voxels.get();
  parallel::for_each_index(image.value_count(), [&](std::size_t i) {
    std::reverse(voxels + i * width, voxels + (i + 1) * width);
  });
}

/// Far from 0 numbers of double precision cannot tell places in a voxel apart.
void check_origin(const fs::path& path, const ImageHeader& header) {
  if (!header.origin_mm.allFinite()) fail(path, "its origin is not a number; correct the header");
  constexpr double kFinestPart = 1e-4;  // Of a voxel.
  const double distance_mm = header.origin_mm.cwiseAbs().maxCoeff();
  if (std::numeric_limits<double>::epsilon() * distance_mm > kFinestPart * header.spacing_mm.minCoeff())
    fail(path,
         fmt::format("its origin is {:.3g} mm from 0, too far to tell places within its voxels of {:.3g} "
                     "mm apart; correct the origin in the header",
                     distance_mm, header.spacing_mm.minCoeff()));
}

ImageFrame checked_frame(const fs::path& path, const ImageHeader& header, Context& context) {
  constexpr std::int64_t kLargestSide = std::int64_t{1} << 20;
  ImageFrame frame;
  for (int i = 0; i < 3; ++i) {
    const std::int64_t side = header.size.at(static_cast<std::size_t>(i));
    if (side < 1 || side > kLargestSide) fail(path, fmt::format("its size along axis {} is {}", i + 1, side));
    frame.size[i] = static_cast<int>(side);
    const double spacing = header.spacing_mm[i];
    if (!std::isfinite(spacing) || spacing <= 0)
      fail(path, fmt::format("its spacing along axis {} is {} mm; correct the header, it must be positive",
                             i + 1, spacing));
  }
  if ((frame.size.array() < 2).any())
    fail(path, fmt::format("is a flat image of {} x {} x {} voxels; lumesh needs a 3-D one", frame.size.x(),
                           frame.size.y(), frame.size.z()));
  check_origin(path, header);
  frame.spacing_mm = header.spacing_mm;
  frame.origin_mm = header.origin_mm;
  frame.direction = nearest_orthonormal(path, header.direction, context);
  warn_of_size(path, header, frame, context);
  return frame;
}

std::unique_ptr<std::byte[]> allocate_voxels(const fs::path& path, const ImageFrame& frame, VoxelType type,
                                             std::uintmax_t file_bytes, std::size_t volumes) {
  constexpr std::uintmax_t kGzipLimit = 1040;  // Deflate cannot pack tighter than 1032 : 1.
  const std::uintmax_t voxels = frame.voxel_count();
  const std::uintmax_t bytes = voxels * volumes * voxel_bytes(type);
  if (file_bytes > 0 && bytes / kGzipLimit > file_bytes)
    fail(path, fmt::format("is too short for the {} x {} x {} voxels its header names; copy it again",
                           frame.size.x(), frame.size.y(), frame.size.z()));
  const std::uintmax_t needed = bytes + voxels * sizeof(LabelImage::Index);
  const std::string advice = fmt::format(
      "{} x {} x {} voxels{} need {:.1f} GiB of memory; crop or resample the image", frame.size.x(),
      frame.size.y(), frame.size.z(), volumes > 1 ? fmt::format(" in {} volumes", volumes) : "",
      static_cast<double>(needed) / (1U << 30U));
  if (needed > available_memory_bytes()) fail(path, advice, ErrorKind::kMemory);
  try {
    return std::unique_ptr<std::byte[]>(new std::byte[bytes]);  // Uninitialised: read() fills all of it.
  } catch (const std::bad_alloc&) {
    fail(path, advice, ErrorKind::kMemory);
  }
}

}  // namespace lumesh::io
