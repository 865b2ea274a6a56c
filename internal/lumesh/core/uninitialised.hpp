#pragma once
/// @file Large arrays that threads fill: without writing zeros first, on one thread.

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace lumesh {

/// An allocator as std::allocator, but new items are default-initialised: numbers are left as they are.
template <class Item>
struct UninitialisedAllocator : std::allocator<Item> {
  template <class Other>
  struct rebind {
    using other = UninitialisedAllocator<Other>;
  };
  UninitialisedAllocator() = default;
  template <class Other>
  explicit(false) UninitialisedAllocator(const UninitialisedAllocator<Other>& /*other*/) {}

  template <class Other>
  void construct(Other* place) {
    ::new (static_cast<void*>(place)) Other;
  }
  template <class Other, class... Arguments>
  void construct(Other* place, Arguments&&... arguments) {
    ::new (static_cast<void*>(place)) Other(std::forward<Arguments>(arguments)...);
  }
};

/// A vector of numbers; resize() leaves the new ones to be written.
template <class Item>
using UninitialisedVector = std::vector<Item, UninitialisedAllocator<Item>>;

}  // namespace lumesh
