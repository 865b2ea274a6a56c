#pragma once
/// @file The domain oracle of a segmented image: where each material is, and where their boundaries run.

#include <algorithm>
#include <array>
#include <initializer_list>
#include <optional>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/domain/cut_plane.hpp"
#include "lumesh/image/label_field.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// Index of a material: 0 is the background, then the image's labels (index into values()), then the cut
/// planes.
using Material = std::uint32_t;

struct ImageDomainOptions {
  LabelFieldOptions field;
  std::vector<CutPlane> cut_planes;
};

/// A small set of different materials, ascending.
class MaterialSet {
 public:
  static constexpr std::size_t kCapacity = 6;

  MaterialSet() = default;
  MaterialSet(std::initializer_list<Material> materials) {
    for (const Material m : materials) insert(m);
  }

  /// Adds a material; ignored once the set is full (such a place is a corner anyway).
  void insert(Material m) {
    std::size_t at = 0;
    while (at < size_ && items_[at] < m) ++at;
    if ((at < size_ && items_[at] == m) || size_ == kCapacity) return;
    for (std::size_t i = size_; i > at; --i) items_[i] = items_[i - 1];
    items_[at] = m;
    ++size_;
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] Material operator[](std::size_t i) const { return items_[i]; }
  [[nodiscard]] const Material* begin() const { return items_.data(); }
  [[nodiscard]] const Material* end() const { return items_.data() + size_; }
  [[nodiscard]] bool contains(Material m) const {
    for (const Material item : *this) {
      if (item == m) return true;
    }
    return false;
  }
  [[nodiscard]] bool contains_all(const MaterialSet& other) const {
    for (const Material item : other) {
      if (!contains(item)) return false;
    }
    return true;
  }
  friend bool operator==(const MaterialSet& a, const MaterialSet& b) {
    return a.size_ == b.size_ && std::equal(a.begin(), a.end(), b.begin());
  }

 private:
  std::array<Material, kCapacity> items_ = {};
  std::size_t size_ = 0;
};

/// A place on a boundary.
struct BoundaryPoint {
  Vec3 position_mm = Vec3::Zero();
  Vec3 normal = Vec3::Zero();                  ///< Unit; points from `inside` to `outside`.
  std::array<Material, 2> materials = {0, 0};  ///< inside, outside; two materials name the patch.
};

/// Answers in physical mm (LPS). Outside the image the border voxels go on for ever; where the object touches
/// the image border a cut plane at the voxels' outer faces ends it, and so do the planes of the options.
/// Const calls from any thread; most cost well under a microsecond.
class ImageDomain {
 public:
  /// Throws Error{kUsage} for a cut plane without normal.
  ImageDomain(const LabelImage& image, const ImageDomainOptions& options);

  [[nodiscard]] Material material_at(const Vec3& point_mm) const;
  /// The material at a point and a distance within which it does not change (a cautious estimate).
  struct Surroundings {
    Material material = 0;
    double clearance_mm = 0;
  };
  [[nodiscard]] Surroundings surroundings(const Vec3& point_mm) const;
  /// Label of the mesh at a point; the background beyond a cut plane.
  [[nodiscard]] Label label_at(const Vec3& point_mm) const;
  /// First place along the segment where the material changes, found by steps of half a voxel and bisection.
  [[nodiscard]] std::optional<Vec3> first_crossing(const Vec3& from_mm, const Vec3& to_mm) const;
  /// Nearest boundary point by descent from the given place; none if no boundary is within the field's reach
  /// (three voxels).
  [[nodiscard]] std::optional<BoundaryPoint> nearest_boundary(const Vec3& point_mm) const;

  /// Signed function of the boundary between two materials, about the distance in mm near it, > 0 on the side
  /// of `first`, and its gradient (per mm).
  [[nodiscard]] FieldSample separation(const Vec3& point_mm, Material first, Material second) const;
  /// The place near `start_mm` where all materials of the set meet: a surface for two, a curve for three, a
  /// point for four. None if the descent does not arrive within `reach_mm`.
  [[nodiscard]] std::optional<Vec3> project(const Vec3& start_mm, const MaterialSet& set,
                                            double reach_mm) const;

  /// Whether a cut plane (of the image border or of the options) removes the point.
  [[nodiscard]] bool beyond_cut(const Vec3& point_mm) const {
    return std::any_of(cuts_.begin(), cuts_.end(),
                       [&](const CutPlane& c) { return c.normal.dot(point_mm - c.point_mm) > 0; });
  }
  [[nodiscard]] Label label_of(Material m) const { return m < labels_.size() ? labels_[m] : kBackground; }
  [[nodiscard]] bool is_cut(Material m) const { return m >= labels_.size(); }
  /// True for materials that the mesh is made of.
  [[nodiscard]] bool is_meshed(Material m) const { return m > 0 && m < labels_.size(); }
  /// Number of the image's labels with the background; materials from there on are cut planes.
  [[nodiscard]] Material label_count() const { return static_cast<Material>(labels_.size()); }
  [[nodiscard]] Material material_count() const {
    return static_cast<Material>(labels_.size() + cuts_.size());
  }
  /// Those asked for and the image's borders where the object touches them; unit normals.
  [[nodiscard]] std::span<const CutPlane> cut_planes() const { return cuts_; }
  [[nodiscard]] const CutPlane& cut_plane(Material m) const { return cuts_[m - labels_.size()]; }
  [[nodiscard]] const LabelField& field() const { return field_; }
  [[nodiscard]] const ImageFrame& frame() const { return field_.frame(); }
  /// Geometric mean of the voxel's edges.
  [[nodiscard]] double voxel_size_mm() const { return voxel_size_mm_; }
  /// Index box (inclusive) of all voxels that are not background.
  [[nodiscard]] std::array<Index3, 2> object_box() const { return object_box_; }

 private:
  [[nodiscard]] Vec3 newton_step(const Vec3& x, const MaterialSet& set) const;
  void find_object_box(const LabelImage& image);
  void add_border_cuts(const LabelImage& image);

  LabelField field_;
  std::vector<Label> labels_;
  std::vector<CutPlane> cuts_;  // unit normals
  Mat3 index_from_mm_ = Mat3::Identity();
  double voxel_size_mm_ = 1;
  std::array<Index3, 2> object_box_ = {Index3::Zero(), Index3::Zero()};
};

}  // namespace lumesh
