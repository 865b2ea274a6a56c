#pragma once
/// @file Which execution the passes run by.

#include <cstdint>

#include "lumesh/parallel/team.hpp"

namespace lumesh {

class OptionList;

/// How threads share a mesh that all of them change.
enum class ExecutionKind : std::uint8_t {
  kOrdered,      ///< operators::OrderedExecution: bitwise identical for every thread count.
  kSpeculative,  ///< operators::SpeculativeExecution.
};

/// The options `execution`, `balance` and `pin` of stages that change a mesh by the operators.
void describe_execution(OptionList& list, ExecutionKind& execution, parallel::TeamOptions& team);

}  // namespace lumesh
