#include "cut_voxels.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "lumen.hpp"
#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::centerline {

namespace {

/// The box of the indices of voxels.
Box3 box_of(const std::vector<Index3>& voxels) {
  Box3 box;
  for (const Index3& v : voxels) box.extend(v.cast<double>());
  return box;
}

class ImageCutter {
 public:
  ImageCutter(const LabelImage& image, std::span<const CutPlane> cuts)
      : image_(image), frame_(image.frame()), planes_(cuts.begin(), cuts.end()) {
    for (CutPlane& plane : planes_) plane.normal.normalize();
  }

  CutVoxels cut() {
    CutVoxels voxels;
    voxels.inside = foreground([&](const Index3& v) { return !cut_at(v); });
    voxels.beyond = planes_.empty() ? std::vector<Index3>()
                                    : foreground([&](const Index3& v) { return cut_at(v).has_value(); });
    voxels.sections = sections(voxels.inside);
    for (const CutSection& section : voxels.sections)
      if (section.plane.is_bounded()) carry_on(section, voxels.beyond);
    parallel::sort_unique(voxels.beyond, MemoryOrder{frame_});
    voxels.planes = std::move(planes_);
    return voxels;
  }

 private:
  struct CarriedVoxel {
    Index3 at;
    double height_mm;
  };

  [[nodiscard]] Vec3 centre_of(const Index3& v) const { return frame_.to_physical(v.cast<double>()); }

  /// The plane that a voxel lies farthest beyond.
  [[nodiscard]] std::optional<std::size_t> cut_at(const Index3& v) const {
    std::optional<std::size_t> farthest;
    double max_mm = 0;
    for (std::size_t c = 0; c < planes_.size(); ++c) {
      const double beyond_mm = planes_[c].beyond_mm(centre_of(v));
      if (beyond_mm <= max_mm) continue;
      farthest = c;
      max_mm = beyond_mm;
    }
    return farthest;
  }
  [[nodiscard]] bool is_inside(const Index3& v) const {
    return frame_.contains(v) && image_.at(v) != 0 && !cut_at(v);
  }

  template <class Wanted>
  [[nodiscard]] std::vector<Index3> foreground(const Wanted& is_wanted) const {
    const auto columns = static_cast<std::size_t>(frame_.size.y());
    return parallel::collect<Index3>(
        columns * static_cast<std::size_t>(frame_.size.z()), 512,
        [&](std::size_t row, std::vector<Index3>& out) {
          const auto j = static_cast<int>(row % columns), k = static_cast<int>(row / columns);
          const LabelImage::Index* labels = image_.voxels().data() + frame_.offset({0, j, k});
          for (int i = 0; i < frame_.size.x(); ++i)
            if (labels[i] != 0 && is_wanted(Index3(i, j, k))) out.emplace_back(i, j, k);
        });
  }

  [[nodiscard]] std::vector<CutSection> sections(const std::vector<Index3>& inside) const {
    std::vector<CutSection> sections;
    for (const CutPlane& plane : planes_) {
      std::vector<Index3> last =
          parallel::collect<Index3>(inside.size(), 4096, [&](std::size_t n, std::vector<Index3>& out) {
            if (is_last(inside[n], plane)) out.push_back(inside[n]);
          });
      for (std::vector<Index3>& part : parts_of(plane, std::move(last)))
        sections.push_back({plane, std::move(part)});
    }
    return sections;
  }

  /// Whether a voxel has a neighbour beyond a plane, where the object may go on. A vessel may have been cut
  /// off right there.
  [[nodiscard]] bool is_last(const Index3& v, const CutPlane& plane) const {
    const double height_mm = plane.height(centre_of(v));
    if (height_mm > 0 || height_mm < -frame_.thickness_along_mm(plane.normal)) return false;
    for (int a = 0; a < 6; ++a) {
      const Index3 next = v + (a % 2 == 0 ? 1 : -1) * Index3::Unit(a / 2);
      if (frame_.contains(next) && (plane.is_bounded() || image_.at(next) != 0) &&
          plane.beyond_mm(centre_of(next)) > 0)
        return true;
    }
    return false;
  }

  /// A plane with a bound cuts one vessel, others may cut several.
  [[nodiscard]] std::vector<std::vector<Index3>> parts_of(const CutPlane& plane,
                                                          std::vector<Index3> voxels) const {
    if (voxels.empty()) return {};
    if (plane.is_bounded()) return {std::move(voxels)};
    const MemoryOrder before{frame_};
    DisjointSets sets(voxels.size());
    for (std::size_t n = 0; n < voxels.size(); ++n)
      for_each_place(voxels[n] - Index3::Ones(), voxels[n] + Index3::Ones(), [&](const Index3& v) {
        const auto at = std::ranges::lower_bound(voxels, v, before);
        if (at != voxels.end() && *at == v)
          sets.merge(static_cast<std::uint32_t>(n), static_cast<std::uint32_t>(at - voxels.begin()));
      });
    std::map<std::uint32_t, std::vector<Index3>> parts;
    for (std::size_t n = 0; n < voxels.size(); ++n)
      parts[sets.find(static_cast<std::uint32_t>(n))].push_back(voxels[n]);
    std::vector<std::vector<Index3>> all;
    for (auto& [root, part] : parts) all.push_back(std::move(part));
    return all;
  }

  /// The image has a stump of a few voxels of a vessel that was cut off, whose end would be a wall. Where
  /// another vessel comes near, it ends before that.
  void carry_on(const CutSection& section, std::vector<Index3>& beyond) const {
    const double layer_mm = frame_.thickness_along_mm(section.plane.normal);
    const std::vector<CarriedVoxel> carried = carried_over(section, radius_mm(section));
    double end_mm = std::numeric_limits<double>::infinity();
    for (const CarriedVoxel& voxel : carried)
      if (voxel.height_mm > 2 * layer_mm && is_beside_object(voxel.at))
        end_mm = std::min(end_mm, voxel.height_mm - layer_mm);
    for (const CarriedVoxel& voxel : carried)
      if (voxel.height_mm < end_mm) beyond.push_back(voxel.at);
  }

  [[nodiscard]] double radius_mm(const CutSection& section) const {
    constexpr double kMin = 4;  // Voxels.
    const Vec3 middle = frame_.to_physical(box_of(section.voxels).center());
    double radius_mm = kMin * frame_.spacing_mm.maxCoeff();
    for (const Index3& v : section.voxels) radius_mm = std::max(radius_mm, (centre_of(v) - middle).norm());
    return radius_mm;
  }

  [[nodiscard]] std::vector<CarriedVoxel> carried_over(const CutSection& section, double length_mm) const {
    const CutPlane& plane = section.plane;
    const double layer_mm = frame_.thickness_along_mm(plane.normal);
    Box3 box = box_of(section.voxels);
    const Vec3 shift =
        (frame_.direction.transpose() * plane.normal * length_mm).cwiseQuotient(frame_.spacing_mm);
    box.extend(Box3(box.min() + shift, box.max() + shift));
    const Index3 low = (box.min().array().floor().cast<int>() - 1).max(0).matrix();
    const Index3 high = (box.max().array().ceil().cast<int>() + 1).min(frame_.size.array() - 1).matrix();
    std::vector<CarriedVoxel> carried;
    for_each_place(low, high, [&](const Index3& at) {
      const double height_mm = plane.height(centre_of(at));
      if (height_mm <= 0 || height_mm > length_mm || is_inside(at)) return;
      const Vec3 foot = centre_of(at) - (height_mm + 0.5 * layer_mm) * plane.normal;
      if (plane.beyond_mm(foot + (0.5 + kTiny) * layer_mm * plane.normal) <= 0) return;
      if (is_inside(frame_.to_index(foot).array().round().cast<int>())) carried.push_back({at, height_mm});
    });
    return carried;
  }

  [[nodiscard]] bool is_beside_object(const Index3& at) const {
    bool is_beside = false;
    for_each_place(at - Index3::Ones(), at + Index3::Ones(),
                   [&](const Index3& v) { is_beside = is_beside || is_inside(v); });
    return is_beside;
  }

  static constexpr double kTiny = 1e-3;

  const LabelImage& image_;
  const ImageFrame& frame_;
  std::vector<CutPlane> planes_;
};

}  // namespace

CutVoxels voxels_before(const LabelImage& image, std::span<const CutPlane> cuts) {
  return ImageCutter(image, cuts).cut();
}

}  // namespace lumesh::centerline
