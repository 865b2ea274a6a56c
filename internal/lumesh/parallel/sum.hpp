#pragma once
/// @file Sums and extremes over many items, bitwise identical for every thread count.

#include <algorithm>
#include <cstddef>
#include <functional>

#include "lumesh/parallel/loops.hpp"

namespace lumesh::parallel {

/// reduce_blocks() by single indices: add(value, i) takes i into the value of its block, which begins as
/// `identity`.
template <class Value, class Add, class Combine>
[[nodiscard]] Value reduce(std::size_t count, std::size_t block, const Value& identity, const Add& add,
                           const Combine& combine) {
  return reduce_blocks(
      count, block, identity,
      [&](std::size_t begin, std::size_t end) {
        Value value = identity;
        for (std::size_t i = begin; i < end; ++i) add(value, i);
        return value;
      },
      combine);
}

/// Sum of value_of(i) for i in [0, count), block by block.
template <class Value, class ValueOf>
[[nodiscard]] Value sum(std::size_t count, std::size_t block, const ValueOf& value_of) {
  return reduce(
      count, block, Value{}, [&](Value& of_block, std::size_t i) { of_block = of_block + value_of(i); },
      std::plus<>());
}

/// The largest value_of(i) for i in [0, count), and at least `least`.
template <class Value, class ValueOf>
[[nodiscard]] Value max_of(std::size_t count, std::size_t block, const Value& least,
                           const ValueOf& value_of) {
  const auto larger = [](const Value& a, const Value& b) { return std::max(a, b); };
  return reduce(
      count, block, least, [&](Value& most, std::size_t i) { most = larger(most, value_of(i)); }, larger);
}

/// The smallest value_of(i) for i in [0, count), and at most `most`.
template <class Value, class ValueOf>
[[nodiscard]] Value min_of(std::size_t count, std::size_t block, const Value& most, const ValueOf& value_of) {
  const auto smaller = [](const Value& a, const Value& b) { return std::min(a, b); };
  return reduce(
      count, block, most, [&](Value& least, std::size_t i) { least = smaller(least, value_of(i)); }, smaller);
}

/// Adds up one number for each of several things: how reduce() combines such lists.
struct AddEach {
  template <class Numbers>
  [[nodiscard]] Numbers operator()(Numbers all, const Numbers& more) const {
    for (std::size_t i = 0; i < all.size(); ++i) all[i] += more[i];
    return all;
  }
};

}  // namespace lumesh::parallel
