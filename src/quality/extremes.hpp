#pragma once
/// @file Extremes over tetrahedra that are met in ascending order.

#include "lumesh/quality/statistics.hpp"

namespace lumesh::quality {

inline void lower(Extreme& extreme, double value, std::uint32_t tetrahedron) {
  if (value < extreme.value) extreme = {value, tetrahedron, Vec3::Zero()};
}
inline void raise(Extreme& extreme, double value, std::uint32_t tetrahedron) {
  if (value > extreme.value) extreme = {value, tetrahedron, Vec3::Zero()};
}

/// Fills in the centre of the tetrahedron.
inline void locate(Extreme& extreme, const MeshView& mesh) {
  const Cell<4>& v = mesh.tetrahedra[extreme.tetrahedron];
  extreme.centre_mm = (mesh.points[v[0]] + mesh.points[v[1]] + mesh.points[v[2]] + mesh.points[v[3]]) / 4;
}

}  // namespace lumesh::quality
