#pragma once
/// @file The domain oracle of a closed surface of triangles, with its sharp edges and corners.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// Triangles that somebody else owns, such as those of a file that read_mesh() has read.
struct SurfaceView {
  std::span<const Vec3> points;             ///< In mm.
  std::span<const Cell<3>> triangles;       ///< May be turned either way.
  std::span<const std::int32_t> patches{};  ///< One per triangle, or none.
  /// Name and kind of the patches; may have fewer. Openings without a name are numbered with the flat ends.
  std::span<const Patch> patch_info{};
  /// Resolution of the domain; 0: by the mean length of the edges and the box's diagonal.
  double resolution_mm = 0;
};

class OptionList;

/// Angle between triangles above which an edge is sharp, where none is given.
inline constexpr double kUsualFeatureAngleDeg = 40;

struct SurfaceDomainOptions {
  double feature_angle_deg =
      kUsualFeatureAngleDeg;   ///< Edges whose triangles' normals differ by more are kept; (0, 180].
  bool keep_vertices = false;  ///< The surface's vertices are fixed_points().

  void describe(OptionList& list);
  void validate() const;  ///< Throws Error{kUsage}, naming the field.
};

/// The inside of a closed surface is label 1; several shells may lie beside or within one another.
///
/// Sharp edges, and edges between patches of the file, divide the surface into regions. What is outside
/// belongs to the region nearest to it: each region has its own material outside, the largest region the
/// background, the others openings. So a sharp edge is where the label and two others meet, a corner where
/// there are more. Regions of at most four triangles and 0.2 % of the area join a neighbour: scanned surfaces
/// have such specks. Not kept are creases that end within a region, and the tips of cones.
///
/// The surface must not cut itself; that is not checked.
class SurfaceDomain final : public Domain {
 public:
  /// Copies what it needs. Equal points count as one, and triangles with equal corners as none.
  /// @throws Error{kBadInput}, which names the place, if the surface is empty, open, not a manifold, of one
  /// side only, or has points that are not finite; Error{kUsage} for options.
  /// Parallel inside, the same for every thread count. Cost: about 20 us per triangle. Memory: about 600
  /// bytes per triangle.
  explicit SurfaceDomain(const SurfaceView& surface, const SurfaceDomainOptions& options = {});

  /// The clearance is the distance to the surface, or at least 0.9 of it; other borders of outer materials do
  /// not count. Cost: about 0.1 us far from the surface, 1 us near it.
  [[nodiscard]] Surroundings surroundings(const Vec3& point_mm) const override;
  [[nodiscard]] Material material_at(const Vec3& point_mm) const override;
  [[nodiscard]] double clearance_limit_mm() const override;
  [[nodiscard]] MaterialSet materials_near(const Vec3& point_mm, double reach_mm) const override;
  /// The nearest place, exactly: of a region for the label and one outer material, of the edges between two
  /// regions for two of them, of the vertices where more meet.
  [[nodiscard]] std::optional<Vec3> project(const Vec3& start_mm, const MaterialSet& set,
                                            double reach_mm) const override;
  /// Between the label and an outer material: the distance to that region, > 0 on the side of the first.
  /// Between outer ones: the difference of the distances to their regions; where both are nearest in the same
  /// place, that of the heights over their planes.
  [[nodiscard]] FieldSample separation(const Vec3& point_mm, Material first, Material second) const override;
  [[nodiscard]] bool may_hold_object(const Vec3& low_mm, const Vec3& high_mm) const override;
  [[nodiscard]] Box3 bounds_mm() const override;
  /// Unless it was given, half the mean length of the edges, at most 1/128 of the diagonal of bounds_mm().
  [[nodiscard]] double resolution_mm() const override;
  [[nodiscard]] Label label_of(Material m) const override { return m == kInside ? 1 : kBackground; }
  [[nodiscard]] Material label_count() const override { return 2; }
  [[nodiscard]] Material material_count() const override { return region_count() + 1; }
  /// Patches of the file if it has several, else "inlet_1", "outlet_1", … for flat ends, by falling area, and
  /// "wall" for the rest; none for a surface of one region only.
  [[nodiscard]] std::optional<Patch> patch_between(Material inside, Material outside) const override;

  /// Regions in one plane, within 5 % of their radius, that end at one closed curve on bent regions. Where
  /// the file has several patches, those are ends that are one such region, but for those called wall.
  [[nodiscard]] std::span<const FlatEnd> flat_ends() const override;
  [[nodiscard]] double end_radius_mm(Material m) const override;
  [[nodiscard]] bool is_beyond_opening(Material m) const override;
  [[nodiscard]] std::span<const Vec3> fixed_points() const override;

  /// Lines on patches of the file that are hardly what they were meant for: ends taken for wall because a few
  /// bent triangles belong to them, ends of one name.
  [[nodiscard]] std::span<const std::string> patch_notes() const;
  [[nodiscard]] std::uint32_t region_count() const;
  /// Sum of the regions' areas, and what they enclose.
  [[nodiscard]] double area_mm2() const;
  [[nodiscard]] double volume_mm3() const;

 private:
  static constexpr Material kInside = 1;
  struct Parts;
  std::shared_ptr<const Parts> parts_;  // Never changed.
};

}  // namespace lumesh
