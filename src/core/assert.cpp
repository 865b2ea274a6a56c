#include "lumesh/core/assert.hpp"

#include <cstdio>
#include <cstdlib>

namespace lumesh::detail {

void assertion_failed(std::string_view condition, std::string_view file, int line) {
  std::fprintf(stderr, "lumesh: internal error, please report it: %.*s failed at %.*s:%d\n",
               static_cast<int>(condition.size()), condition.data(), static_cast<int>(file.size()),
               file.data(), line);
  std::abort();
}

}  // namespace lumesh::detail
