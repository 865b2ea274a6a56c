#pragma once
/// @file Who may change what. Operators take a lock type as template argument and ask it for every vertex of
/// every tetrahedron that they change. A tetrahedron may be changed by who holds all its vertices. Who holds
/// one of them may read it, and cross those of its faces that have a held vertex.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/parallel/word_lock.hpp"

namespace lumesh::operators {

/// For a thread that is alone: it holds everything, always.
struct NoLock {
  [[nodiscard]] static bool try_lock(VertexId /*vertex*/) { return true; }
  /// How much is held, and back to that.
  [[nodiscard]] static std::size_t mark() { return 0; }
  static void release_to(std::size_t /*mark*/) {}
  /// Gives back all but these, which are held.
  static void keep_only(const Cell<4>& /*vertices*/) {}
  /// True if something was refused, since the last mark(), that may be had another time.
  [[nodiscard]] static bool was_refused() { return false; }
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
  [[nodiscard]] static std::size_t mark() { return 0; }
  static void release_to(std::size_t /*mark*/) {}
  [[nodiscard]] static bool was_refused() { return false; }
  void adopt(VertexId vertex) const { parallel::store_relaxed(mesh_->lock_word(vertex), bucket_); }

 private:
  TetMesh* mesh_ = nullptr;
  const std::uint32_t* runs_ = nullptr;
  std::uint32_t run_ = 0, bucket_ = 0;
};

/// For one of many threads that take what they touch by compare-and-swap, and give way where another was
/// first. The words of the vertices hold the owner's number. Those of freed vertices and of new ones whose
/// maker has not adopted them yet belong to nobody, so that a thread with an old number of theirs never gets
/// them.
class SpeculativeLock {
 public:
  SpeculativeLock() = default;
  /// @param owner  Of this thread alone; neither 0 nor TetMesh::kNoOwner.
  SpeculativeLock(TetMesh& mesh, std::uint32_t owner) : mesh_(&mesh), owner_(owner) {}

  [[nodiscard]] bool try_lock(VertexId vertex) {
    std::uint32_t& word = mesh_->lock_word(vertex);
    if (parallel::load_relaxed(word) == owner_) return true;  // Only this thread writes its own number.
    if (!parallel::try_acquire(word, owner_)) {
      refused_ = true;
      return false;
    }
    held_.push_back(vertex);
    return true;
  }
  [[nodiscard]] std::size_t mark() {
    refused_ = false;
    return held_.size();
  }
  void release_to(std::size_t mark) {
    for (; held_.size() > mark; held_.pop_back())
      parallel::unlock(mesh_->lock_word(held_.back()),
                       mesh_->alive(held_.back()) ? parallel::kFreeWord : TetMesh::kNoOwner);
  }
  void keep_only(const Cell<4>& vertices) {
    std::erase_if(held_, [&](VertexId held) {
      if (std::find(vertices.begin(), vertices.end(), held.value) != vertices.end()) return false;
      parallel::unlock(mesh_->lock_word(held), mesh_->alive(held) ? parallel::kFreeWord : TetMesh::kNoOwner);
      return true;
    });
  }
  [[nodiscard]] bool was_refused() const { return refused_; }
  void adopt(VertexId vertex) {
    parallel::store_relaxed(mesh_->lock_word(vertex), owner_);
    held_.push_back(vertex);
  }

 private:
  TetMesh* mesh_ = nullptr;
  std::uint32_t owner_ = 0;
  bool refused_ = false;
  std::vector<VertexId> held_;
};

}  // namespace lumesh::operators
