#pragma once
/// @file All faces of a set of tetrahedra, sorted so that equal faces stand together.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

/// Corners in ascending order.
[[nodiscard]] inline Cell<3> sorted_corners(Cell<3> corners) {
  if (corners[0] > corners[1]) std::swap(corners[0], corners[1]);
  if (corners[1] > corners[2]) std::swap(corners[1], corners[2]);
  if (corners[0] > corners[1]) std::swap(corners[0], corners[1]);
  return corners;
}

/// Faces of tetrahedra by their corners. Built in parallel: faces are first dealt into buckets by their
/// lowest corner (sequential writes), then each bucket, which fits a cache, is sorted by itself. 16 bytes per
/// face.
class FaceTable {
 public:
  struct Face {
    Cell<3> corners;    ///< Ascending.
    std::uint32_t ref;  ///< tetrahedron << 2 | face.
    auto operator<=>(const Face&) const = default;
  };

  /// Every index in `tets` must be below `vertex_count`.
  FaceTable(std::span<const Cell<4>> tets, std::size_t vertex_count);

  [[nodiscard]] std::size_t bucket_count() const { return bucket_begin_.size() - 1; }

  /// Calls visit(group, bucket) for each set of equal faces (a span, ordered by ref). Buckets run in
  /// parallel, the groups of one bucket in order.
  template <class Visit>
  void for_each_group(const Visit& visit) const {
    parallel::for_each_block(bucket_count(), 1, [&](std::size_t bucket, std::size_t, std::size_t) {
      const Face* face = faces_.data() + bucket_begin_[bucket];
      const Face* const end = faces_.data() + bucket_begin_[bucket + 1];
      while (face != end) {
        const Face* last = face + 1;
        while (last != end && last->corners == face->corners) ++last;
        visit(std::span<const Face>(face, last), bucket);
        face = last;
      }
    });
  }

 private:
  std::vector<Face> faces_;
  std::vector<std::size_t> bucket_begin_;
};

}  // namespace lumesh
