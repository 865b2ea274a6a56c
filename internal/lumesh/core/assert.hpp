#pragma once
/// @file Assertions at three prices. They guard against our own mistakes, never against bad input (see
/// error.hpp).

#include <string_view>

namespace lumesh::detail {
/// Prints the failed condition and its place to stderr and aborts.
[[noreturn]] void assertion_failed(std::string_view condition, std::string_view file, int line);
}  // namespace lumesh::detail

/// Cheap; on in every build.
#define LUMESH_ASSERT(condition) \
  ((condition) ? static_cast<void>(0) : ::lumesh::detail::assertion_failed(#condition, __FILE__, __LINE__))

/// On in debug builds only.
#ifdef NDEBUG
#define LUMESH_DEBUG_ASSERT(condition) static_cast<void>(0)
#else
#define LUMESH_DEBUG_ASSERT(condition) LUMESH_ASSERT(condition)
#endif

/// Whole checks of what was made; on in builds of the preset `paranoid` only.
#ifdef LUMESH_PARANOID
#define LUMESH_PARANOID_ASSERT(condition) LUMESH_ASSERT(condition)
#else
#define LUMESH_PARANOID_ASSERT(condition) static_cast<void>(sizeof((condition) ? 1 : 0))
#endif
