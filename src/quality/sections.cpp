#include "lumesh/quality/sections.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lumesh/core/error.hpp"
#include "lumesh/parallel/loops.hpp"
#include "plane_sections.hpp"

namespace lumesh::quality {

namespace {

constexpr int kFinerSteps = 8;
constexpr int kParallelPlanes = 5;
constexpr double kMaxReach = 4;  // Of a vessel's section, in radii.

/// A place on an axis, and its radius.
struct Station {
  Vec3 point_mm = Vec3::Zero();
  Vec3 tangent = Vec3::UnitZ();
  double radius_mm = 0;
};

struct Measured {
  Station station;
  bool is_whole = false;
  double mesh_area_mm2 = 0;
  double voxel_area_mm2 = 0;
};

std::vector<Station> stations_of(const Polylines& axes, std::size_t line) {
  const std::vector<double>& radii = axes.scalars.at("radius");
  const std::vector<std::uint32_t>& ids = axes.lines[line];
  std::vector<Station> stations;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const Vec3& before = axes.points[ids[i == 0 ? 0 : i - 1]];
    const Vec3& after = axes.points[ids[std::min(i + 1, ids.size() - 1)]];
    stations.push_back({axes.points[ids[i]], (after - before).normalized(), radii[ids[i]]});
  }
  std::erase_if(stations, [](const Station& s) { return !(s.tangent.norm() > 0.5); });
  return stations;
}

/// True if a point lies in the tube around a line with a lower number.
bool in_earlier_tube(const Polylines& axes, std::size_t line, const Vec3& point_mm) {
  const std::vector<double>& radii = axes.scalars.at("radius");
  for (std::size_t l = 0; l < line; ++l)
    for (const std::uint32_t p : axes.lines[l])
      if ((axes.points[p] - point_mm).norm() < radii[p]) return true;
  return false;
}

class Sections {
 public:
  Sections(const MeshView& mesh, const MeshSurface& surface, const LabelImage& image,
           std::span<const CutPlane> planes)
      : image_(image),
        voxel_mm_(std::cbrt(image.frame().voxel_volume_mm3())),
        cuts_(planes, voxel_mm_),
        surface_(mesh.points, surface.outer()) {}

  /// On one plane.
  [[nodiscard]] Measured measure(const Station& station) const {
    const SectionPlane plane(station.point_mm, station.tangent);
    Measured result = {station};
    const double limit_mm = kMaxReach * (station.radius_mm + voxel_mm_);
    const std::optional<VoxelSection> voxels = voxel_section(image_, cuts_, plane, limit_mm);
    if (!voxels || !voxels->is_whole) return result;
    const SurfaceSection of_mesh = surface_.at(plane, limit_mm, voxel_mm_);
    if (of_mesh.reach_mm > limit_mm) return result;
    result.mesh_area_mm2 = of_mesh.area_mm2;
    // Vessels that touch may be one in the voxels and two in the mesh.
    for (const VoxelPart& part : voxels->parts)
      if (of_mesh.outline.empty() || of_mesh.is_nearest_to(part.centre))
        result.voxel_area_mm2 += part.area_mm2;
    result.is_whole = result.voxel_area_mm2 > 0;
    return result;
  }

  /// On average over parallel planes within a voxel.
  [[nodiscard]] Measured measure_mean(const Station& station) const {
    Measured mean = {station, true};
    for (int step = -kParallelPlanes / 2; step <= kParallelPlanes / 2; ++step) {
      Station beside = station;
      beside.point_mm += station.tangent * (voxel_mm_ * 2 * step / (kParallelPlanes - 1));
      const Measured found = measure(beside);
      mean.is_whole = mean.is_whole && found.is_whole;
      mean.mesh_area_mm2 += found.mesh_area_mm2 / kParallelPlanes;
      mean.voxel_area_mm2 += found.voxel_area_mm2 / kParallelPlanes;
    }
    return mean;
  }

  [[nodiscard]] bool leaves_image(const Station& end) const {
    const auto voxels = voxel_section(image_, cuts_, SectionPlane(end.point_mm, end.tangent),
                                      kMaxReach * (end.radius_mm + voxel_mm_));
    return !voxels || !voxels->is_whole;
  }

 private:
  const LabelImage& image_;
  double voxel_mm_;
  CutPlanes cuts_;
  SurfaceSections surface_;
};

/// How many stations to leave out from one end on, which `at(0)` is.
template <class At>
std::size_t end_length(const Polylines& axes, std::size_t line, const Sections& sections, std::size_t count,
                       const At& at) {
  std::size_t length = 0;
  while (length < count && in_earlier_tube(axes, line, at(length).point_mm)) ++length;
  if (length > 0 || sections.leaves_image(at(0))) return length;
  const Station tip = at(0);
  while (length < count && (at(length).point_mm - tip.point_mm).norm() < tip.radius_mm) ++length;
  return length;
}

/// The stations between the ends that are left out.
std::vector<Station> inner_stations(const Polylines& axes, std::size_t line, const Sections& sections) {
  const std::vector<Station> all = stations_of(axes, line);
  if (all.empty()) return all;
  const std::size_t begin =
      end_length(axes, line, sections, all.size(), [&](std::size_t i) { return all[i]; });
  const std::size_t from_end =
      end_length(axes, line, sections, all.size(), [&](std::size_t i) { return all[all.size() - 1 - i]; });
  if (begin + from_end >= all.size()) return {};
  return {all.begin() + static_cast<std::ptrdiff_t>(begin),
          all.end() - static_cast<std::ptrdiff_t>(from_end)};
}

/// Measures all stations, each by measure_one(station).
template <class MeasureOne>
std::vector<Measured> measure_all(const std::vector<Station>& stations, const MeasureOne& measure_one) {
  std::vector<Measured> result(stations.size());
  parallel::for_each_index(stations.size(), 1, [&](std::size_t i) { result[i] = measure_one(stations[i]); });
  return result;
}

/// The first place with the smallest area of the mesh.
std::optional<std::size_t> narrowest(const std::vector<Measured>& measured) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < measured.size(); ++i)
    if (measured[i].is_whole && (!best || measured[i].mesh_area_mm2 < measured[*best].mesh_area_mm2))
      best = i;
  return best;
}

/// Stations between `at` and both its neighbours, itself among them.
std::vector<Station> finer_stations(const std::vector<Station>& stations, std::size_t at) {
  std::vector<Station> result;
  const std::size_t first = at == 0 ? 0 : at - 1, last = std::min(at + 1, stations.size() - 1);
  for (std::size_t i = first; i < last; ++i)
    for (int step = 0; step < kFinerSteps; ++step) {
      const double share = static_cast<double>(step) / kFinerSteps;
      const Station &a = stations[i], &b = stations[i + 1];
      const Vec3 tangent = a.tangent + share * (b.tangent - a.tangent);
      result.push_back({a.point_mm + share * (b.point_mm - a.point_mm), tangent.normalized(), a.radius_mm});
    }
  result.push_back(stations[last]);
  return result;
}

/// The narrowest whole place of one branch; none if there is none.
std::optional<Measured> narrowest_of_branch(const Sections& sections, const std::vector<Station>& stations) {
  std::vector<Measured> single =
      measure_all(stations, [&](const Station& station) { return sections.measure(station); });
  while (const std::optional<std::size_t> place = narrowest(single)) {
    const std::vector<Measured> finer =
        measure_all(finer_stations(stations, *place),
                    [&](const Station& station) { return sections.measure_mean(station); });
    if (const std::optional<std::size_t> best = narrowest(finer)) return finer[*best];
    single[*place].is_whole = false;  // The parallel planes reach beyond the image.
  }
  return std::nullopt;
}

}  // namespace

std::vector<NarrowestSection> find_narrowest_sections(const MeshView& mesh, const MeshSurface& surface,
                                                      const LabelImage& image, const Polylines& axes,
                                                      std::span<const CutPlane> planes) {
  const auto radius = axes.scalars.find("radius");
  if (radius == axes.scalars.end() || radius->second.size() != axes.points.size())
    throw Error(ErrorKind::kBadInput,
                "the axes of vessels have no radius at their points; make them with lumesh centerline");
  std::vector<NarrowestSection> result;
  const Sections sections(mesh, surface, image, planes);
  for (std::size_t line = 0; line < axes.lines.size(); ++line) {
    const std::optional<Measured> found = narrowest_of_branch(sections, inner_stations(axes, line, sections));
    if (found)
      result.push_back({line, found->station.point_mm, found->station.tangent, found->mesh_area_mm2,
                        found->voxel_area_mm2});
  }
  return result;
}

}  // namespace lumesh::quality
