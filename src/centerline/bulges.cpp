
#include "tube.hpp"

namespace lumesh::centerline {

namespace {

/// A radius this much above the larger of the smallest ones before and behind is a bulge.
constexpr double kBulge = 1.4;
/// How far to look for those, in radii.
constexpr double kBulgeReach = 4;
/// A bulge goes on to where the radius is within this of the vessel's.
constexpr double kBase = 1.08;
/// A fitted tube that is this much wider at its end was drawn into a sac.
constexpr double kDrawn = 1.25;

struct Stretch {
  std::size_t begin;  ///< Last good point before,
  std::size_t end;    ///< first good point behind.
};

/// Smallest radius within `reach` points before (step -1) or behind (+1) a point, itself included.
double narrowest(const Tube& tube, std::size_t at, std::ptrdiff_t reach, std::ptrdiff_t step) {
  const auto count = static_cast<std::ptrdiff_t>(tube.size());
  double smallest = tube.radii[at];
  for (std::ptrdiff_t n = 1; n <= reach; ++n) {
    std::ptrdiff_t i = static_cast<std::ptrdiff_t>(at) + n * step;
    if (tube.closed) i = (i % count + count) % count;
    if (i < 0 || i >= count) break;
    smallest = std::min(smallest, tube.radii[static_cast<std::size_t>(i)]);
  }
  return smallest;
}

/// The stretch around the widest point at or after `from` of the first bulge; begin == end if there is none.
Stretch next_bulge(const Tube& tube, std::size_t from, double gap, double voxel_mm) {
  for (std::size_t i = from; i < tube.size(); ++i) {
    const auto reach = static_cast<std::ptrdiff_t>(kBulgeReach * tube.radii[i] / gap);
    const double before = narrowest(tube, i, reach, -1), behind = narrowest(tube, i, reach, 1);
    if (tube.radii[i] <= kBulge * std::max(before, behind) + 0.5 * voxel_mm) continue;
    std::size_t peak = i;
    while (peak + 1 < tube.size() && tube.radii[peak + 1] >= tube.radii[peak]) ++peak;
    const auto peak_reach = static_cast<std::ptrdiff_t>(kBulgeReach * tube.radii[peak] / gap);
    const double left = narrowest(tube, peak, peak_reach, -1), right = narrowest(tube, peak, peak_reach, 1);
    Stretch stretch{i, i};
    while (stretch.begin > 0 && tube.radii[stretch.begin] > kBase * left) --stretch.begin;
    while (stretch.end + 1 < tube.size() && (stretch.end < peak || tube.radii[stretch.end] > kBase * right))
      ++stretch.end;
    // What is near the sac leans towards it.
    const auto lean = static_cast<std::size_t>(0.5 * std::min(left, right) / gap);
    stretch.begin -= std::min(stretch.begin, lean);
    stretch.end = std::min(tube.size() - 1, stretch.end + lean);
    return stretch;
  }
  return {tube.size(), tube.size()};
}

double mean_gap(const Tube& tube) {
  return lengths_along(tube).back() / static_cast<double>(std::max<std::size_t>(1, tube.size() - 1));
}

Tube bridge_over(const Tube& tube, const Stretch& stretch, double gap) {
  const auto reach = static_cast<std::size_t>(tube.radii[stretch.begin] / gap) + 1;
  const std::size_t before = stretch.begin - std::min(stretch.begin, reach);
  const std::size_t behind = std::min(tube.size() - 1, stretch.end + reach);
  const Vec3 leaving = (tube.centres[stretch.begin] - tube.centres[before]).normalized();
  const Vec3 arriving = (tube.centres[behind] - tube.centres[stretch.end]).normalized();
  return bridge(tube.centres[stretch.begin], leaving, tube.radii[stretch.begin], tube.centres[stretch.end],
                arriving, tube.radii[stretch.end], gap);
}

/// First point whose radius is at most `factor` times the smallest one soon behind it, and `slack_mm` more;
/// the last point if there is none.
std::size_t first_like_next(const Tube& tube, double factor, double slack_mm) {
  const double gap = mean_gap(tube);
  std::size_t at = 0;
  for (; at + 1 < tube.size(); ++at) {
    const auto reach = static_cast<std::ptrdiff_t>(kBulgeReach * tube.radii[at] / gap);
    if (tube.radii[at] <= factor * narrowest(tube, at, reach, 1) + slack_mm) break;
  }
  return at;
}

}  // namespace

Tube without_bulges(const Lumen& lumen, const Tube& tube) {
  const double gap = mean_gap(tube);
  Tube out;
  out.closed = tube.closed;
  std::size_t done = 0;
  const auto keep_until = [&](std::size_t end) {
    for (; done < std::min(end, tube.size()); ++done) out.append(tube.centres[done], tube.radii[done]);
  };
  while (done < tube.size()) {
    const Stretch bulge = next_bulge(tube, done, gap, lumen.voxel_mm());
    keep_until(std::max(done, bulge.begin) + 1);
    const std::size_t last = done - 1;
    // At an end nothing says where the vessel would be.
    if (bulge.begin > 0 && bulge.end + 1 < tube.size() && bulge.end > last) {
      const Tube over = bridge_over(tube, {last, bulge.end}, gap);
      if (is_inside(lumen, over)) {
        for (std::size_t i = 0; i < over.size(); ++i) out.append(over.centres[i], over.radii[i]);
        done = bulge.end;
        continue;
      }
    }
    if (bulge.end < tube.size()) keep_until(bulge.end + 1);
  }
  return out;
}

std::size_t clear_of_sac(const Tube& tube) {
  if (first_like_next(tube, kDrawn, 0) == 0) return 0;
  const std::size_t at = first_like_next(tube, kBase, 0);
  return std::min(tube.size() - 1, at + static_cast<std::size_t>(tube.radii[at] / mean_gap(tube)));
}

std::size_t end_of_first_bulge(const Tube& tube, double voxel_mm) {
  const std::size_t at = first_like_next(tube, kBulge, 0.5 * voxel_mm);
  return at + 1 < tube.size() ? at : 0;
}

}  // namespace lumesh::centerline
