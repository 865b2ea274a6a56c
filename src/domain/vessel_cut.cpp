#include "lumesh/domain/vessel_cut.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>

#include "lumesh/core/error.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/geometry/cut_part.hpp"
#include "lumesh/image/label_image.hpp"

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
        layer_mm_(frame_.thickness_along_mm(plane_.normal)),
        is_in_section_(image.voxels().size(), false),
        part_(image.voxels().size(), Side::kNone) {}

  CutVessel make(double radius_mm, double max_widening, CutPart goes) {
    find_section();
    check_section(radius_mm, max_widening);
    std::vector<Index3> above = start_of(Side::kAbove), below = start_of(Side::kBelow);
    flood(above, Side::kAbove);
    flood(below, Side::kBelow);
    if (goes == CutPart::kSmaller && below.size() < above.size()) {
      plane_.normal = -plane_.normal;
      std::swap(above, below);
    }
    if (above.empty())
      throw Error(ErrorKind::kBadInput, vessel_text() + " ends there: nothing would be cut off");
    bound(above.front());
    remove(above);
    return {plane_, section_mm2()};
  }

 private:
  [[nodiscard]] Vec3 centre_of(const Index3& v) const { return frame_.to_physical(v.cast<double>()); }
  [[nodiscard]] double height_of(const Index3& v) const { return plane_.height(centre_of(v)); }
  [[nodiscard]] double off_axis_mm(const Index3& v) const {
    return (centre_of(v) - plane_.point_mm - height_of(v) * plane_.normal).norm();
  }
  [[nodiscard]] Index3 middle() const { return frame_.to_index(plane_.point_mm).array().round().cast<int>(); }
  [[nodiscard]] bool is_object(const Index3& v) const { return frame_.contains(v) && image_.at(v) != 0; }
  [[nodiscard]] bool is_in_plane(const Index3& v) const { return std::abs(height_of(v)) <= 0.5 * layer_mm_; }
  [[nodiscard]] Side side_of(const Index3& v) const { return height_of(v) > 0 ? Side::kAbove : Side::kBelow; }
  [[nodiscard]] Side& part(const Index3& v) { return part_[frame_.offset(v)]; }
  [[nodiscard]] std::string vessel_text() const { return "the vessel at " + place_text(plane_.point_mm); }

  template <class Visit>
  void for_each_neighbour(const Index3& at, const Visit& visit) const {
    for (int axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1})
        if (const Index3 v = at + step * Index3::Unit(axis); is_object(v)) visit(v);
  }

  /// Voxels that the plane passes through, joined through faces, from the nearest on.
  void find_section() {
    constexpr int kReach = 2;  // Voxels.
    std::optional<Index3> first;
    double nearest_mm = std::numeric_limits<double>::infinity();
    const Index3 reach = Index3::Constant(kReach);
    for_each_place(middle() - reach, middle() + reach, [&](const Index3& v) {
      const double off_mm = (centre_of(v) - plane_.point_mm).norm();
      if (!is_object(v) || !is_in_plane(v) || off_mm >= nearest_mm) return;
      first = v;
      nearest_mm = off_mm;
    });
    if (!first) throw Error(ErrorKind::kBadInput, vessel_text() + " is none: all is background there");
    const auto add = [&](const Index3& v) {
      is_in_section_[frame_.offset(v)] = true;
      section_.push_back(v);
      section_mm_ = std::max(section_mm_, off_axis_mm(v));
    };
    add(*first);
    // A layer of this thickness is joined through faces.
    for (std::size_t s = 0; s < section_.size(); ++s)
      for_each_neighbour(Index3(section_[s]), [&](const Index3& v) {
        if (is_in_plane(v) && !is_in_section_[frame_.offset(v)]) add(v);
      });
  }

  /// The plane's layer of voxels is as thick as layer_mm_.
  [[nodiscard]] double section_mm2() const {
    return static_cast<double>(section_.size()) * frame_.voxel_volume_mm3() / layer_mm_;
  }

  /// In a fork, a bulge or a vessel that runs along the plane there is no section of one vessel.
  void check_section(double radius_mm, double max_widening) const {
    const double of_vessel = std::numbers::pi * radius_mm * radius_mm;
    const double area = section_mm2(), of_voxel = frame_.voxel_volume_mm3() / layer_mm_;
    if (area > max_widening * of_vessel + 4 * of_voxel)
      throw Error(ErrorKind::kBadInput, wide_section_text(vessel_text(), area, of_vessel, radius_mm));
    const Index3 last = frame_.size - Index3::Ones();
    for (const Index3& v : section_)
      if ((v.array() == 0).any() || (v.array() == last.array()).any())
        throw Error(
            ErrorKind::kBadInput,
            vessel_text() + " leaves the image within the section across its axis; cut further inside");
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

  /// Adds all voxels that are connected with the first ones without a step through the section.
  void flood(std::vector<Index3>& voxels, Side side) {
    for (std::size_t s = 0; s < voxels.size(); ++s) {
      const Index3 at = voxels[s];
      for_each_neighbour(at, [&](const Index3& v) {
        const bool is_cut = is_in_section_[frame_.offset(at)] || is_in_section_[frame_.offset(v)];
        if (part(v) == side || (is_cut && side_of(at) != side_of(v))) return;
        if (part(v) != Side::kNone) throw Error(ErrorKind::kBadInput, loop_text(vessel_text()));
        part(v) = side;
        voxels.push_back(v);
      });
    }
  }

  /// The cylinder holds the stump. What stays keeps away from it by more than a mesher's cells may be long.
  void bound(const Index3& gone) {
    const Side side_that_goes = part(gone);
    const double margin_mm = kMargin * voxel_mm_;
    const double stump_mm = section_mm_ + kBeside * voxel_mm_;
    plane_.radius_mm = stump_mm + kAir * voxel_mm_;
    plane_.depth_mm = kDepth * layer_mm_;
    const double min_depth_mm = kMinDepth * layer_mm_;
    const double reach_mm = plane_.radius_mm + plane_.depth_mm + 2 * margin_mm;
    const Index3 reach = (reach_mm * frame_.spacing_mm.cwiseInverse()).array().ceil().cast<int>();
    const Index3 low = (middle() - reach).cwiseMax(0),
                 high = (middle() + reach).cwiseMin(frame_.size - Index3::Ones());
    for_each_place(low, high, [&](const Index3& v) {
      if (!is_object(v) || part(v) == side_that_goes) return;
      const double height = height_of(v);
      if (height <= 0.5 * layer_mm_ || off_axis_mm(v) > stump_mm + margin_mm) return;
      plane_.depth_mm = std::min(plane_.depth_mm, height - margin_mm);
    });
    if (plane_.depth_mm < min_depth_mm)
      throw Error(ErrorKind::kBadInput,
                  fmt::format("{} has another one beside it, less than {:.2g} mm away; cut elsewhere",
                              vessel_text(), (kBeside + kMargin) * voxel_mm_));
  }

  void remove(const std::vector<Index3>& voxels) {
    const double stump_radius_mm = section_mm_ + kBeside * voxel_mm_;
    const double stump_depth_mm = plane_.depth_mm - kAir * layer_mm_;
    for (const Index3& v : voxels) {
      const bool is_behind = height_of(v) <= 0 && !is_in_section_[frame_.offset(v)];  // It came back.
      if (is_behind || height_of(v) > stump_depth_mm || off_axis_mm(v) > stump_radius_mm) image_.at(v) = 0;
    }
  }

  // Of the cylinder, in layers of voxels.
  static constexpr double kDepth = 6.5, kMinDepth = 4.5;
  // In voxels: how much wider than the section the stump may be, the air around it, and how far what stays is
  // off.
  static constexpr double kBeside = 1, kAir = 1.5, kMargin = 2.5;

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

CutVessel cut_off_vessel(LabelImage& image, const CutPlane& plane, double radius_mm, double max_widening,
                         CutPart goes) {
  return VesselCut(image, plane).make(radius_mm, max_widening, goes);
}

}  // namespace lumesh
