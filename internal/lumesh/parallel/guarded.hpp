#pragma once
/// @file A value that threads look at and change one at a time.

#include <mutex>

namespace lumesh::parallel {

template <class Value>
class Guarded {
 public:
  /// The result of use(value); no other use runs meanwhile.
  template <class Use>
  decltype(auto) with(const Use& use) {
    const std::lock_guard lock(mutex_);
    return use(value_);
  }

 private:
  std::mutex mutex_;
  Value value_;
};

}  // namespace lumesh::parallel
