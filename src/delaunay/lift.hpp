#pragma once
/// @file Where vertices of a curved surface stand so that flat triangles between them fill its volume.

#include "lumesh/domain/domain.hpp"

namespace lumesh::delaunay {

/// Triangles whose corners lie on a curved surface cut off what bulges: on a sphere 3/8 of the square of
/// their circumradius over that of the sphere, in the mean. A vertex stands higher by as much, along the
/// normal.
/// @param x        On the boundary between two materials. @param spacing  That of its points.
[[nodiscard]] Vec3 lifted(const Domain& domain, const Vec3& x, Material first, Material second,
                          double spacing);

}  // namespace lumesh::delaunay
