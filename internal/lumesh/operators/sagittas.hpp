#pragma once
/// @file Mean heights of surfaces over triangles, and of curves over chords, between places on them.

#include <array>
#include <functional>
#include <optional>

#include "lumesh/domain/surface.hpp"

namespace lumesh::operators {

/// Mean height of the surface through three places with these normals over the triangle between them: exact
/// where the surface is a quadratic function. Negative where it is hollow.
[[nodiscard]] double sagitta_of(const std::array<SurfacePoint, 3>& corners);

/// How far the arc between two places of a surface stands over the middle of its chord, for a circle's.
[[nodiscard]] double arc_height(const SurfacePoint& from, const SurfacePoint& to);

/// Mean height of the curve between two places of a plane, with its normals there, over its chord.
[[nodiscard]] double mean_arc_height(const SurfacePoint& from, const SurfacePoint& to);

/// The place of a surface near a point; none where the surface is not known.
using PlaceNear = std::function<std::optional<SurfacePoint>(const Vec3& near)>;

/// The volume between a triangle and a surface near it, per area of the triangle. Summed over a closed mesh
/// it is the volume that the surface encloses beyond the mesh's, to fourth order in the edges. None where the
/// surface is not known.
/// @param over   Places of the surface over the corners.
/// @param place  Asked near the middles of the edges.
[[nodiscard]] std::optional<double> mean_height_over(const std::array<Vec3, 3>& corners,
                                                     const std::array<Vec3, 3>& over, const PlaceNear& place);

}  // namespace lumesh::operators
