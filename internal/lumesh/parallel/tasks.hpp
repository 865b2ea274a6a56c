#pragma once
/// @file Tasks that run loops of their own.

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstddef>

#include "lumesh/parallel/cancellation.hpp"

namespace lumesh::parallel {

/// Calls body(i) for every i in [0, count), several at a time; bodies may use the loops of loops.hpp. A
/// thread that waits in such a loop does not begin another body meanwhile, so that no more bodies are under
/// way than there are threads.
template <class Body>
void for_each_task(std::size_t count, const Body& body) {
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    if (!is_cancelled()) tbb::this_task_arena::isolate([&] { body(i); });
  });
  check_cancelled();
}

}  // namespace lumesh::parallel
