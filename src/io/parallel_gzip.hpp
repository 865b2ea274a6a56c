#pragma once
/// @file Gzip in parallel, as one ordinary gzip member.

#include <cstddef>
#include <functional>

#include "output_file.hpp"

namespace lumesh::io {

/// Writes `bytes` bytes, which fill(first, last, out) makes part by part, as one gzip stream. Bitwise
/// identical for every thread count. Memory: a few MB.
void write_gzip(OutputFile& file, std::size_t bytes,
                const std::function<void(std::size_t first, std::size_t last, std::byte* out)>& fill);

}  // namespace lumesh::io
