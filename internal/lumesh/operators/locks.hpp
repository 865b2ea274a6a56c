#pragma once
/// @file Locks of vertices. Operators take a lock type as template argument and ask it for every vertex of
/// every tetrahedron that they change. A thread that holds all vertices of a tetrahedron may change it. A
/// thread that holds one of them may read it, and cross those of its faces that have a held vertex.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/parallel/word_lock.hpp"

namespace lumesh::operators {

/// The lock of a thread that is alone: it holds everything, always.
struct NoLock {
  [[nodiscard]] static bool try_lock(VertexId /*vertex*/) { return true; }
  /// The number of held vertices, and release down to that number.
  [[nodiscard]] static std::size_t mark() { return 0; }
  static void release_to(std::size_t /*mark*/) {}
  /// Releases all vertices but these, which are held.
  static void keep_only(const Cell<4>& /*vertices*/) {}
  /// True if another thread held a vertex asked for since the last mark(): a later try may succeed.
  [[nodiscard]] static bool contended() { return false; }
  /// Takes ownership of a vertex that this thread has just made.
  static void take_ownership(VertexId /*vertex*/) {}
};

/// The lock of a run of a bucket of a Partition: it holds all vertices in its reach until the run is done,
/// and nothing contends. One word per bucket has the number of the run whose reach the bucket lies in. Words
/// of buckets outside the reach may change while they are read; they never hold this run's number, and the
/// order of the runs makes those within visible: relaxed is enough. Tests: OrderedExecution* in
/// tests/unit/operators.
class OrderedLock {
 public:
  OrderedLock() = default;
  OrderedLock(TetMesh& mesh, const std::uint32_t* runs, std::uint32_t run, std::uint32_t bucket)
      : mesh_(&mesh), runs_(runs), run_(run), bucket_(bucket) {}
  [[nodiscard]] bool try_lock(VertexId vertex) const {
    return parallel::load_relaxed(runs_[mesh_->lock_word(vertex)]) == run_;
  }
  [[nodiscard]] static std::size_t mark() { return 0; }
  static void release_to(std::size_t /*mark*/) {}
  [[nodiscard]] static bool contended() { return false; }
  void take_ownership(VertexId vertex) const { parallel::store_relaxed(mesh_->lock_word(vertex), bucket_); }

 private:
  TetMesh* mesh_ = nullptr;
  const std::uint32_t* runs_ = nullptr;
  std::uint32_t run_ = 0, bucket_ = 0;
};

/// The lock of one of many threads that acquire the vertices they touch by compare-and-swap, and back off
/// where another was first. The words of the vertices hold the owner's number. Those of freed vertices and of
/// new ones whose maker has not taken ownership yet belong to nobody, so that a thread with an old number of
/// such a vertex never gets it: the maker may write them relaxed. Tests: SpeculativeLock.* and
/// SpeculativeExecution* in tests/unit/operators.
class SpeculativeLock {
 public:
  SpeculativeLock() = default;
  /// @param owner  Number of this thread alone; neither 0 nor TetMesh::kNoOwner.
  SpeculativeLock(TetMesh& mesh, std::uint32_t owner) : mesh_(&mesh), owner_(owner) {}

  [[nodiscard]] bool try_lock(VertexId vertex) {
    std::uint32_t& word = mesh_->lock_word(vertex);
    if (parallel::load_relaxed(word) == owner_) return true;  // Only this thread writes its own number.
    if (!parallel::try_acquire(word, owner_)) {
      contended_ = true;
      return false;
    }
    held_.push_back(vertex);
    return true;
  }
  [[nodiscard]] std::size_t mark() {
    contended_ = false;
    return held_.size();
  }
  void release_to(std::size_t mark) {
    for (; held_.size() > mark; held_.pop_back())
      parallel::unlock(mesh_->lock_word(held_.back()),
                       mesh_->alive(held_.back()) ? parallel::kFreeWord : TetMesh::kNoOwner);
  }
  void keep_only(const Cell<4>& vertices) {
    std::erase_if(held_, [&](VertexId held) {
      if (std::ranges::find(vertices, held.value) != vertices.end()) return false;
      parallel::unlock(mesh_->lock_word(held), mesh_->alive(held) ? parallel::kFreeWord : TetMesh::kNoOwner);
      return true;
    });
  }
  [[nodiscard]] bool contended() const { return contended_; }
  void take_ownership(VertexId vertex) {
    parallel::store_relaxed(mesh_->lock_word(vertex), owner_);
    held_.push_back(vertex);
  }

 private:
  TetMesh* mesh_ = nullptr;
  std::uint32_t owner_ = 0;
  bool contended_ = false;
  std::vector<VertexId> held_;
};

}  // namespace lumesh::operators
