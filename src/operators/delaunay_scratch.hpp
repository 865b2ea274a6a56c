#pragma once
/// @file Working memory of DelaunayKernel.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "lumesh/core/local_map.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::operators {

/// The faces around a hole by the directed edges of their outlines: the neighbour of a face across an edge is
/// the one that has it the other way round.
class HullEdges {
 public:
  /// @param vertices  How many are on the outlines; they are known by places below that.
  void begin(std::uint32_t vertices) {
    shift_ = std::max(5, static_cast<int>(std::bit_width(vertices)));
    is_large_ = vertices > kMaxInTable;
    if (is_large_)
      far_.clear();
    else if (table_.size() < std::size_t{1} << 2 * shift_)
      table_.resize(std::size_t{1} << 2 * shift_);
  }
  void set(std::uint32_t a, std::uint32_t b, std::uint32_t face) {
    if (is_large_)
      far_.insert(std::uint64_t{a} << 32 | b, face);
    else
      table_[a << shift_ | b] = face;
  }
  /// The face that was set for an edge that was.
  [[nodiscard]] std::uint32_t get(std::uint32_t a, std::uint32_t b) {
    return is_large_ ? *far_.find(std::uint64_t{a} << 32 | b) : table_[a << shift_ | b];
  }

 private:
  static constexpr std::uint32_t kMaxInTable = 500;
  int shift_ = 0;
  bool is_large_ = false;
  std::vector<std::uint32_t> table_;  // By both places; what is not set is not read.
  LocalMap<std::uint64_t, std::uint32_t> far_;
};

struct DelaunayScratch {
  struct Conflict {
    TetId tet;
    std::uint32_t stamp;  ///< Its own, while it carries kInConflict.
  };
  struct HullFace {
    Cell<3> corners;  ///< Seen anticlockwise from inside the hole.
    FaceLink behind;
    TetId filled;
    Cell<3> places;  ///< Of the corners in `edges`.
  };
  /// A face whose other side is still open while a hole is wrapped.
  struct OpenFace {
    Cell<3> corners;    ///< As of HullFace; indices into `around`.
    std::uint32_t tet;  ///< Whose face it is; kHull | index into `hull`.
    int face;
  };
  /// A tetrahedron to be: indices into `around`, and for each face its neighbour, or kHull | index into
  /// `hull`.
  struct Wrapped {
    Cell<4> corners;
    std::array<std::uint32_t, 4> behind;
    std::array<int, 4> behind_face;
  };
  static constexpr std::uint32_t kHull = 1u << 31;

  std::vector<Conflict> conflicts;
  std::vector<HullFace> hull;
  HullEdges edges;
  std::vector<VertexId> around;  ///< The neighbours of a vertex that goes.
  std::vector<OpenFace> open;
  std::vector<Wrapped> wrapped;
  LocalMap<std::uint64_t, std::uint32_t> open_by_corners;
  std::vector<TetId> made;
  LocalMap<std::uint32_t, std::uint32_t> places;  ///< Of the vertices in `around`.
};

}  // namespace lumesh::operators
