#pragma once
/// @file Which execution the passes run by.

#include <cstdint>

namespace lumesh {

/// How threads share a mesh that all of them change.
enum class ExecutionKind : std::uint8_t {
  kOrdered,      ///< operators::OrderedExecution: the same bits for every number of threads.
  kSpeculative,  ///< operators::SpeculativeExecution.
};

}  // namespace lumesh
