#include "lumesh/domain/extension.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "extension_plan.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/field/continuation.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

/// Indices of an image's voxels.
IndexBox index_box(const ImageFrame& frame, const Box3& box_mm, int margin) {
  const Box3 voxels = voxel_box(frame, box_mm);
  return {voxels.min().array().floor().cast<int>().matrix() - Index3::Constant(margin),
          voxels.max().array().ceil().cast<int>().matrix() + Index3::Constant(margin)};
}

/// Indices are those of the image before.
class VesselContinuation final : public FieldContinuation {
 public:
  VesselContinuation(const ImageDomain& domain, const ExtensionPlan& plan)
      : domain_(domain), frame_(domain.frame()), plan_(plan) {
    for (const VesselTube& tube : plan.tubes) boxes_.push_back(index_box(frame_, tube.box_mm, 1));
    for (const CutPlane& cut : domain.cut_planes())
      if (passes_through(cut)) cuts_.push_back(cut);
  }

  /// The grid: around what of the image is not background, and the extensions.
  [[nodiscard]] IndexBox whole() const {
    IndexBox box{domain_.object_box().low, domain_.object_box().high - Index3::Ones()};
    for (const IndexBox& tube : boxes_) box = {box.low.cwiseMin(tube.low), box.high.cwiseMax(tube.high)};
    constexpr int kMargin = 3, kBrick = LabelField::kBrick;
    for (int axis = 0; axis < 3; ++axis)
      box.low[axis] =
          static_cast<int>(std::floor(static_cast<double>(box.low[axis] - kMargin) / kBrick)) * kBrick;
    return {box.low, box.high + Index3::Constant(kMargin)};
  }
  /// Voxels of the larger image are counted from here.
  void count_from(const Index3& first) { first_ = first; }

  [[nodiscard]] Part part(const Index3& low, const Index3& high) const override {
    const IndexBox box{low + first_, high + first_};
    const IndexBox image{Index3::Zero(), frame_.size - Index3::Ones()};
    if (is_by_tube(box) || may_be_cut(box)) return Part::kMixed;
    return image.holds(box) ? Part::kKept : image.meets(box) ? Part::kMixed : Part::kEmpty;
  }
  /// Extensions of vessels that were cut run through the image.
  [[nodiscard]] std::optional<double> value(const Index3& voxel, LabelField::LabelIndex first,
                                            LabelField::LabelIndex second) const override {
    const Index3 v = voxel + first_;
    const Vec3 x = frame_.to_physical(v.cast<double>());
    const bool is_of_image = is_kept_of_image(v);
    const AtPlace at = tube_at(x);
    if (at.tube == nullptr ? is_of_image : at.tube->stays && is_known(v)) return std::nullopt;
    const LabelField& field = domain_.field();
    if (is_of_image && field.difference_value(v.cast<double>(), 1, 0) > at.outer)
      return field.difference_value(v.cast<double>(), second, first);
    if (first == 0) return at.outer;
    return at.tube == nullptr ? 0 : at.tube->pair_value(field, x, first, second);
  }

  [[nodiscard]] bool is_kept_of_image(const Index3& v) const {
    if (!frame_.contains(v)) return false;
    if (cuts_.empty()) return true;
    const Vec3 x = frame_.to_physical(v.cast<double>());
    return std::ranges::none_of(cuts_, [&](const CutPlane& cut) { return cut.beyond_mm(x) > 0; });
  }
  [[nodiscard]] bool has_cuts() const { return !cuts_.empty(); }
  [[nodiscard]] const std::vector<IndexBox>& tube_boxes() const { return boxes_; }
  /// Of extensions.
  [[nodiscard]] LabelField::LabelIndex label_at(const Index3& v) const {
    const Vec3 x = frame_.to_physical(v.cast<double>());
    const auto [tube, outer] = tube_at(x);
    return tube != nullptr && outer > 0 ? tube->label_at(domain_.field(), x) : LabelField::LabelIndex{0};
  }

 private:
  struct AtPlace {
    const VesselTube* tube = nullptr;
    double outer = -LabelField::kStoredLimit;
  };
  /// The tube that the place is farthest in.
  [[nodiscard]] AtPlace tube_at(const Vec3& x) const {
    AtPlace best;
    for (const VesselTube& tube : plan_.tubes) {
      const double outer = tube.outer_value(domain_.field(), x);
      if (outer > best.outer) best = {&tube, outer};
    }
    return best;
  }

  /// Whether the field of the image has a value there: two voxels beyond it, too.
  [[nodiscard]] bool is_known(const Index3& v) const {
    constexpr int kBeyond = 2;
    return (v.array() >= -kBeyond).all() && (v.array() < frame_.size.array() + kBeyond).all();
  }

  /// Not those at the image's borders.
  [[nodiscard]] bool passes_through(const CutPlane& cut) const {
    for (int c = 0; c < 8; ++c) {
      Vec3 index;
      for (int axis = 0; axis < 3; ++axis) index[axis] = (c >> axis & 1) != 0 ? frame_.size[axis] - 1 : 0;
      if (cut.height(frame_.to_physical(index)) > 0) return true;
    }
    return false;
  }

  /// The smallest ball around the centres of its voxels.
  [[nodiscard]] Circle ball_around(const IndexBox& box) const {
    const Vec3 diagonal = (box.high - box.low).cast<double>().cwiseProduct(frame_.spacing_mm);
    return {frame_.to_physical(0.5 * (box.low + box.high).cast<double>()), 0.5 * diagonal.norm()};
  }
  [[nodiscard]] bool is_by_tube(const IndexBox& box) const {
    const Circle ball = ball_around(box);
    for (std::size_t t = 0; t < boxes_.size(); ++t)
      if (boxes_[t].meets(box) && plan_.tubes[t].may_meet(ball.centre_mm, ball.radius_mm)) return true;
    return false;
  }
  /// Whether a cut may remove a voxel of the box.
  [[nodiscard]] bool may_be_cut(const IndexBox& box) const {
    const Circle ball = ball_around(box);
    return std::ranges::any_of(
        cuts_, [&](const CutPlane& cut) { return cut.beyond_mm(ball.centre_mm) > -ball.radius_mm; });
  }

  const ImageDomain& domain_;
  const ImageFrame& frame_;
  const ExtensionPlan& plan_;
  std::vector<IndexBox> boxes_;
  std::vector<CutPlane> cuts_;
  Index3 first_ = Index3::Zero();
};

/// @throws Error{kBadInput} for one that is much larger.
void check_size(const ImageFrame& before, const ImageFrame& after) {
  constexpr double kTimes = 4;
  constexpr std::size_t kMuch = std::size_t{1} << 27;
  const auto was = static_cast<double>(before.voxel_count()), is = static_cast<double>(after.voxel_count());
  if (after.voxel_count() > kMuch && is > kTimes * was)
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("{}: the image with its extensions would have {} x {} x {} voxels, {:.0f} times as "
                    "many as without; give shorter lengths",
                    option_name("extend"), after.size.x(), after.size.y(), after.size.z(), is / was));
}

/// Crossings of faces that stay, with the numbers that their voxels have in the new image.
void keep_crossings(const LabelImage& image, const Index3& first, LabelImage& extended) {
  const ImageFrame& frame = image.frame();
  for (FaceCrossing crossing : image.crossings()) {
    const Index3 v = frame.voxel_at(crossing.voxel) - first;
    if (!extended.frame().contains(v) || !extended.frame().contains(v + Index3::Unit(crossing.axis)))
      continue;
    crossing.voxel = extended.frame().offset(v);
    extended.crossings().push_back(crossing);
  }
}

LabelImage extended_image(const LabelImage& image, const VesselContinuation& beyond, const IndexBox& whole) {
  const ImageFrame& frame = image.frame();
  ImageFrame larger = frame;
  larger.size = whole.high - whole.low + Index3::Ones();
  larger.origin_mm = frame.to_physical(whole.low.cast<double>());
  check_size(frame, larger);
  LabelImage result(larger, image.values());
  result.label_names() = image.label_names();
  keep_crossings(image, whole.low, result);
  const Index3 low = whole.low.cwiseMax(0), high = whole.high.cwiseMin(frame.size - Index3::Ones());
  const auto fill_row = [&](int j, int k) {
    if (j < low.y() || j > high.y() || k < low.z() || k > high.z()) return;
    const LabelImage::Index* const from = &image.voxels()[frame.offset({low.x(), j, k})];
    LabelImage::Index* const to = &result.at(Index3(low.x(), j, k) - whole.low);
    std::copy_n(from, high.x() - low.x() + 1, to);
    if (!beyond.has_cuts()) return;
    for (int i = low.x(); i <= high.x(); ++i)
      if (to[i - low.x()] != 0 && !beyond.is_kept_of_image({i, j, k})) to[i - low.x()] = 0;
  };
  parallel::for_each_index(grid_row_count(larger.size), 16, [&](std::size_t row) {
    const Index3 place = whole.low + grid_row(larger.size, row);
    const int j = place.y(), k = place.z();
    fill_row(j, k);
    for (const IndexBox& box : beyond.tube_boxes()) {
      if (j < box.low.y() || j > box.high.y() || k < box.low.z() || k > box.high.z()) continue;
      for (int i = box.low.x(); i <= box.high.x(); ++i) {
        LabelImage::Index& label = result.at(Index3(i, j, k) - whole.low);
        if (label == 0) label = beyond.label_at({i, j, k});
      }
    }
  });
  return result;
}

/// What ends the vessels of a plan.
std::vector<CutPlane> ends_of(const ExtensionPlan& plan, std::span<const Opening> openings,
                              const ImageFrame& frame) {
  constexpr double kAir = 1.5;  // Layers of voxels beyond the stump.
  std::vector<CutPlane> ends;
  for (std::size_t g = 0; g < plan.groups.size(); ++g) {
    const VesselTube& tube = plan.tubes[g];
    CutPlane& end = ends.emplace_back(CutPlane{tube.end_mm, tube.end_normal});
    end.section = tube.of_cut;
    end.radius_mm = 0.5 * tube.section->step_mm * std::hypot(tube.section->columns, tube.section->rows);
    end.depth_mm = tube.stump_mm + kAir * frame.thickness_along_mm(tube.end_normal);
    for (const std::size_t m : plan.groups[g].members)
      end.names.emplace_back(openings[m].label, openings[m].name);
  }
  return ends;
}

}  // namespace

ExtendedImage extend_openings(const LabelImage& image, const ImageDomain& domain,
                              std::span<const Opening> openings, const ExtensionOptions& options) {
  ExtensionPlan plan = plan_extensions(domain, openings, options);
  VesselContinuation beyond(domain, plan);
  const IndexBox whole = beyond.whole();
  ExtendedImage result{extended_image(image, beyond, whole), nullptr, std::move(plan.notes)};
  beyond.count_from(whole.low);
  result.domain = std::make_shared<const ImageDomain>(
      result.image, domain.field().continued(result.image, whole.low, beyond),
      ends_of(plan, openings, image.frame()));
  return result;
}

}  // namespace lumesh
