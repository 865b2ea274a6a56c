// A plugin whose options cannot be read, and that says so in C++.
#include <stdexcept>

#include "lumesh/sizing.h"

LUMESH_SIZING_EXPORT int lumesh_sizing_abi_version() {
  return LUMESH_SIZING_ABI_VERSION;
}

LUMESH_SIZING_EXPORT int lumesh_sizing_create(const char* /*options*/, void** /*state*/, char* /*message*/,
                                              size_t /*message_size*/) {
  throw std::runtime_error("no such landmarks");
}

LUMESH_SIZING_EXPORT double lumesh_size_at(void* /*state*/, double /*x*/, double /*y*/, double /*z*/) {
  return 1;
}
