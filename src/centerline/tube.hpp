#pragma once
/// @file A line with a radius at each point, in the positions of a Lumen.

#include <vector>

#include "lumen.hpp"

namespace lumesh::centerline {

struct Tube {
  std::vector<Vec3> centres;
  std::vector<double> radii;  ///< mm, one per centre.
  bool closed = false;        ///< The first centre comes after the last one again.

  [[nodiscard]] std::size_t size() const { return centres.size(); }
  void append(const Vec3& centre, double radius) {
    centres.push_back(centre);
    radii.push_back(radius);
  }
  void reverse() {
    std::ranges::reverse(centres);
    std::ranges::reverse(radii);
  }
  /// Keeps the points [begin, end).
  void cut(std::size_t begin, std::size_t end);
};

/// Way along the line to each point; of a closed one also back to the first.
[[nodiscard]] std::vector<double> lengths_along(const Tube& tube);

/// Points at even gaps near `gap_mm`, at least three; ends are kept.
[[nodiscard]] Tube resampled(const Tube& tube, double gap_mm);

/// Points whose gaps are at most as `gap_at(radius)` says, on a cubic through the given points; ends are
/// kept.
[[nodiscard]] Tube resampled_by_radius(const Tube& tube, double share, double min_mm);

/// Means over `reach_mm` to both sides, less near open ends, which stay.
[[nodiscard]] Tube averaged(const Tube& tube, double reach_mm);

/// Unit direction at a point from its neighbours up to `reach` points away.
[[nodiscard]] Vec3 direction_at(const Tube& tube, std::size_t at, std::size_t reach);

/// Cubic from one place to another with given unit directions at its ends, points at most `gap_mm` apart,
/// without the ends. Radii in proportion.
[[nodiscard]] Tube bridge(const Vec3& from, const Vec3& from_direction, double from_radius, const Vec3& to,
                          const Vec3& to_direction, double to_radius, double gap_mm);

/// Whether all points of a tube lie in the lumen.
[[nodiscard]] bool is_inside(const Lumen& lumen, const Tube& tube);

/// Replaces stretches where the radius grows beyond what both of their ends explain, as in a sac, by a
/// bridge, where that lies inside.
[[nodiscard]] Tube without_bulges(const Lumen& lumen, const Tube& tube);

/// First point that no longer lies in a bulge that the tube begins with.
[[nodiscard]] std::size_t end_of_first_bulge(const Tube& tube, double voxel_mm);

/// First point of a fitted tube that begins in a sac where the sac draws neither its radius nor its
/// direction.
[[nodiscard]] std::size_t clear_of_sac(const Tube& tube);

/// Moves centres and radii so that the tube follows the wall, however much of it is missing at sacs and at
/// the mouths of branches: at each point rays across the tube find the wall, least squares with weights that
/// fade for rays that end far beyond the tube (Geman and McClure 1987), narrower from round to round, and a
/// penalty on second differences that carries the tube over gaps. What gets outside is drawn back to where it
/// started.
[[nodiscard]] Tube fitted(const Lumen& lumen, const Tube& start);

/// The tube with the radius of the ball that fits: less than the fitted one where the vessel is flattened.
[[nodiscard]] Tube inscribed(const Lumen& lumen, const Tube& tube);

}  // namespace lumesh::centerline
