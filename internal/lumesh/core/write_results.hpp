#pragma once
/// @file The step in which a command writes what it made.

#include "lumesh/core/context.hpp"

namespace lumesh {

/// Runs `write` as the phase "write". A stop that comes from now on is too late: all results are written.
/// @throws parallel::Cancelled if one came before, with nothing written.
template <class Write>
void write_results(Context& context, const Write& write) {
  context.results_exist();
  context.phase("write", write);
}

}  // namespace lumesh
