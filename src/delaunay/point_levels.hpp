#pragma once
// Points of about one spacing, by cubes of space.

#include <cmath>
#include <tuple>

#include "lumesh/core/types.hpp"

namespace lumesh::delaunay {

/// Those of one level have spacings in [2^level, 2^(level+1)).
inline int level_of(double spacing) {
  return std::ilogb(spacing);
}

inline bool comes_before(const Index3& a, const Index3& b) {
  return std::tie(a[2], a[1], a[0]) < std::tie(b[2], b[1], b[0]);
}

}  // namespace lumesh::delaunay
