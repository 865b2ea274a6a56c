#include "lumesh/domain/surface_domain.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "closed_surface.hpp"
#include "distance_octree.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/parallel/loops.hpp"
#include "named_regions.hpp"
#include "surface_projector.hpp"

namespace lumesh {

using surfaces::ClosedSurface;
using surfaces::ClosestPoint;
using surfaces::DistanceCell;
using surfaces::DistanceOctree;
using surfaces::FeatureRegions;
using surfaces::NamedRegions;
using surfaces::RegionBorders;
using surfaces::SurfaceProjector;

namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

/// Regions outside: the background is that of the first, the label lies between it and the others.
std::uint32_t region_of(Material m) {
  return m == 0 ? 0 : m - 1;
}
Material material_over(std::uint32_t region) {
  return region == 0 ? 0 : region + 1;
}

/// Cubes as large as a few triangles, within what memory allows.
double min_cube(const NamedRegions& surface) {
  constexpr double kMax = 128, kFewest = 16;  // Cubes along the box.
  const double length = surface.box.sizes().maxCoeff();
  return std::clamp(2 * surface.mean_edge_mm, length / kMax, length / kFewest);
}

}  // namespace

struct SurfaceDomain::Parts {
  Parts(const SurfaceView& view, const SurfaceDomainOptions& options)
      : named(view, options),
        borders(surface, regions),
        projector(surface, regions),
        octree(projector, regions.count(), box, min_cube(named)) {
    if (!options.keep_vertices) return;
    fixed_points = surface.points;
    parallel::sort(fixed_points.begin(), fixed_points.end(), precedes);
  }

  /// The closest point to x, quicker with the triangle that a cube of the octree knows.
  [[nodiscard]] ClosestPoint closest_point(const Vec3& x, const DistanceOctree::Found& found) const {
    return found.cell != nullptr ? projector.nearest(x, found.cell->triangle) : projector.nearest(x);
  }
  [[nodiscard]] Material material(const Vec3& x, const DistanceOctree::Found& found,
                                  const ClosestPoint& closest) const {
    return is_inside(x, found, closest) ? kInside : material_over(projector.region_over(x, closest));
  }
  /// Side of the surface. That of the octree goes before the closest point's, whose normal may mislead.
  [[nodiscard]] bool is_inside(const Vec3& x, const DistanceOctree::Found& found,
                               const ClosestPoint& closest) const {
    if (found.cell == nullptr) return false;
    return found.min_distance() > 0 ? found.cell->distance > 0 : projector.is_inside(x, closest);
  }
  /// Without looking at triangles, if x is far enough from the surface and from other regions.
  [[nodiscard]] std::optional<Material> known_material(const DistanceOctree::Found& found) const {
    if (found.cell == nullptr) return regions.count() == 1 ? std::optional<Material>(0) : std::nullopt;
    if (found.min_distance() <= 0) return std::nullopt;
    if (found.cell->distance > 0) return kInside;
    if (regions.count() == 1) return 0;
    if (found.cell->region == DistanceCell::kMixed) return std::nullopt;
    return material_over(found.cell->region);
  }

  NamedRegions named;
  const ClosedSurface& surface = named.surface;
  const FeatureRegions& regions = named.regions;
  const Box3& box = named.box;
  RegionBorders borders;
  SurfaceProjector projector;
  DistanceOctree octree;
  std::vector<Vec3> fixed_points;
};

SurfaceDomain::SurfaceDomain(const SurfaceView& surface, const SurfaceDomainOptions& options) {
  options.validate();
  parts_ = std::make_shared<const Parts>(surface, options);
}

Domain::Surroundings SurfaceDomain::surroundings(const Vec3& point_mm) const {
  constexpr double kMin = 0.9;  // Of the distance.
  const DistanceOctree::Found found = parts_->octree.find(point_mm);
  const std::optional<Material> known = parts_->known_material(found);
  if (known && found.cell != nullptr) {
    const std::uint32_t guess = found.cell->triangle;
    const double least = found.min_distance();
    if (least >= kMin * parts_->projector.distance_to_triangle(point_mm, guess)) return {*known, least};
    return {*known, kMin * parts_->projector.nearly_nearest(point_mm, guess, 1 - kMin).distance};
  }
  const ClosestPoint closest = parts_->closest_point(point_mm, found);
  return {known ? *known : parts_->material(point_mm, found, closest), closest.distance};
}

Material SurfaceDomain::material_at(const Vec3& point_mm) const {
  const DistanceOctree::Found found = parts_->octree.find(point_mm);
  if (const auto known = parts_->known_material(found)) return *known;
  return parts_->material(point_mm, found, parts_->closest_point(point_mm, found));
}

double SurfaceDomain::clearance_limit_mm() const {
  return kUnbounded;
}

MaterialSet SurfaceDomain::materials_near(const Vec3& point_mm, double reach_mm) const {
  const DistanceOctree::Found found = parts_->octree.find(point_mm);
  const std::optional<Material> known = parts_->known_material(found);
  if (known && found.cell != nullptr && found.min_distance() > reach_mm) return {*known};
  const ClosestPoint closest = parts_->closest_point(point_mm, found);
  MaterialSet near{known ? *known : parts_->material(point_mm, found, closest)};
  if (closest.distance > reach_mm) return near;
  // The nearest first, in case there are more than the set can hold.
  const std::uint32_t nearest = parts_->regions.of_triangle[closest.triangle];
  near.insert(kInside);
  near.insert(material_over(nearest));
  for (std::uint32_t r = 0; r < parts_->regions.count() && near.size() < MaterialSet::kCapacity; ++r)
    if (r != nearest &&
        parts_->projector.nearest_of_region(point_mm, r, reach_mm).triangle != TriangleTree::kNone)
      near.insert(material_over(r));
  return near;
}

std::optional<Vec3> SurfaceDomain::project(const Vec3& start_mm, const MaterialSet& set,
                                           double reach_mm) const {
  std::array<std::uint32_t, MaterialSet::kCapacity> regions{};
  std::size_t count = 0;
  for (const Material m : set)
    if (m != kInside) regions[count++] = region_of(m);
  if (count == 0) return std::nullopt;
  if (count > 1) return parts_->borders.nearest(start_mm, std::span(regions.data(), count), reach_mm);
  const ClosestPoint closest = parts_->projector.nearest_of_region(start_mm, regions[0], reach_mm);
  if (closest.triangle == TriangleTree::kNone) return std::nullopt;
  return closest.point;
}

FieldSample SurfaceDomain::separation(const Vec3& point_mm, Material first, Material second) const {
  const SurfaceProjector& projector = parts_->projector;
  // So near to the surface, the way to the closest point is rounding.
  const double on_surface_mm = 1e-9 * parts_->named.resolution_mm;
  if (first == kInside || second == kInside) {
    const ClosestPoint closest =
        projector.nearest_of_region(point_mm, region_of(first == kInside ? second : first));
    const bool is_inside = material_at(point_mm) == kInside;
    const double side = is_inside ? -1 : 1;
    const Vec3 outwards = closest.distance > on_surface_mm
                              ? Vec3(side * (point_mm - closest.point) / closest.distance)
                              : parts_->surface.normals[closest.triangle];
    const double sign = first == kInside ? -1 : 1;
    return {sign * side * closest.distance, sign * outwards};
  }
  const ClosestPoint one = projector.nearest_of_region(point_mm, region_of(first));
  const ClosestPoint other = projector.nearest_of_region(point_mm, region_of(second));
  const Vec3 normals = parts_->surface.normals[one.triangle] - parts_->surface.normals[other.triangle];
  if ((one.point - other.point).norm() <= on_surface_mm) return {normals.dot(point_mm - one.point), normals};
  const auto away = [&](const ClosestPoint& closest) {
    return closest.distance > on_surface_mm ? Vec3((point_mm - closest.point) / closest.distance)
                                            : parts_->surface.normals[closest.triangle];
  };
  return {other.distance - one.distance, away(other) - away(one)};
}

bool SurfaceDomain::may_hold_object(const Vec3& low_mm, const Vec3& high_mm) const {
  if (!Box3(low_mm, high_mm).intersects(parts_->box)) return false;
  const Surroundings middle = surroundings(0.5 * (low_mm + high_mm));
  return middle.material == kInside || middle.clearance_mm <= 0.5 * (high_mm - low_mm).norm();
}

Box3 SurfaceDomain::bounds_mm() const {
  return parts_->box;
}

double SurfaceDomain::resolution_mm() const {
  return parts_->named.resolution_mm;
}

std::optional<Patch> SurfaceDomain::patch_between(Material inside, Material outside) const {
  if (inside == outside || (inside != kInside && outside != kInside)) return std::nullopt;
  const std::uint32_t region = region_of(inside == kInside ? outside : inside);
  if (!parts_->named.has_named_patches && parts_->regions.count() == 1) return std::nullopt;
  return parts_->named.of_region[region];
}

bool SurfaceDomain::is_beyond_opening(Material m) const {
  return m != kInside && parts_->named.of_region[region_of(m)].kind == PatchKind::kOpening;
}

std::span<const FlatEnd> SurfaceDomain::flat_ends() const {
  return parts_->named.ends;
}

double SurfaceDomain::end_radius_mm(Material m) const {
  return is_beyond_opening(m) ? circle_radius(parts_->regions.areas_mm2[region_of(m)]) : kUnbounded;
}

std::span<const Vec3> SurfaceDomain::fixed_points() const {
  return parts_->fixed_points;
}

std::span<const std::string> SurfaceDomain::patch_notes() const {
  return parts_->named.notes;
}

std::uint32_t SurfaceDomain::region_count() const {
  return parts_->regions.count();
}

double SurfaceDomain::area_mm2() const {
  double sum = 0;
  for (const double area : parts_->regions.areas_mm2) sum += area;
  return sum;
}

double SurfaceDomain::volume_mm3() const {
  double sum = 0;
  const auto count = static_cast<std::uint32_t>(parts_->surface.triangles.size());
  for (std::uint32_t t = 0; t < count; ++t)
    sum += surfaces::six_volumes(parts_->surface, t, parts_->box.center());
  return sum / 6;
}

}  // namespace lumesh
