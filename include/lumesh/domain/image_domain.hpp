#pragma once
/// @file The domain oracle of a segmented image: where each material is, and where their boundaries run.

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/field/field_options.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

class LabelField;

/// The box around a box in mm (LPS), in voxel indices of a frame.
[[nodiscard]] Box3 voxel_box(const ImageFrame& frame, const Box3& box_mm);

struct ImageDomainOptions {
  LabelFieldOptions field;
  std::vector<CutPlane> cut_planes;
};

/// Answers in physical mm (LPS). Where the object touches the image border a cut plane at the voxels' outer
/// faces ends it, and so do the planes of the options; up to there, vessels go on in their own direction.
/// Const calls from any thread; most cost well under a microsecond.
class ImageDomain final : public Domain {
 public:
  /// The domain of an image, whose field is made first: parallel inside, bitwise identical for every thread
  /// count. @throws Error{kUsage} for a cut plane whose normal is zero or not finite, and what LabelField
  /// throws.
  ImageDomain(const LabelImage& image, const ImageDomainOptions& options);
  /// The domain of an image with a field that is known. @param cuts  Planes beside those at the image's
  /// border.
  /// @throws Error{kUsage} as the other constructor.
  ImageDomain(const LabelImage& image, LabelField field, const std::vector<CutPlane>& cuts);

  [[nodiscard]] Surroundings surroundings(const Vec3& point_mm) const override;
  [[nodiscard]] Material material_at(const Vec3& point_mm) const override;
  [[nodiscard]] double clearance_limit_mm() const override;
  [[nodiscard]] MaterialSet materials_near(const Vec3& point_mm, double reach_mm) const override;
  [[nodiscard]] bool may_hold_object(const Vec3& low_mm, const Vec3& high_mm) const override;
  [[nodiscard]] Box3 bounds_mm() const override;
  [[nodiscard]] double resolution_mm() const override { return voxel_size_mm_; }
  [[nodiscard]] double resolution_along_mm(const Vec3& direction) const override {
    return frame().thickness_along_mm(direction);
  }
  [[nodiscard]] double finest_resolution_mm() const override { return frame().spacing_mm.minCoeff(); }
  /// Label of the mesh at a point; the background beyond a cut plane.
  [[nodiscard]] Label label_at(const Vec3& point_mm) const;
  /// First place along the segment where the material changes, found by steps of half a voxel and bisection.
  [[nodiscard]] std::optional<Vec3> first_crossing(const Vec3& from_mm, const Vec3& to_mm) const;

  [[nodiscard]] FieldSample separation(const Vec3& point_mm, Material first, Material second) const override;
  [[nodiscard]] double separation_value(const Vec3& point_mm, Material first, Material second) const override;
  [[nodiscard]] std::optional<Vec3> project(const Vec3& start_mm, const MaterialSet& set,
                                            double reach_mm) const override;

  [[nodiscard]] Label label_of(Material m) const override {
    return m < labels_.size() ? labels_[m] : kBackground;
  }
  [[nodiscard]] std::map<Label, std::string> label_names() const override { return label_names_; }
  [[nodiscard]] Material label_count() const override { return static_cast<Material>(labels_.size()); }
  [[nodiscard]] Material material_count() const override {
    return static_cast<Material>(labels_.size() + cuts_.size());
  }
  /// Cut planes asked for, and the image's borders where the object touches them; unit normals.
  [[nodiscard]] std::span<const CutPlane> cut_planes() const override { return cuts_; }
  /// Sets CutPlane::names of one of them.
  void name_openings(std::size_t cut, std::vector<std::pair<Label, std::string>> names) {
    cuts_[cut].names = std::move(names);
  }
  [[nodiscard]] const LabelField& field() const { return *field_; }
  [[nodiscard]] const ImageFrame& frame() const;
  /// Geometric mean of the voxel's edges.
  [[nodiscard]] double voxel_size_mm() const { return voxel_size_mm_; }
  /// The box of all voxels that are not background.
  [[nodiscard]] const VoxelBox& object_box() const { return object_box_; }

 private:
  /// The cut plane, of those with or without a bound, that the point is furthest beyond, or nearest to; how
  /// far, in mm. None without any.
  struct CutDistance {
    std::size_t cut = 0;
    double beyond_mm = -1e300;
  };
  [[nodiscard]] CutDistance furthest_cut(const Vec3& point_mm, bool is_bounded) const;
  [[nodiscard]] MaterialSet labels_near(const Vec3& point_mm, double reach_mm) const;
  [[nodiscard]] MaterialSet with_stumps(const MaterialSet& labels, const Vec3& point_mm,
                                        double reach_mm) const;
  void add_cuts(const std::vector<CutPlane>& cuts);
  void add_border_cuts(const LabelImage& image);

  std::shared_ptr<const LabelField> field_;  // Never null.
  std::vector<Label> labels_;
  std::map<Label, std::string> label_names_;
  std::vector<CutPlane> cuts_;  // unit normals
  bool has_bounded_cuts_ = false;
  Mat3 index_from_mm_ = Mat3::Identity();
  double voxel_size_mm_ = 1;
  double unit_mm_ = 1;  // of the field: the smallest edge of a voxel
  VoxelBox object_box_;
};

/// Voxels of each label (in the order of image.values(), 0 for the background) on the kept side of all
/// planes. Voxels that a plane passes through count by their share, taken as linear in the plane's place.
[[nodiscard]] std::vector<double> count_kept_voxels(const LabelImage& image,
                                                    std::span<const CutPlane> planes);

}  // namespace lumesh
