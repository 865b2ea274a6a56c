#pragma once
/// @file A map that many threads may add to.

#include <tbb/concurrent_unordered_map.h>

#include <cstddef>

namespace lumesh::parallel {

/// Finding and adding from any thread at once; nothing is taken out. The first value of a key stays.
template <class Key, class Value, class Hash>
using ConcurrentMap = tbb::concurrent_unordered_map<Key, Value, Hash>;

}  // namespace lumesh::parallel
