#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "lumesh/core/error.hpp"
#include "lumesh/domain/cut_plane.hpp"

namespace lumesh {
namespace {

enum class Side : std::uint8_t { kNone, kAbove, kBelow };

class VesselCut {
 public:
  VesselCut(LabelImage& image, const CutPlane& plane)
      : image_(image),
        frame_(image.frame()),
        plane_{plane.point_mm, plane.normal.normalized()},
        voxel_mm_(frame_.spacing_mm.maxCoeff()),
        layer_mm_((frame_.direction.transpose() * plane_.normal).cwiseAbs().dot(frame_.spacing_mm)),
        is_in_section_(image.voxels().size(), false),
        part_(image.voxels().size(), Side::kNone) {}

  CutPlane make() {
    find_section();
    std::vector<Index3> above = start_of(Side::kAbove), below = start_of(Side::kBelow);
    flood(above, Side::kAbove);
    flood(below, Side::kBelow);
    if (below.size() < above.size()) {
      plane_.normal = -plane_.normal;
      std::swap(above, below);
    }
    if (above.empty())
      throw Error(ErrorKind::kBadInput, place_text() + " ends there: nothing would be cut off");
    bound(above.front());
    remove(above);
    return plane_;
  }

 private:
  [[nodiscard]] Vec3 centre_of(const Index3& v) const { return frame_.to_physical(v.cast<double>()); }
  [[nodiscard]] double height_of(const Index3& v) const { return plane_.height(centre_of(v)); }
  [[nodiscard]] double off_axis_mm(const Index3& v) const {
    return (centre_of(v) - plane_.point_mm - height_of(v) * plane_.normal).norm();
  }
  [[nodiscard]] bool is_object(const Index3& v) const { return frame_.contains(v) && image_.at(v) != 0; }
  [[nodiscard]] bool is_in_plane(const Index3& v) const { return std::abs(height_of(v)) <= 0.5 * layer_mm_; }
  [[nodiscard]] Side side_of(const Index3& v) const { return height_of(v) > 0 ? Side::kAbove : Side::kBelow; }
  [[nodiscard]] Side& part(const Index3& v) { return part_[frame_.offset(v)]; }
  [[nodiscard]] std::string place_text() const {
    const Vec3& p = plane_.point_mm;
    return fmt::format("the vessel at ({:.1f}, {:.1f}, {:.1f}) mm", p.x(), p.y(), p.z());
  }

  template <class Visit>
  static void for_each_in_cube(const Index3& middle, int reach, const Visit& visit) {
    for (int k = -reach; k <= reach; ++k)
      for (int j = -reach; j <= reach; ++j)
        for (int i = -reach; i <= reach; ++i) visit(Index3(middle + Index3(i, j, k)));
  }
  template <class Visit>
  void for_each_neighbour(const Index3& at, const Visit& visit) const {
    for (int axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1})
        if (const Index3 v = at + step * Index3::Unit(axis); is_object(v)) visit(v);
  }

  /// Voxels that the plane passes through, joined through faces, edges or corners, from the nearest on.
  void find_section() {
    constexpr int kReach = 2;  // Voxels.
    std::optional<Index3> first;
    double nearest_mm = std::numeric_limits<double>::infinity();
    for_each_in_cube(frame_.to_index(plane_.point_mm).array().round().cast<int>(), kReach,
                     [&](const Index3& v) {
                       const double off_mm = (centre_of(v) - plane_.point_mm).norm();
                       if (!is_object(v) || !is_in_plane(v) || off_mm >= nearest_mm) return;
                       first = v;
                       nearest_mm = off_mm;
                     });
    if (!first) throw Error(ErrorKind::kBadInput, place_text() + " is none: all is background there");
    const auto add = [&](const Index3& v) {
      is_in_section_[frame_.offset(v)] = true;
      section_.push_back(v);
      section_mm_ = std::max(section_mm_, off_axis_mm(v));
    };
    add(*first);
    for (std::size_t s = 0; s < section_.size(); ++s)
      for_each_in_cube(Index3(section_[s]), 1, [&](const Index3& v) {
        if (is_object(v) && is_in_plane(v) && !is_in_section_[frame_.offset(v)]) add(v);
      });
  }

  /// Voxels of the section and beside it.
  [[nodiscard]] std::vector<Index3> start_of(Side side) {
    std::vector<Index3> start;
    const auto take = [&](const Index3& v) {
      if (side_of(v) != side || part(v) != Side::kNone) return;
      part(v) = side;
      start.push_back(v);
    };
    for (const Index3& v : section_) {
      take(v);
      for_each_neighbour(v, take);
    }
    return start;
  }

  /// Adds all voxels that hang together with the first ones without a step through the section.
  void flood(std::vector<Index3>& voxels, Side side) {
    for (std::size_t s = 0; s < voxels.size(); ++s) {
      const Index3 at = voxels[s];
      for_each_neighbour(at, [&](const Index3& v) {
        const bool is_cut = is_in_section_[frame_.offset(at)] || is_in_section_[frame_.offset(v)];
        if (part(v) == side || (is_cut && side_of(at) != side_of(v))) return;
        if (part(v) != Side::kNone)
          throw Error(ErrorKind::kBadInput,
                      place_text() +
                          " is part of a loop, so that a cut there leaves one piece; cut its other end, too, "
                          "or give a whole plane with --cut-plane");
        part(v) = side;
        voxels.push_back(v);
      });
    }
  }

  /// The cylinder holds the stump with a margin, and nothing of what stays.
  void bound(const Index3& gone) {
    const Side part_that_goes = part(gone);
    const double least_radius_mm = section_mm_ + voxel_mm_, least_depth_mm = 3 * layer_mm_;
    plane_.radius_mm = section_mm_ + 3 * voxel_mm_;
    plane_.depth_mm = 7 * layer_mm_;
    const int reach =
        static_cast<int>(std::ceil((plane_.radius_mm + plane_.depth_mm) / frame_.spacing_mm.minCoeff()));
    for_each_in_cube(frame_.to_index(plane_.point_mm).array().round().cast<int>(), reach,
                     [&](const Index3& v) {
                       if (!is_object(v) || part(v) == part_that_goes || plane_.beyond_mm(centre_of(v)) < 0)
                         return;
                       const double radius_mm = off_axis_mm(v) - voxel_mm_;
                       if (radius_mm >= least_radius_mm)
                         plane_.radius_mm = std::min(plane_.radius_mm, radius_mm);
                       else
                         plane_.depth_mm = std::min(plane_.depth_mm, height_of(v) - voxel_mm_);
                     });
    if (plane_.depth_mm < least_depth_mm)
      throw Error(ErrorKind::kBadInput,
                  place_text() + " has another one within two voxels beside it; cut elsewhere");
  }

  void remove(const std::vector<Index3>& voxels) {
    const double stump_radius_mm = std::min(section_mm_ + voxel_mm_, plane_.radius_mm - voxel_mm_);
    const double stump_depth_mm = plane_.depth_mm - 2 * layer_mm_;
    for (const Index3& v : voxels)
      if (height_of(v) > stump_depth_mm || off_axis_mm(v) > stump_radius_mm) image_.at(v) = 0;
  }

  LabelImage& image_;
  const ImageFrame frame_;
  CutPlane plane_;
  double voxel_mm_;
  double layer_mm_;        // What a plane as thick as this passes through parts all steps between voxels.
  double section_mm_ = 0;  // The farthest of its voxels from the point.
  std::vector<Index3> section_;
  std::vector<bool> is_in_section_;
  std::vector<Side> part_;
};

}  // namespace

CutPlane cut_off_vessel(LabelImage& image, const CutPlane& plane) {
  return VesselCut(image, plane).make();
}

}  // namespace lumesh
