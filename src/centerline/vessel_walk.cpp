#include "vessel_walk.hpp"

#include <algorithm>
#include <cmath>

namespace lumesh::centerline {

namespace {

/// Turns a vector by the least rotation that takes one unit direction to another one, not its opposite.
Vec3 turned(const Vec3& vector, const Vec3& from, const Vec3& to) {
  const Vec3 axis = from.cross(to);
  const Vec3 once = axis.cross(vector);
  return vector + once + axis.cross(once) / (1 + from.dot(to));
}

}  // namespace

VesselWalk::VesselWalk(const Lumen& lumen, const PathTree& tree, const std::vector<VoxelPath>& paths,
                       std::size_t path, std::uint32_t voxel)
    : lumen_(lumen) {
  const auto add = [&](std::uint32_t v) {
    places_.push_back(lumen.position(v));
    walls_mm_.push_back(lumen.wall_mm(v));
  };
  for (std::uint32_t v = voxel; v != tree.root; v = tree.before[v]) add(v);
  add(tree.root);
  if (paths.front().first.opening >= 0) go_straight_on();
  std::ranges::reverse(places_);
  std::ranges::reverse(walls_mm_);
  const std::vector<std::uint32_t>& voxels = paths[path].voxels;
  const auto at = std::ranges::find(voxels, voxel);
  if (at != voxels.end()) std::for_each(at + 1, voxels.end(), add);
  if (paths[path].last.opening >= 0) go_straight_on();
}

void VesselWalk::go_straight_on() {
  const Vec3 along = direction(places_.size() - 1);
  const Vec3 end = places_.back();
  const double wall_mm = walls_mm_.back();
  for (int n = 1; along.squaredNorm() > 0; ++n) {
    const Vec3 place = end + n * lumen_.voxel_mm() * along;
    if (lumen_.beyond_frame_mm(place) > 0 || !is_in_lumen(places_.back(), place - places_.back())) return;
    places_.push_back(place);
    walls_mm_.push_back(wall_mm);
  }
}

void VesselWalk::start_beside(const Vec3& position) {
  const auto nearest = std::ranges::min_element(
      places_, {}, [&](const Vec3& place) { return (place - position).squaredNorm(); });
  start_ = static_cast<std::size_t>(nearest - places_.begin());
}

std::optional<double> VesselWalk::carried_mm(const Vec3& across, double far_mm, int step) const {
  const Vec3 first = direction(start_);
  double walked = 0;
  for (std::size_t n = start_;;) {
    const Vec3 to = direction(n);
    if (first.dot(to) <= 0) return std::nullopt;  // The vessel turns by more than a right angle.
    const Vec3 way = turned(across, first, to);
    if (!is_past_opening(n, way) && !is_in_lumen(places_[n], way)) return std::nullopt;
    const bool at_end = step < 0 ? n == 0 : n + 1 == places_.size();
    if (at_end || walked >= far_mm) return walked;
    const std::size_t next = step < 0 ? n - 1 : n + 1;
    walked += (places_[next] - places_[n]).norm();
    n = next;
  }
}

/// Unit; over a radius to both sides, as the way through voxels is not straight.
Vec3 VesselWalk::direction(std::size_t n) const {
  const double reach_mm = 1.5 * walls_mm_[n] + 2 * lumen_.voxel_mm();
  std::size_t low = n, high = n;
  while (low > 0 && (places_[low] - places_[n]).norm() < reach_mm) --low;
  while (high + 1 < places_.size() && (places_[high] - places_[n]).norm() < reach_mm) ++high;
  const Vec3 along = places_[high] - places_[low];
  return along.norm() > 0 ? Vec3(along.normalized()) : Vec3(Vec3::Zero());
}

bool VesselWalk::is_in_lumen(const Vec3& from, const Vec3& way) const {
  const auto parts = static_cast<int>(std::ceil(way.norm() / lumen_.voxel_mm()));
  for (int n = 1; n <= parts; ++n)
    if (lumen_.inside(from + way * (static_cast<double>(n) / parts)) < 0.5) return false;
  return true;
}

/// Whether the way ends beyond the plane of an opening that is near.
bool VesselWalk::is_past_opening(std::size_t n, const Vec3& across) const {
  const double near_mm = 2 * across.norm() + 3 * walls_mm_[n];
  return std::ranges::any_of(lumen_.openings, [&](const Opening& opening) {
    const Vec3 off = places_[n] + across - opening.point;
    return off.norm() <= near_mm && off.dot(opening.normal) >= -lumen_.voxel_mm();
  });
}

}  // namespace lumesh::centerline
