// A plugin with sizes alone, that the build gives.
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "lumesh/sizing.h"

namespace {

[[maybe_unused]] double busy(std::chrono::microseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < end) {
  }
  return 1;
}

}  // namespace

LUMESH_SIZING_EXPORT int lumesh_sizing_abi_version() {
  return LUMESH_SIZING_ABI_VERSION;
}

LUMESH_SIZING_EXPORT double lumesh_size_at(void* /*state*/, [[maybe_unused]] double x, double /*y*/,
                                           double /*z*/) {
  return ANSWER;
}
