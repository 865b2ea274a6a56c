#include "lumesh/io/points_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "file_fault.hpp"
#include "format_table.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "mesh_formats.hpp"
#include "text_scanner.hpp"
#include "text_table.hpp"

namespace lumesh {

namespace {

std::vector<std::string_view> fields_of(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r\"";
  constexpr std::string_view kSeparators = ",;";
  std::vector<std::string_view> fields;
  for (std::size_t at = 0; at < line.size();) {
    const bool is_blank = kBlanks.find(line[at]) != std::string_view::npos;
    if (is_blank || kSeparators.find(line[at]) != std::string_view::npos) {
      ++at;
      continue;
    }
    const std::size_t end = std::min(line.find_first_of(" \t\r\",;", at), line.size());
    fields.push_back(line.substr(at, end - at));
    at = end;
  }
  return fields;
}

std::vector<Vec3> points_of_text(const std::filesystem::path& path) {
  const std::string content = io::read_whole_file(path);
  std::vector<Vec3> points;
  io::PlaceColumns columns = {0, 1, 2};
  bool is_first = true;
  io::for_each_line(content, [&](std::string_view line, std::size_t number) {
    const std::vector<std::string_view> fields = fields_of(line);
    if (fields.empty() || fields[0].starts_with('#')) return;
    const bool names = is_first && std::ranges::none_of(fields, [](std::string_view f) {
                         return io::real_from(f).has_value();
                       });
    is_first = false;
    if (names) {
      columns = io::place_columns(fields);
      return;
    }
    Vec3 p = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (columns[axis] < fields.size())
        p[static_cast<int>(axis)] =
            io::real_from(fields[columns[axis]]).value_or(std::numeric_limits<double>::quiet_NaN());
    if (!p.allFinite())
      io::fail(path, fmt::format("line {}: three finite numbers x y z are wanted, in mm; give three columns",
                                 number));
    points.push_back(p);
  });
  return points;
}

}  // namespace

MixedMesh io::read_text_points(const std::filesystem::path& path) {
  MixedMesh cloud;
  cloud.points = points_of_text(path);
  return cloud;
}

MixedMesh read_points(const std::filesystem::path& path) {
  io::check_file(path);
  const io::FileFormat::Code& code = io::format_of(path, FileUse::kPoints).code;
  MixedMesh cloud;
  if (code.read_points != nullptr) {
    cloud = code.read_points(path);
  } else {
    MixedMesh mesh = read_mesh(path);
    cloud.points = std::move(mesh.points);
    cloud.info = std::move(mesh.info);
  }
  if (cloud.points.empty()) io::fail(path, "holds no points; give one per line");
  return cloud;
}

}  // namespace lumesh
