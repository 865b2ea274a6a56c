#pragma once
/// @file What commands share that change a mesh by the operators: who works how on it, and what was done.

#include <CLI/CLI.hpp>

#include "common.hpp"
#include "lumesh/adapt/adapt.hpp"

namespace lumesh::cli {

/// --topology, for measurements; not in the help.
void add_topology_option(CLI::App& command, parallel::TeamOptions& team);

/// Threads as the user gave them: 0 stands for all cores.
[[nodiscard]] int threads_of(const RunOptions& run);

/// What each thread did, on stderr, with -v.
void print_counts(const RunOptions& run, const operators::ExecutionCounts& counts);

}  // namespace lumesh::cli
