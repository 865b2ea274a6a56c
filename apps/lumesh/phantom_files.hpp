#pragma once
/// @file What the phantom command writes beside the image.

#include <filesystem>

#include "lumesh/image/phantom.hpp"

namespace lumesh::cli {

/// Writes the spec as JSON, beside the target and renamed when complete.
/// @throws Error{kBadInput} if it cannot be written; nothing is left behind then.
void write_parameters(const std::filesystem::path& path, const PhantomSpec& spec);

}  // namespace lumesh::cli
