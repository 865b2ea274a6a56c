#include "voxel_reach.hpp"

#include <algorithm>
#include <cmath>

namespace lumesh {

namespace {

/// Whether a voxel has the label and a face towards another one.
bool is_boundary_voxel(const LabelImage& image, const Index3& voxel, LabelImage::Index label) {
  const ImageFrame& frame = image.frame();
  if (!frame.contains(voxel) || image.at(voxel) != label) return false;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      Index3 next = voxel;
      next[axis] += side;
      if (frame.contains(next) && image.at(next) != label) return true;
    }
  }
  return false;
}

struct NearestVoxel {
  double squared_mm = 1e300;
  Vec3 index = Vec3::Zero();
};

/// The nearest boundary voxel among the 2 ring + 2 of each axis around a point; stops at one within
/// `enough_mm2`.
NearestVoxel nearest_voxel(const LabelImage& image, const Vec3& at, LabelImage::Index label,
                           const Index3& ring, double enough_mm2) {
  const Vec3& spacing = image.frame().spacing_mm;
  const Index3 base = Eigen::Array3d(at.array().floor()).cast<int>().matrix();
  const Index3 low = (base - ring).cwiseMax(0);
  const Index3 high = (base + ring + Index3::Ones()).cwiseMin(image.frame().size - Index3::Ones());
  NearestVoxel best;
  for (int k = low.z(); k <= high.z(); ++k) {
    for (int j = low.y(); j <= high.y(); ++j) {
      for (int i = low.x(); i <= high.x(); ++i) {
        const Index3 voxel(i, j, k);
        const Vec3 centre = voxel.cast<double>();
        const double squared_mm = (at - centre).cwiseProduct(spacing).squaredNorm();
        if (squared_mm >= best.squared_mm || !is_boundary_voxel(image, voxel, label)) continue;
        best = {squared_mm, centre};
        if (squared_mm <= enough_mm2) return best;
      }
    }
  }
  return best;
}

/// The point moved towards a centre until it is within the limit, staying in the cut planes of the set.
Vec3 pulled(const Vec3& point, const Vec3& centre, double limit_mm, const ImageDomain& domain,
            const MaterialSet& materials) {
  Vec3 towards = centre - point;
  double out_of_plane2 = 0;
  for (const Material m : materials) {
    if (!domain.is_cut(m)) continue;
    const Vec3& normal = domain.cut_plane(m).normal;
    const double out = normal.dot(towards);
    towards -= out * normal;
    out_of_plane2 += out * out;
  }
  const double length = towards.norm();
  const double allowed = std::sqrt(std::max(0.0, limit_mm * limit_mm - out_of_plane2));
  return length > allowed ? Vec3(point + towards * (1 - allowed / length)) : point;
}

}  // namespace

Vec3 within_reach_of_voxels(const LabelImage& image, const ImageDomain& domain, const MaterialSet& materials,
                            const Vec3& point_mm) {
  const ImageFrame& frame = image.frame();
  const double limit_mm = 1.12 * 0.5 * frame.spacing_mm.norm();
  Vec3 result = point_mm;
  for (const Material m : materials) {
    if (!domain.is_meshed(m)) continue;
    const auto label = static_cast<LabelImage::Index>(m);
    const Vec3 at = frame.to_index(result);
    NearestVoxel nearest = nearest_voxel(image, at, label, Index3::Zero(), limit_mm * limit_mm);
    if (nearest.squared_mm <= limit_mm * limit_mm) continue;
    nearest = nearest_voxel(image, at, label, Index3::Ones(), 0);
    const double distance_mm = std::sqrt(nearest.squared_mm);
    if (distance_mm <= limit_mm || distance_mm > 2 * limit_mm) continue;
    result = pulled(result, frame.to_physical(nearest.index), limit_mm, domain, materials);
  }
  return result;
}

double distance_to_voxels_mm(const LabelImage& image, const ImageDomain& domain, const MaterialSet& materials,
                             const Vec3& point_mm, double enough_mm) {
  const Vec3 at = image.frame().to_index(point_mm);
  const Index3 ring = (enough_mm / image.frame().spacing_mm.array())
                          .ceil()
                          .max(1)
                          .min(image.frame().size.cast<double>().array())
                          .cast<int>();
  const double enough_mm2 = enough_mm * enough_mm;
  double most_mm2 = 0;
  for (const Material m : materials) {
    if (!domain.is_meshed(m)) continue;
    const auto label = static_cast<LabelImage::Index>(m);
    NearestVoxel nearest = nearest_voxel(image, at, label, Index3::Zero(), enough_mm2);
    if (nearest.squared_mm > enough_mm2) nearest = nearest_voxel(image, at, label, ring, 0);
    most_mm2 = std::max(most_mm2, nearest.squared_mm);
  }
  return std::min(std::sqrt(most_mm2), enough_mm + 2 * domain.voxel_size_mm());
}

}  // namespace lumesh
