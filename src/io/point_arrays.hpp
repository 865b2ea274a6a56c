#pragma once
/// @file Arrays on points, as readers find them, into what has `points`, `scalars` and `vectors`: PointData,
/// Polylines.

#include <fmt/format.h>

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "file_fault.hpp"
#include "vtk_xml_reader.hpp"

namespace lumesh::io {

/// Adds an array of one or three components to those of `data`, whose points are read.
/// @throws Error{kBadInput} if it does not have as many values as there are points.
template <class Data>
void keep_point_array(const std::filesystem::path& path, const std::string& name,
                      std::span<const double> values, std::size_t components, Data& data) {
  if (values.size() != components * data.points.size())
    fail(path, fmt::format("array {} has {} values for {} points of {} components", name, values.size(),
                           data.points.size(), components));
  if (components == 1) {
    data.scalars[name].assign(values.begin(), values.end());
    return;
  }
  std::vector<Vec3>& vectors = data.vectors[name];
  vectors.clear();
  for (std::size_t i = 0; i < values.size(); i += 3)
    vectors.emplace_back(values[i], values[i + 1], values[i + 2]);
}

/// Adds those arrays of a file that have one or three components.
template <class Data>
void keep_point_arrays(const VtkXmlReader& file, Data& data) {
  for (const pugi::xml_node& array : file.piece().child("PointData").children("DataArray")) {
    const std::string name = array.attribute("Name").value();
    const unsigned components = array.attribute("NumberOfComponents").as_uint(1);
    if (components == 1 || components == 3)
      keep_point_array(file.path(), name, file.doubles(array, name.c_str()), components, data);
  }
}

}  // namespace lumesh::io
