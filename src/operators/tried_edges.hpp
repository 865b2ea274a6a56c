#pragma once
/// @file Edges that an operator need not try again.

#include "lumesh/core/local_map.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/mesh/edge_key.hpp"

namespace lumesh::operators {

/// Edges where it failed, as long as nothing changes around them: whatever replaces a tetrahedron at an edge
/// has both its ends among its vertices.
class TriedEdges {
 public:
  void clear() {
    failures_.clear();
    changes_.clear();
    step_ = 0;
  }
  void note_failure(VertexId a, VertexId b) {
    failures_.insert(edge_key(a.value, b.value), 0).value = ++step_;
  }
  template <class Vertices>
  void note_change(const Vertices& vertices) {
    ++step_;
    for (const std::uint32_t v : vertices) changes_.insert(v, 0).value = step_;
  }
  /// True if it failed at edge (a, b), and not both ends have seen a change since.
  [[nodiscard]] bool would_fail(VertexId a, VertexId b) {
    const std::uint32_t* const failure = failures_.find(edge_key(a.value, b.value));
    return failure != nullptr && !(has_changed_since(*failure, a) && has_changed_since(*failure, b));
  }

 private:
  [[nodiscard]] bool has_changed_since(std::uint32_t step, VertexId v) {
    const std::uint32_t* const change = changes_.find(v.value);
    return change != nullptr && *change > step;
  }

  LocalMap<std::uint64_t, std::uint32_t> failures_;
  LocalMap<std::uint32_t, std::uint32_t> changes_;
  std::uint32_t step_ = 0;  // Counts failures and changes.
};

}  // namespace lumesh::operators
