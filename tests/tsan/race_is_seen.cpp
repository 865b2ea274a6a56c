/// @file A race between two bodies of one loop, on purpose: shows that the ThreadSanitizer build would see
/// ours.

#include <cstdio>

#include "lumesh/parallel/loops.hpp"

int main() {
  int sum = 0;
  lumesh::parallel::for_each_index(100'000, [&](std::size_t i) { sum += static_cast<int>(i % 7); });
  std::printf("%d\n", sum);
}
