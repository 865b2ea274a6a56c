#include <algorithm>

#include "lumesh/domain/carried_section.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh {

namespace {

double kept_share(const ImageFrame& frame, std::span<const CutPlane> planes, const Vec3& centre_mm) {
  double share = 1;
  for (const CutPlane& plane : planes) {
    const double beyond = plane.beyond_mm(centre_mm);
    const double width = frame.thickness_along_mm(plane.normal);
    share *= std::clamp(0.5 - beyond / width, 0.0, 1.0);
  }
  constexpr double kRounding = 1e-9;  // a plane along voxel faces keeps nothing of those behind it
  return share < kRounding ? 0 : share;
}

}  // namespace

Vec3 nearest_within(std::span<const CutPlane> planes, Vec3 point_mm) {
  constexpr int kRounds = 50;  // Planes at a right angle need one; each other corner comes nearer.
  bool is_beyond = true;
  for (int round = 0; round < kRounds && is_beyond; ++round) {
    is_beyond = false;
    for (const CutPlane& plane : planes) {
      if (plane.beyond_mm(point_mm) <= 0) continue;
      point_mm -= plane.height(point_mm) * plane.normal;
      is_beyond = true;
    }
  }
  return point_mm;
}

double CutPlane::beyond_mm(const Vec3& x) const {
  const double above = height(x);
  if (!is_bounded()) return above;
  const double inside_mm =
      section ? section->inside_mm(x) : radius_mm - (x - point_mm - above * normal).norm();
  return std::min({above, inside_mm, depth_mm - above});
}

std::vector<double> count_kept_voxels(const LabelImage& image, std::span<const CutPlane> planes) {
  const ImageFrame& frame = image.frame();
  const auto width = static_cast<std::size_t>(frame.size.x());
  const auto rows = image.voxels().size() / width;
  return parallel::reduce(
      rows, 1024, std::vector<double>(image.values().size(), 0),
      [&](std::vector<double>& counts, std::size_t row) {
        const Index3 first = frame.voxel_at(row * width);
        for (std::size_t i = 0; i < width; ++i) {
          const LabelImage::Index label = image.voxels()[row * width + i];
          if (label != 0)
            counts[label] += kept_share(
                frame, planes, frame.to_physical(Vec3(static_cast<double>(i), first.y(), first.z())));
        }
      },
      parallel::AddEach());
}

}  // namespace lumesh
