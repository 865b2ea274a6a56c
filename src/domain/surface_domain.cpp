#include "lumesh/domain/surface_domain.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "closed_surface.hpp"
#include "distance_octree.hpp"
#include "feature_regions.hpp"
#include "flat_regions.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/parallel/loops.hpp"
#include "opening_names.hpp"
#include "surface_projector.hpp"

namespace lumesh {

using surfaces::ClosedSurface;
using surfaces::ClosestPoint;
using surfaces::DistanceCell;
using surfaces::DistanceOctree;
using surfaces::FeatureRegions;
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

double mean_edge(const ClosedSurface& surface) {
  double sum = 0;
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) sum += (surface.corner(t, (i + 1) % 3) - surface.corner(t, i)).norm();
  return sum / static_cast<double>(3 * surface.triangles.size());
}

/// Cubes as large as a few triangles, within what memory allows.
double min_cube(const ClosedSurface& surface, const Box3& box) {
  constexpr double kMax = 128, kFewest = 16;  // Cubes along the box.
  const double length = box.sizes().maxCoeff();
  return std::clamp(2 * mean_edge(surface), length / kMax, length / kFewest);
}

}  // namespace

void SurfaceDomainOptions::describe(OptionList& list) {
  list.number("feature_angle", feature_angle_deg, {.min = 0, .max = 180, .excludes_min = true},
              "Of a surface: edges where it turns by more are kept")
      .in("degrees");
  list.flag(
      "keep_vertices", keep_vertices,
      "Of a surface: its vertices are vertices of the mesh, exactly, but for those nearer to others than "
      "about 0.7 "
      "edge lengths");
}

void SurfaceDomainOptions::validate() const {
  require_ranges_of(*this);
}

struct SurfaceDomain::Parts {
  Parts(const SurfaceView& view, const SurfaceDomainOptions& options)
      : surface(surfaces::closed_surface(view)),
        regions(surfaces::find_regions(surface, options.feature_angle_deg)),
        borders(surface, regions),
        projector(surface, regions),
        box(bounding_box(surface.points)),
        octree(projector, regions.count(), box, min_cube(surface, box)),
        resolution_mm(std::min(0.5 * mean_edge(surface), box.diagonal().norm() / 128)) {
    patches.assign(view.patch_info.begin(), view.patch_info.end());
    std::set<std::int32_t> used(surface.patches.begin(), surface.patches.end());
    std::erase_if(used, [&](std::int32_t number) { return is_cap(patch_of_file(number)); });
    // One is left where cuts took the others: its name stays.
    const auto known =
        std::count_if(patches.begin(), patches.end(), [](const Patch& p) { return !is_cap(&p); });
    has_named_patches = used.size() > 1 || (used.size() == 1 && known > 1);
    name_regions();
    if (!options.keep_vertices) return;
    fixed_points = surface.points;
    parallel::sort(fixed_points.begin(), fixed_points.end(), precedes);
  }

  /// The patch of each region, and the ends among them.
  void name_regions() {
    const std::vector<surfaces::RegionShape> shapes = surfaces::region_shapes(surface, regions);
    // A patch of the file is an end if all of it is.
    std::map<std::int32_t, bool> is_flat_patch;
    std::map<std::int32_t, int> region_counts;
    for (std::uint32_t r = 0; r < regions.count(); ++r) {
      const auto [at, is_new] = is_flat_patch.try_emplace(regions.patches[r], true);
      at->second = at->second && shapes[r].is_flat_end;
      ++region_counts[regions.patches[r]];
    }
    for (std::uint32_t r = 0; r < regions.count(); ++r) {  // By falling area.
      Patch patch{"", PatchKind::kWall, {1, kBackground}};
      const Patch* const known = patch_of_file(regions.patches[r]);
      const bool is_end = shapes[r].is_flat_end || is_cap(known);
      if (is_cap(known) || (!has_named_patches && is_end)) {
        patch = {free_opening_name(), PatchKind::kOpening, {1, kBackground}};
      } else if (has_named_patches) {
        patch.name = name_of_file(r);
        const bool is_called_wall = patch.name.find("wall") != std::string::npos;
        const bool is_flat = is_flat_patch.at(regions.patches[r]) && !is_called_wall;
        if (is_flat || (known != nullptr && known->kind == PatchKind::kOpening))
          patch.kind = PatchKind::kOpening;
        keep_kind_of_file(r, patch);
      } else {
        patch.name = "wall";
      }
      const bool is_one_region = !has_named_patches || region_counts.at(regions.patches[r]) == 1;
      if (patch.kind == PatchKind::kOpening && is_end && is_one_region)
        ends.push_back(
            {patch.name, shapes[r].area_mm2, shapes[r].centre_mm, shapes[r].normal, shapes[r].box_mm});
      of_region.push_back(std::move(patch));
    }
  }
  /// What an open end was closed with: an opening that is to get its name here.
  [[nodiscard]] static bool is_cap(const Patch* patch) {
    return patch != nullptr && patch->kind == PatchKind::kOpening && patch->name.empty();
  }
  /// The next one that the file has not.
  [[nodiscard]] std::string free_opening_name() {
    for (;;) {
      std::string name = opening_name(named_openings++);
      if (!has_named_patches || std::none_of(patches.begin(), patches.end(),
                                             [&](const Patch& patch) { return patch.name == name; }))
        return name;
    }
  }
  [[nodiscard]] const Patch* patch_of_file(std::int32_t number) const {
    const bool is_known = number >= 0 && static_cast<std::size_t>(number) < patches.size();
    return is_known ? &patches[static_cast<std::size_t>(number)] : nullptr;
  }
  [[nodiscard]] std::string name_of_file(std::uint32_t region) const {
    const Patch* const known = patch_of_file(regions.patches[region]);
    return known != nullptr && !known->name.empty() ? known->name
                                                    : "patch_" + std::to_string(regions.patches[region]);
  }
  /// What only users say.
  void keep_kind_of_file(std::uint32_t region, Patch& patch) const {
    const Patch* const known = patch_of_file(regions.patches[region]);
    if (known == nullptr) return;
    if (known->kind == PatchKind::kSymmetry) patch.kind = PatchKind::kSymmetry;
    patch.flow = known->flow;
  }

  /// The closest point to x, quicker with the triangle that a cube of the octree knows.
  [[nodiscard]] ClosestPoint closest_point(const Vec3& x, const DistanceOctree::Found& found) const {
    return found.cell != nullptr ? projector.nearest(x, found.cell->triangle) : projector.nearest(x);
  }
  [[nodiscard]] Material material(const Vec3& x, const ClosestPoint& closest) const {
    return projector.is_inside(x, closest) ? kInside : material_over(projector.region_over(x, closest));
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

  ClosedSurface surface;
  FeatureRegions regions;
  RegionBorders borders;
  SurfaceProjector projector;
  Box3 box;
  DistanceOctree octree;
  double resolution_mm;
  std::vector<Patch> patches;
  bool has_named_patches = false;  // Several, without caps.
  std::size_t named_openings = 0;
  std::vector<Patch> of_region;
  std::vector<FlatEnd> ends;
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
  return {known ? *known : parts_->material(point_mm, closest), closest.distance};
}

Material SurfaceDomain::material_at(const Vec3& point_mm) const {
  const DistanceOctree::Found found = parts_->octree.find(point_mm);
  if (const auto known = parts_->known_material(found)) return *known;
  return parts_->material(point_mm, parts_->closest_point(point_mm, found));
}

double SurfaceDomain::clearance_limit_mm() const {
  return kUnbounded;
}

MaterialSet SurfaceDomain::materials_near(const Vec3& point_mm, double reach_mm) const {
  const DistanceOctree::Found found = parts_->octree.find(point_mm);
  const std::optional<Material> known = parts_->known_material(found);
  if (known && found.cell != nullptr && found.min_distance() > reach_mm) return {*known};
  const ClosestPoint closest = parts_->closest_point(point_mm, found);
  MaterialSet near{known ? *known : parts_->material(point_mm, closest)};
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
  const double on_surface_mm = 1e-9 * parts_->resolution_mm;
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
  return parts_->resolution_mm;
}

std::optional<Patch> SurfaceDomain::patch_between(Material inside, Material outside) const {
  if (inside == outside || (inside != kInside && outside != kInside)) return std::nullopt;
  const std::uint32_t region = region_of(inside == kInside ? outside : inside);
  if (!parts_->has_named_patches && parts_->regions.count() == 1) return std::nullopt;
  return parts_->of_region[region];
}

bool SurfaceDomain::is_beyond_opening(Material m) const {
  return m != kInside && parts_->of_region[region_of(m)].kind == PatchKind::kOpening;
}

std::span<const FlatEnd> SurfaceDomain::flat_ends() const {
  return parts_->ends;
}

std::span<const Vec3> SurfaceDomain::fixed_points() const {
  return parts_->fixed_points;
}

MixedMesh SurfaceDomain::patched_surface() const {
  MixedMesh mesh;
  mesh.points = parts_->surface.points;
  mesh.triangles = parts_->surface.triangles;
  std::vector<Patch>& patches = mesh.info.patches;
  std::vector<std::int32_t> number;
  for (const Patch& patch : parts_->of_region) {
    const auto at = std::find_if(patches.begin(), patches.end(),
                                 [&](const Patch& other) { return other.name == patch.name; });
    number.push_back(static_cast<std::int32_t>(at - patches.begin()));
    if (at == patches.end()) patches.push_back(patch);
  }
  for (const std::uint32_t region : parts_->regions.of_triangle)
    mesh.triangle_patches.push_back(number[region]);
  return mesh;
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
