#pragma once
/// @file Arrays on points, as readers find them.

#include <filesystem>
#include <span>
#include <string>

#include "lumesh/io/point_data_file.hpp"

namespace lumesh::io {

/// Adds an array of one or three components to those of `data`, whose points are read.
/// @throws Error{kBadInput} if it does not have as many values as there are points.
void keep_point_array(const std::filesystem::path& path, const std::string& name,
                      std::span<const double> values, std::size_t components, PointData& data);

}  // namespace lumesh::io
