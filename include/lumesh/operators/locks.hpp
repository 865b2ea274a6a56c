#pragma once
/// @file Who may change what. Operators take a lock type as template argument and ask it for every vertex of
/// every tetrahedron that they change.

#include "lumesh/core/types.hpp"

namespace lumesh::operators {

/// For a thread that is alone: it holds everything, always.
struct NoLock {
  [[nodiscard]] static bool try_lock(VertexId /*vertex*/) { return true; }
  static void release_all() {}
};

}  // namespace lumesh::operators
