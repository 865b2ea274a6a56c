#pragma once
/// @file A map that many threads may add to.

#include <tbb/concurrent_unordered_map.h>

#include <functional>
#include <memory>
#include <utility>

namespace lumesh::parallel {

/// Finding and adding from any thread at once; nothing is taken out. The first value of a key stays.
/// The allocator of the language: ThreadSanitizer does not see into that of oneTBB.
template <class Key, class Value, class Hash>
using ConcurrentMap = tbb::concurrent_unordered_map<Key, Value, Hash, std::equal_to<Key>,
                                                    std::allocator<std::pair<const Key, Value>>>;

}  // namespace lumesh::parallel
