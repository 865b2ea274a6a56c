#pragma once
/// @file Who may change what. Operators take a lock type as template argument and ask it for every vertex of
/// every tetrahedron that they change.

#include <cstdint>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::operators {

/// For a thread that is alone: it holds everything, always.
struct NoLock {
  [[nodiscard]] static bool try_lock(VertexId /*vertex*/) { return true; }
  static void release_all() {}
  /// Takes over a vertex that its thread has just made.
  static void adopt(VertexId /*vertex*/) {}
};

/// For the run of a bucket of a Partition: it holds what lies in its reach until it is done, and nothing
/// contends. Whose reach a bucket lies in stands in one word per bucket, the number of a run. Words of
/// buckets outside the reach may change while they are read; they never hold this run's number.
class OrderedLock {
 public:
  OrderedLock() = default;
  OrderedLock(TetMesh& mesh, const std::uint32_t* runs, std::uint32_t run, std::uint32_t bucket)
      : mesh_(&mesh), runs_(runs), run_(run), bucket_(bucket) {}
  [[nodiscard]] bool try_lock(VertexId vertex) const {
    return parallel::load_relaxed(runs_[mesh_->lock_word(vertex)]) == run_;
  }
  static void release_all() {}
  void adopt(VertexId vertex) const { mesh_->lock_word(vertex) = bucket_; }

 private:
  TetMesh* mesh_ = nullptr;
  const std::uint32_t* runs_ = nullptr;
  std::uint32_t run_ = 0, bucket_ = 0;
};

}  // namespace lumesh::operators
