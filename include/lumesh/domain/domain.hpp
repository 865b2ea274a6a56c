#pragma once
/// @file The domain oracle: where each material is, where their boundaries run, and the planes that cut them
/// off.

#include <algorithm>
#include <array>
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/field/field_options.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

struct CarriedSection;

/// Index of a material: 0 is the background, then the labels that are meshed, then other parts of the
/// outside, whose boundaries with the labels are patches of their own (openings, such as cut planes).
using Material = std::uint32_t;

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

/// A part of a closed surface where a vessel was cut off.
struct FlatEnd {
  std::string name;  ///< Name of its patch.
  double area_mm2 = 0;
  Vec3 centre_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< Unit, out of the object.
  Box3 box_mm;
  std::vector<std::array<Vec3, 3>> triangles_mm;  ///< Corners of its triangles.
};

/// A plane that cuts the object off: what lies on the side of the normal is removed. With a radius and a
/// depth it removes only what of the object lies in the cylinder that stands on the plane, so that it cuts
/// one vessel.
struct CutPlane {
  Vec3 point_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< Need not be of unit length but with a radius, must not be zero.
  double radius_mm = std::numeric_limits<double>::infinity();  ///< Around the point.
  double depth_mm = std::numeric_limits<double>::infinity();   ///< From the plane along the normal.
  /// Instead of the cylinder, where an extended vessel ends: what has been carried there.
  std::shared_ptr<const CarriedSection> section = nullptr;
  /// Names that the openings in it have, by falling area of each label; others are named by their areas.
  std::vector<std::pair<Label, std::string>> names = {};

  [[nodiscard]] bool is_bounded() const { return radius_mm < std::numeric_limits<double>::infinity(); }
  /// How far a point is beyond the plane; in mm where the normal is of unit length.
  [[nodiscard]] double height(const Vec3& x) const { return normal.dot(x - point_mm); }
  /// How deep a point is within what is removed; negative outside. The normal is of unit length.
  [[nodiscard]] double beyond_mm(const Vec3& x) const;
};

/// The point, or one on the planes that it lies beyond; their normals are of unit length.
[[nodiscard]] Vec3 nearest_within(std::span<const CutPlane> planes, Vec3 point_mm);

/// Space divided into materials, in mm. Const calls from any thread; most cost well under a microsecond.
class Domain {
 public:
  Domain() = default;
  Domain(const Domain&) = default;
  Domain(Domain&&) = default;
  Domain& operator=(const Domain&) = default;
  Domain& operator=(Domain&&) = default;
  virtual ~Domain() = default;

  /// The material at a point and a distance within which it does not change (a cautious estimate).
  struct Surroundings {
    Material material = 0;
    double clearance_mm = 0;
  };
  [[nodiscard]] virtual Surroundings surroundings(const Vec3& point_mm) const = 0;
  /// The largest clearance that surroundings() can tell; infinite if any.
  [[nodiscard]] virtual double clearance_limit_mm() const = 0;
  /// Material at the point, and those with a boundary to it that is about `reach_mm` near.
  [[nodiscard]] virtual MaterialSet materials_near(const Vec3& point_mm, double reach_mm) const = 0;
  /// The place near `start_mm` where all materials of the set meet: a surface for two, a curve for three, a
  /// point for four. None if the descent does not arrive within `reach_mm`.
  [[nodiscard]] virtual std::optional<Vec3> project(const Vec3& start_mm, const MaterialSet& set,
                                                    double reach_mm) const = 0;
  /// Signed function of the boundary between two materials, about the distance in mm near it, > 0 on the side
  /// of `first`, and its gradient (per mm).
  [[nodiscard]] virtual FieldSample separation(const Vec3& point_mm, Material first,
                                               Material second) const = 0;
  /// Its value alone.
  [[nodiscard]] virtual double separation_value(const Vec3& point_mm, Material first, Material second) const {
    return separation(point_mm, first, second).value;
  }
  /// False only if nothing in the box between two corners is meshed.
  [[nodiscard]] virtual bool may_hold_object(const Vec3& low_mm, const Vec3& high_mm) const = 0;
  /// A box around all that is meshed.
  [[nodiscard]] virtual Box3 bounds_mm() const = 0;
  /// Size of what the boundary is known by: the voxel of an image.
  [[nodiscard]] virtual double resolution_mm() const = 0;
  /// The same along a unit vector, where it is not the same in all directions; and the least of these.
  [[nodiscard]] virtual double resolution_along_mm(const Vec3& /*direction*/) const {
    return resolution_mm();
  }
  [[nodiscard]] virtual double finest_resolution_mm() const { return resolution_mm(); }

  /// The material alone, which may be quicker.
  [[nodiscard]] virtual Material material_at(const Vec3& point_mm) const {
    return surroundings(point_mm).material;
  }
  [[nodiscard]] virtual Label label_of(Material m) const = 0;
  /// Names that the input gives to labels; may be empty or partial.
  [[nodiscard]] virtual std::map<Label, std::string> label_names() const { return {}; }
  /// Number of the labels with the background; materials from there on are openings.
  [[nodiscard]] virtual Material label_count() const = 0;
  [[nodiscard]] virtual Material material_count() const = 0;
  /// The meshed material that has a label; none if the domain has no such label.
  [[nodiscard]] std::optional<Material> material_of(Label label) const;
  /// The patch that the boundary between two materials is, if the domain knows; several boundaries may have
  /// patches of one name. None: see name_patches().
  [[nodiscard]] virtual std::optional<Patch> patch_between(Material /*inside*/, Material /*outside*/) const {
    return std::nullopt;
  }
  /// Points of boundaries that are to be vertices of meshes, in the order of precedes(); none unless asked
  /// for.
  [[nodiscard]] virtual std::span<const Vec3> fixed_points() const { return {}; }
  [[nodiscard]] bool is_fixed(const Vec3& point_mm) const;
  /// Flat ends of a closed surface, by falling area; none of other domains, which have cut_planes().
  [[nodiscard]] virtual std::span<const FlatEnd> flat_ends() const { return {}; }
  /// Radius of the circle with the area of the flat end that a material lies beyond; infinite for others.
  [[nodiscard]] virtual double end_radius_mm(Material /*m*/) const {
    return std::numeric_limits<double>::infinity();
  }
  /// Planes that cut the object off, unit normals; none where openings are no planes. Else the materials from
  /// label_count() on are what lies beyond each.
  [[nodiscard]] virtual std::span<const CutPlane> cut_planes() const { return {}; }
  /// The plane that a material which is_cut() lies beyond; only where there are cut planes.
  [[nodiscard]] const CutPlane& cut_plane(Material m) const { return cut_planes()[m - label_count()]; }
  /// Material beyond one of cut_planes(), by its number.
  [[nodiscard]] Material material_beyond(std::size_t cut) const {
    return static_cast<Material>(label_count() + cut);
  }
  /// How far a point lies beyond the cut plane that it is farthest beyond; negative within all.
  [[nodiscard]] double beyond_cuts_mm(const Vec3& point_mm) const {
    double farthest_mm = -std::numeric_limits<double>::infinity();
    for (const CutPlane& plane : cut_planes()) farthest_mm = std::max(farthest_mm, plane.beyond_mm(point_mm));
    return farthest_mm;
  }
  /// Whether a cut plane removes the point.
  [[nodiscard]] bool beyond_cut(const Vec3& point_mm) const { return beyond_cuts_mm(point_mm) > 0; }
  /// The point, or one on the cut planes that it lies beyond.
  [[nodiscard]] Vec3 within_cuts(const Vec3& point_mm) const {
    return nearest_within(cut_planes(), point_mm);
  }
  /// True for materials that the mesh is made of.
  [[nodiscard]] bool is_meshed(Material m) const { return m > 0 && m < label_count(); }
  [[nodiscard]] bool is_cut(Material m) const { return m >= label_count(); }
  /// True for what lies beyond an opening. Closed surfaces in several regions know walls among their outer
  /// materials.
  [[nodiscard]] virtual bool is_beyond_opening(Material m) const { return is_cut(m); }
};

}  // namespace lumesh
