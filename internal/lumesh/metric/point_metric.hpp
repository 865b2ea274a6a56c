#pragma once
/// @file A metric from the shape of a set of points, such as a centerline.

#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/metric/sources.hpp"

namespace lumesh::metric {

/// For every place the metric whose unit ball is the smallest ellipsoid around the k points nearest to it: on
/// a centerline long along the vessel, and thin across. The sizes follow from k and the spacing of the
/// points, not from the radius; only their proportions carry over to a mesh of a wanted complexity. How far
/// the place lies from the points does not matter. Equal points count once, and of points as near as one
/// another those first by x, y, z are taken, so that the order of the points does not matter.
///
/// @return One tensor per place in 1/mm^2.
/// @throws Error{kBadInput} if a point is not finite, there are fewer than two different ones or fewer than
/// k, or none lies within one diagonal of the places' box of that; the message does not name a file. Parallel
/// inside, bitwise identical for every thread count. Cost: docs/stages/metric.md. Source of the sets and
/// ellipsoids: EllipsoidSearch.
[[nodiscard]] std::vector<SymTensor> metric_from_points(std::span<const Vec3> places,
                                                        std::span<const Vec3> points,
                                                        const PointMetricOptions& options = {});

}  // namespace lumesh::metric
