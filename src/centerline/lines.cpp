#include "lines.hpp"

#include <map>

#include "voxel_paths.hpp"

namespace lumesh::centerline {

namespace {

/// A branch is fitted from where its own walls are all there: its radius times this outside of its parent.
constexpr double kMouth = 0.3;

struct ClosestPoint {
  std::size_t at = 0;
  double distance = std::numeric_limits<double>::infinity();
};

ClosestPoint nearest_point(const Tube& tube, const Vec3& p) {
  ClosestPoint closest;
  for (std::size_t i = 0; i < tube.size(); ++i) {
    const double distance = (tube.centres[i] - p).norm();
    if (distance < closest.distance) closest = {i, distance};
  }
  return closest;
}

class LineMaker {
 public:
  LineMaker(const Lumen& lumen, const std::vector<VoxelPath>& paths, double spacing_mm)
      : lumen_(lumen), paths_(paths), spacing_mm_(spacing_mm) {}

  std::vector<Tube> run() {
    for (const VoxelPath& path : paths_) tubes_.push_back(raw(path));
    const std::vector<Tube> rough = tubes_;
    for (std::size_t p = 0; p < paths_.size(); ++p) tubes_[p] = fit(paths_[p], rough[p]);
    for (std::size_t p = 0; p < paths_.size(); ++p) finish(paths_[p], tubes_[p]);
    return std::move(tubes_);
  }

 private:
  /// The voxels of a path, with the room around them.
  [[nodiscard]] Tube raw(const VoxelPath& path) const {
    Tube tube;
    tube.closed = path.closed;
    const auto radius = [&](std::uint32_t v) {
      return std::max(lumen_.wall_mm(v) - 0.5 * lumen_.voxel_mm(), 0.5 * lumen_.voxel_mm());
    };
    const auto add_opening = [&](const PathEnd& end, std::uint32_t v) {
      if (end.opening >= 0)
        tube.append(lumen_.openings[static_cast<std::size_t>(end.opening)].point, radius(v));
    };
    add_opening(path.first, path.voxels.front());
    for (const std::uint32_t v : path.voxels) tube.append(lumen_.position(v), radius(v));
    add_opening(path.last, path.voxels.back());
    const double gap = lumen_.voxel_mm();
    return averaged(resampled(tube, gap), 2 * gap);
  }

  [[nodiscard]] Tube fit(const VoxelPath& path, const Tube& rough) const {
    Tube tube = rough;
    at_joined_ends(path, tube, [&](int parent) { leave_parent(tube, parent); });
    Tube fine = with_way_inside(inscribed(lumen_, fitted(lumen_, without_bulges(lumen_, tube))), tube);
    at_joined_ends(path, fine, [&](int parent) { leave_sac(fine, parent); });
    return fine;
  }

  /// Calls a function with the path that a tube's first end joins, for both ends: it is turned round for the
  /// last one.
  template <class Function>
  static void at_joined_ends(const VoxelPath& path, Tube& tube, const Function& function) {
    if (path.first.path >= 0) function(path.first.path);
    if (path.last.path < 0 || path.closed) return;
    tube.reverse();
    function(path.last.path);
    tube.reverse();
  }

  /// Where a fit has left the lumen, in vessels too thin or too crooked for a tube, the voxels' way takes its
  /// place.
  [[nodiscard]] Tube with_way_inside(const Tube& tube, const Tube& rough) const {
    if (is_inside(lumen_, tube) || tube.closed) return tube;
    const double gap = lengths_along(tube).back() / static_cast<double>(tube.size());
    std::vector<std::uint8_t> is_bad(tube.size(), 0);
    for (std::size_t i = 0; i < tube.size(); ++i) {
      if (lumen_.inside(tube.centres[i]) >= 0.5) continue;
      const auto around = static_cast<std::size_t>(2 * tube.radii[i] / gap) + 1;
      const auto begin = static_cast<std::ptrdiff_t>(i - std::min(i, around));
      const auto end = static_cast<std::ptrdiff_t>(std::min(tube.size(), i + around + 1));
      std::fill(is_bad.begin() + begin, is_bad.begin() + end, std::uint8_t{1});
    }
    Tube out;
    for (std::size_t i = 0; i < tube.size();) {
      if (is_bad[i] == 0) {
        out.append(tube.centres[i], tube.radii[i]);
        ++i;
        continue;
      }
      const std::size_t first = i;
      while (i < tube.size() && is_bad[i] != 0) ++i;
      const std::size_t from = first == 0 ? 0 : nearest_point(rough, tube.centres[first]).at;
      const std::size_t to =
          i == tube.size() ? rough.size() - 1 : nearest_point(rough, tube.centres[i - 1]).at;
      for (std::size_t n = from; n <= to; ++n) out.append(rough.centres[n], rough.radii[n]);
    }
    return out.size() < 3 ? rough : out;
  }

  /// Cuts off what lies inside the vessel that a path begins in, or in a sac there.
  void leave_parent(Tube& tube, int parent) const {
    const Tube& outer = tubes_[static_cast<std::size_t>(parent)];
    std::size_t from = 0;
    while (from + 1 < tube.size()) {
      const ClosestPoint closest = nearest_point(outer, tube.centres[from]);
      if (closest.distance >
          outer.radii[closest.at] + kMouth * std::min(tube.radii[from], outer.radii[closest.at]))
        break;
      ++from;
    }
    from = std::min(from, tube.size() - std::min<std::size_t>(tube.size(), 3));
    tube.cut(from, tube.size());
    tube.cut(std::min(end_of_first_bulge(tube, lumen_.voxel_mm()), tube.size() - 3), tube.size());
  }

  /// Cuts off the first points of a fitted branch where these are of a sac at its mouth: wider than the
  /// parent.
  void leave_sac(Tube& tube, int parent) const {
    constexpr double kWider = 1.2;
    const Tube& outer = tubes_[static_cast<std::size_t>(parent)];
    const ClosestPoint closest = nearest_point(outer, tube.centres.front());
    if (tube.size() < 3 || tube.radii.front() < kWider * outer.radii[closest.at]) return;
    tube.cut(std::min(clear_of_sac(tube), tube.size() - 3), tube.size());
  }

  /// To the openings or the lines that it joins, with the points asked for.
  void finish(const VoxelPath& path, Tube& tube) const {
    if (!path.closed) {
      lead_to(path.last, tube);
      tube.reverse();
      lead_to(path.first, tube);
      tube.reverse();
    }
    const double min_gap = 0.25 * lumen_.voxel_mm();
    tube = spacing_mm_ > 0 ? resampled(tube, spacing_mm_) : resampled_by_radius(tube, kUsualSpacing, min_gap);
  }

  /// Leads the last end of a tube to where it belongs.
  void lead_to(const PathEnd& end, Tube& tube) const {
    const double gap =
        std::max(lengths_along(tube).back(), lumen_.voxel_mm()) / static_cast<double>(tube.size());
    const Vec3 along =
        direction_at(tube, tube.size() - 1, static_cast<std::size_t>(tube.radii.back() / gap) + 1);
    if (end.opening >= 0) lead_to_plane(lumen_.openings[static_cast<std::size_t>(end.opening)], along, tube);
    if (end.path < 0) return;
    const Tube& other = tubes_[static_cast<std::size_t>(end.path)];
    const double radius = tube.radii.back();
    const Vec3 last = tube.centres.back();
    std::size_t at = aim(other, last, along, radius);
    const Vec3 way = (other.centres[at] - last).normalized();
    Tube over =
        bridge(last, along, radius, other.centres[at], way, radius, 0.25 * (radius + lumen_.voxel_mm()));
    if (!is_inside(lumen_, over)) at = way_through_voxels(last, other, over);
    for (const Vec3& centre : over.centres) tube.append(centre, radius);
    tube.append(other.centres[at], radius);
  }

  /// From a place to a point of another line, which it returns the number of, where a straight way would
  /// leave the lumen.
  [[nodiscard]] std::size_t way_through_voxels(const Vec3& from, const Tube& other, Tube& way) const {
    std::map<std::uint32_t, std::size_t> ends;
    for (std::size_t i = 0; i < other.size(); ++i) ends.try_emplace(lumen_.voxel_around(other.centres[i]), i);
    ends.erase(kNoVoxel);
    way.cut(0, 0);
    const std::uint32_t first = lumen_.voxel_around(from);
    if (first == kNoVoxel) return nearest_point(other, from).at;
    const std::vector<std::uint32_t> path =
        path_to_nearest(lumen_, Steps(lumen_), first, std::numeric_limits<double>::infinity(),
                        [&](std::uint32_t v, double) { return ends.contains(v); });
    if (path.empty()) return nearest_point(other, from).at;
    Tube voxels;
    for (const std::uint32_t v : path) voxels.append(lumen_.position(v), 0);
    way = averaged(voxels, 2 * lumen_.voxel_mm());
    way.cut(std::min<std::size_t>(1, way.size()), way.size());
    return ends.at(path.back());
  }

  /// The point of another line that a straight way ahead passes nearest to.
  [[nodiscard]] std::size_t aim(const Tube& other, const Vec3& from, const Vec3& along, double radius) const {
    const ClosestPoint nearest = nearest_point(other, from);
    const double most = 2 * nearest.distance + radius;
    std::size_t best = nearest.at;
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < other.size(); ++i) {
      const Vec3 way = other.centres[i] - from;
      const double ahead = way.dot(along);
      if (ahead <= 0 || way.norm() > most) continue;
      const double deviation = (way - ahead * along).norm();
      if (deviation >= smallest) continue;
      smallest = deviation;
      best = i;
    }
    return best;
  }

  void lead_to_plane(const Opening& opening, const Vec3& along, Tube& tube) const {
    const auto above = [&](const Vec3& p) { return (p - opening.point).dot(opening.normal); };
    const auto is_beyond = [&](const Vec3& p) {
      return above(p) > -0.1 * lumen_.voxel_mm() || lumen_.beyond_frame_mm(p) > 0;
    };
    while (tube.size() > 3 && is_beyond(tube.centres.back())) tube.cut(0, tube.size() - 1);
    constexpr double kMinSlope = 0.2;  // 78 degrees: a line that is less steep says little of the place.
    const Vec3 direction = along.dot(opening.normal) > kMinSlope ? along : opening.normal;
    const double radius = tube.radii.back();
    const Vec3 last = tube.centres.back();
    tube.append(within_frame(last, last - direction * (above(last) / direction.dot(opening.normal))), radius);
  }
  /// The end of a way, or where it leaves the image's border by another side before, as at an edge.
  [[nodiscard]] Vec3 within_frame(const Vec3& start, const Vec3& end) const {
    constexpr double kRounding = 1e-9;
    if (lumen_.beyond_frame_mm(end) <= kRounding * lumen_.voxel_mm() || lumen_.beyond_frame_mm(start) > 0)
      return end;
    double inside = 0, outside = 1;
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (inside + outside);
      (lumen_.beyond_frame_mm(start + middle * (end - start)) > 0 ? outside : inside) = middle;
    }
    return start + inside * (end - start);
  }

  const Lumen& lumen_;
  const std::vector<VoxelPath>& paths_;
  double spacing_mm_;
  std::vector<Tube> tubes_;
};

}  // namespace

std::vector<Tube> tubes_along(const Lumen& lumen, const std::vector<VoxelPath>& paths, double spacing_mm) {
  return LineMaker(lumen, paths, spacing_mm).run();
}

}  // namespace lumesh::centerline
