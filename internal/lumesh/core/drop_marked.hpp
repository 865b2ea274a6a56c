#pragma once
/// @file Lists without some of their items.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lumesh {

/// Leaves out the values whose flag is not 0; the others keep their order.
template <class Value>
void drop_marked(std::span<const std::uint8_t> flags, std::vector<Value>& values) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (flags[i] == 0) values[kept++] = values[i];
  values.resize(kept);
}

}  // namespace lumesh
