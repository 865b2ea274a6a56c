#include "lumesh/domain/image_domain.hpp"

#include <cmath>
#include <utility>

#include "descent.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/field/label_field.hpp"
#include "lumesh/image/selection.hpp"

namespace lumesh {

const ImageFrame& ImageDomain::frame() const {
  return field_->frame();
}

Box3 voxel_box(const ImageFrame& frame, const Box3& box_mm) {
  Box3 voxels;
  for (int corner = 0; corner < 8; ++corner)
    voxels.extend(frame.to_index(box_mm.corner(static_cast<Box3::CornerType>(corner))));
  return voxels;
}

ImageDomain::ImageDomain(const LabelImage& image, LabelField field, const std::vector<CutPlane>& cuts)
    : field_(std::make_shared<const LabelField>(std::move(field))),
      labels_(image.values()),
      label_names_(image.label_names()) {
  const ImageFrame& f = image.frame();
  index_from_mm_ = f.spacing_mm.cwiseInverse().asDiagonal() * f.direction.transpose();
  voxel_size_mm_ = std::cbrt(f.voxel_volume_mm3());
  unit_mm_ = f.spacing_mm.minCoeff();
  object_box_ = lumesh::object_box(image);
  add_border_cuts(image);
  add_cuts(cuts);
}

ImageDomain::ImageDomain(const LabelImage& image, const ImageDomainOptions& options)
    : ImageDomain(image, LabelField(image, options.field), options.cut_planes) {}

void ImageDomain::add_cuts(const std::vector<CutPlane>& cuts) {
  for (const CutPlane& plane : cuts) {
    if (!(plane.normal.norm() > 0) || !plane.normal.allFinite() || !plane.point_mm.allFinite())
      throw Error(ErrorKind::kUsage, "a cut plane needs a finite point and a normal that is not zero");
    cuts_.push_back(plane);
    cuts_.back().normal.normalize();
    has_bounded_cuts_ = has_bounded_cuts_ || plane.is_bounded();
  }
}

void ImageDomain::add_border_cuts(const LabelImage& image) {
  const ImageFrame& f = image.frame();
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool upper : {false, true}) {
      const bool touches = upper ? object_box_.high[axis] == f.size[axis] : object_box_.low[axis] == 0;
      if (!touches) continue;
      Vec3 index = Vec3::Zero();
      index[axis] = upper ? f.size[axis] - 0.5 : -0.5;
      const Vec3 normal = f.direction.col(axis) * (upper ? 1.0 : -1.0);
      cuts_.push_back({f.to_physical(index), normal});
    }
  }
}

ImageDomain::CutDistance ImageDomain::furthest_cut(const Vec3& point_mm, bool is_bounded) const {
  CutDistance furthest;
  for (std::size_t c = 0; c < cuts_.size(); ++c) {
    if (cuts_[c].is_bounded() != is_bounded || cuts_[c].height(point_mm) <= furthest.beyond_mm) continue;
    const double beyond = cuts_[c].beyond_mm(point_mm);
    if (beyond > furthest.beyond_mm) furthest = {c, beyond};
  }
  return furthest;
}

Domain::Surroundings ImageDomain::surroundings(const Vec3& point_mm) const {
  const CutDistance cut = furthest_cut(point_mm, false);
  if (cut.beyond_mm > 0) return {static_cast<Material>(labels_.size() + cut.cut), cut.beyond_mm};
  const LabelField::Winner winner = field_->winner(frame().to_index(point_mm));
  const double clearance_mm = std::min(-cut.beyond_mm, winner.depth * unit_mm_);
  if (!has_bounded_cuts_ || winner.label == 0) return {winner.label, clearance_mm};
  const CutDistance stump = furthest_cut(point_mm, true);
  const Material m = stump.beyond_mm > 0 ? static_cast<Material>(labels_.size() + stump.cut) : winner.label;
  return {m, std::min(clearance_mm, std::abs(stump.beyond_mm))};
}

Material ImageDomain::material_at(const Vec3& point_mm) const {
  const CutDistance cut = furthest_cut(point_mm, false);
  if (cut.beyond_mm > 0) return static_cast<Material>(labels_.size() + cut.cut);
  const Material label = field_->label_at(frame().to_index(point_mm));
  if (!has_bounded_cuts_ || label == 0) return label;
  const CutDistance stump = furthest_cut(point_mm, true);
  return stump.beyond_mm > 0 ? static_cast<Material>(labels_.size() + stump.cut) : label;
}

double ImageDomain::clearance_limit_mm() const {
  return LabelField::kFieldLimit * unit_mm_;
}

MaterialSet ImageDomain::materials_near(const Vec3& point_mm, double reach_mm) const {
  // Beyond cut planes there is only what the farthest of them cuts off, and others that are hardly nearer.
  const double beyond_mm = std::max(0.0, furthest_cut(point_mm, false).beyond_mm);
  MaterialSet near = beyond_mm > reach_mm ? MaterialSet() : labels_near(point_mm, reach_mm);
  if (has_bounded_cuts_) near = with_stumps(near, point_mm, reach_mm);
  for (std::size_t c = 0; c < cuts_.size(); ++c)
    if (!cuts_[c].is_bounded() && cuts_[c].height(point_mm) >= beyond_mm - reach_mm)
      near.insert(static_cast<Material>(labels_.size() + c));
  return near;
}

/// A bounded cut takes the place of the object beyond its plane; near the plane there is either.
MaterialSet ImageDomain::with_stumps(const MaterialSet& labels, const Vec3& point_mm, double reach_mm) const {
  MaterialSet near = labels;
  for (std::size_t c = 0; c < cuts_.size(); ++c) {
    const double beyond_mm = cuts_[c].is_bounded() ? cuts_[c].beyond_mm(point_mm) : -reach_mm - 1;
    if (beyond_mm < -reach_mm) continue;
    const bool has_object = std::ranges::any_of(labels, [&](Material m) { return is_meshed(m); });
    if (!has_object) continue;
    if (beyond_mm > reach_mm) {
      near = MaterialSet();
      for (const Material m : labels)
        if (!is_meshed(m)) near.insert(m);
    }
    near.insert(static_cast<Material>(labels_.size() + c));
  }
  return near;
}

/// As if there were no cut planes.
MaterialSet ImageDomain::labels_near(const Vec3& point_mm, double reach_mm) const {
  const Vec3 index = frame().to_index(point_mm);
  const LabelField::LabelIndex own = field_->label_at(index);
  MaterialSet near{own};
  // All labels share the wall against the background: which of them stands behind it here, the label's own
  // functions tell.
  const LabelField::LabelIndex object = own != 0 ? own : field_->object_label_at(index);
  const auto is_near = [&](LabelField::LabelIndex a, LabelField::LabelIndex b) {
    return std::abs(field_->difference_value(index, a, b)) * unit_mm_ <= reach_mm;
  };
  const bool wall_is_near = object != 0 && is_near(object, 0);
  for (const LabelField::LabelIndex m : field_->labels_near(index)) {
    if (m == 0        ? wall_is_near
        : m == object ? own != 0 || wall_is_near
                      : is_near(object, m) && (own != 0 || wall_is_near))
      near.insert(m);
  }
  return near;
}

bool ImageDomain::may_hold_object(const Vec3& low_mm, const Vec3& high_mm) const {
  const Vec3 middle = frame().to_index(0.5 * (low_mm + high_mm));
  const Vec3 reach = index_from_mm_.cwiseAbs() * (0.5 * (high_mm - low_mm));
  return field_->may_hold_object(middle - reach, middle + reach);
}

Box3 ImageDomain::bounds_mm() const {
  Box3 box;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 index;
    for (int axis = 0; axis < 3; ++axis)
      index[axis] = (corner >> axis & 1) != 0 ? object_box_.high[axis] + 0.5 : object_box_.low[axis] - 1.5;
    box.extend(frame().to_physical(index));
  }
  return box;
}

Label ImageDomain::label_at(const Vec3& point_mm) const {
  return label_of(material_at(point_mm));
}

FieldSample ImageDomain::separation(const Vec3& point_mm, Material first, Material second) const {
  // A cut plane lies between the material and the cut; between two cuts it is where they are equally far.
  if (is_cut(first) || is_cut(second)) {
    FieldSample result;
    if (is_cut(first)) {
      const CutPlane& plane = cut_plane(first);
      result.value += plane.height(point_mm);
      result.gradient += plane.normal;
    }
    if (is_cut(second)) {
      const CutPlane& plane = cut_plane(second);
      result.value -= plane.height(point_mm);
      result.gradient -= plane.normal;
    }
    return result;
  }
  const FieldSample in_voxels =
      field_->difference(frame().to_index(point_mm), static_cast<LabelImage::Index>(first),
                         static_cast<LabelImage::Index>(second));
  return {in_voxels.value * unit_mm_, index_from_mm_.transpose() * in_voxels.gradient * unit_mm_};
}

double ImageDomain::separation_value(const Vec3& point_mm, Material first, Material second) const {
  if (is_cut(first) || is_cut(second)) return separation(point_mm, first, second).value;
  return unit_mm_ * field_->difference_value(frame().to_index(point_mm),
                                             static_cast<LabelField::LabelIndex>(first),
                                             static_cast<LabelField::LabelIndex>(second));
}

std::optional<Vec3> ImageDomain::project(const Vec3& start_mm, const MaterialSet& set,
                                         double reach_mm) const {
  return descend(*this, start_mm, set, {reach_mm, voxel_size_mm_, 2e-3 * voxel_size_mm_});
}

std::optional<Vec3> ImageDomain::first_crossing(const Vec3& from_mm, const Vec3& to_mm) const {
  const double length = (to_mm - from_mm).norm();
  const int steps = std::max(1, static_cast<int>(std::ceil(length / (0.5 * frame().spacing_mm.minCoeff()))));
  const Material start = material_at(from_mm);
  Vec3 low = from_mm;
  for (int s = 1; s <= steps; ++s) {
    Vec3 high = from_mm + (to_mm - from_mm) * (static_cast<double>(s) / steps);
    if (material_at(high) == start) {
      low = high;
      continue;
    }
    for (int i = 0; i < 30; ++i) {
      const Vec3 middle = 0.5 * (low + high);
      (material_at(middle) == start ? low : high) = middle;
    }
    return Vec3(0.5 * (low + high));
  }
  return std::nullopt;
}

}  // namespace lumesh
