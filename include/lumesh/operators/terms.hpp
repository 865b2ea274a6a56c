#pragma once
/// @file What stages and operators tell each other: how passes run, what is not to be done, what was done.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/parallel/team_options.hpp"

namespace lumesh {

class OptionList;
struct SurfacePoint;

/// How threads share a mesh that all of them change.
enum class ExecutionKind : std::uint8_t {
  kOrdered,      ///< operators::OrderedExecution: bitwise identical for every thread count.
  kSpeculative,  ///< operators::SpeculativeExecution.
};

/// The options `execution`, `balance` and `pin` of stages that change a mesh by the operators.
void describe_execution(OptionList& list, ExecutionKind& execution, parallel::TeamOptions& team);

}  // namespace lumesh

namespace lumesh::operators {

/// True for tetrahedra, by their corners, that are not to be made, whatever their shapes. Called from any
/// thread; the same answer to the same question.
using Refusal = std::function<bool(const std::array<Vec3, 4>& corners_mm)>;

/// The place of a patch's true surface near a point, with the normal; none where the surface is not known,
/// and for patches whose vertices are to stay. Called from several threads.
using PlaceOnPatch = std::function<std::optional<SurfacePoint>(PatchId patch, const Vec3& near)>;

/// The place itself if a vertex may be there, else the one to take instead. Called from several threads;
/// objects that it refers to must outlive the call.
using KeepWithin = std::function<Vec3(const Vec3& place)>;
/// How far a place is from the one to take instead; 0 where a vertex may be. @param keep_within  Null:
/// everywhere.
[[nodiscard]] inline double distance_outside(const KeepWithin& keep_within, const Vec3& place) {
  return keep_within ? (keep_within(place) - place).norm() : 0;
}

/// Whether a vertex stays where it is. Called from several threads; null: none.
using Stays = std::function<bool(const Vec3& place)>;

enum class Outcome : std::uint8_t {
  kApplied,
  kRejected,   ///< A rule or the geometry speaks against it.
  kContended,  ///< A vertex could not be locked; a later try may succeed.
};

struct OperatorCount {
  std::uint64_t applied = 0, rejected = 0, contended = 0;

  void add(Outcome outcome) {
    ++(outcome == Outcome::kApplied ? applied : outcome == Outcome::kRejected ? rejected : contended);
  }
  OperatorCount& operator+=(const OperatorCount& other) {
    applied += other.applied;
    rejected += other.rejected;
    contended += other.contended;
    return *this;
  }
  OperatorCount& operator-=(const OperatorCount& other) {
    applied -= other.applied;
    rejected -= other.rejected;
    contended -= other.contended;
    return *this;
  }
};

/// The counter of an operator.
enum class OperatorId : std::uint8_t { kInsertion, kCollapse, kEdgeRemoval, kFaceRemoval, kSmoothing };

struct OperatorName {
  OperatorId id;
  const char* name;
};
/// In the order of the ids.
inline constexpr std::array kOperatorNames = {OperatorName{OperatorId::kInsertion, "insertion"},
                                              OperatorName{OperatorId::kCollapse, "collapse"},
                                              OperatorName{OperatorId::kEdgeRemoval, "edge_removal"},
                                              OperatorName{OperatorId::kFaceRemoval, "face_removal"},
                                              OperatorName{OperatorId::kSmoothing, "smoothing"}};

struct OperatorCounts {
  std::array<OperatorCount, kOperatorNames.size()> by_id = {};

  OperatorCount& operator[](OperatorId id) { return by_id[static_cast<std::size_t>(id)]; }
  const OperatorCount& operator[](OperatorId id) const { return by_id[static_cast<std::size_t>(id)]; }

  OperatorCounts& operator+=(const OperatorCounts& other) {
    for (std::size_t i = 0; i < by_id.size(); ++i) by_id[i] += other.by_id[i];
    return *this;
  }
  OperatorCounts& operator-=(const OperatorCounts& other) {
    for (std::size_t i = 0; i < by_id.size(); ++i) by_id[i] -= other.by_id[i];
    return *this;
  }
  [[nodiscard]] OperatorCount of_all() const {
    OperatorCount sum;
    for (const OperatorCount& count : by_id) sum += count;
    return sum;
  }
  [[nodiscard]] std::uint64_t applied() const { return of_all().applied; }
};

/// Counts of each thread of an execution, and of the buckets that migrated to it.
struct ExecutionCounts {
  std::vector<OperatorCounts> by_thread;
  std::vector<parallel::TaskMigrations> migrations;

  [[nodiscard]] OperatorCounts of_all_threads() const;
  ExecutionCounts& operator+=(const ExecutionCounts& other);  ///< For equal numbers of threads, or none yet.
};

}  // namespace lumesh::operators
