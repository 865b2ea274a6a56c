#pragma once
/// @file What commands share that keep what they have when they are told to stop.

#include <string>

#include "common.hpp"

namespace lumesh::cli {

/// A run with results that are written though it was stopped, on Ctrl-C or at its time limit (Program).
class LongRun {
 public:
  explicit LongRun(const RunOptions& options);

  /// From now on results are written: each path stays, but becomes one beside it if the run is not complete
  /// and another result is there already.
  void begin_writing(std::initializer_list<std::string*> paths, bool complete);

  /// Why a run is not complete, for the beginning of a line; empty if it is.
  [[nodiscard]] std::string reason(bool complete) const;
  /// @throws Error{kTimeLimit} if the run was told to stop; the best mesh so far is at `path`.
  void check_complete(bool complete, const std::string& path) const;
  /// lumesh::require_sound() of the mesh that was written, then this.
  void require_sound(const std::string& path, const MeshView& mesh, Context& context, bool complete,
                     const MeshView* made_from = nullptr) const;

 private:
  Program& program_;
};

}  // namespace lumesh::cli
