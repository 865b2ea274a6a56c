#include "lumesh/io/polylines_file.hpp"

#include <fmt/format.h>

#include "file_fault.hpp"
#include "lumesh/io/file_formats.hpp"
#include "point_arrays.hpp"
#include "polygons.hpp"
#include "vtk_xml_reader.hpp"
#include "vtk_xml_writer.hpp"

namespace lumesh {

namespace {

void write_lines(io::VtkXmlWriter& writer, const Polylines& lines) {
  std::vector<std::int64_t> ends;
  std::vector<std::uint32_t> vertices;
  for (const auto& line : lines.lines) {
    vertices.insert(vertices.end(), line.begin(), line.end());
    ends.push_back(static_cast<std::int64_t>(vertices.size()));
  }
  writer.cells("Lines", vertices, ends);
}

void check_arrays(const std::filesystem::path& path, const Polylines& lines) {
  const auto check = [&](const std::string& name, std::size_t size) {
    if (size != lines.points.size())
      io::fail(path, fmt::format("array {} has {} values for {} points", name, size, lines.points.size()));
  };
  for (const auto& [name, values] : lines.scalars) check(name, values.size());
  for (const auto& [name, values] : lines.vectors) check(name, values.size());
}

}  // namespace

void write_polylines(const std::filesystem::path& path, const Polylines& lines, const MeshInfo& info) {
  require_format(path, FileUse::kLines, ErrorKind::kUsage);
  check_arrays(path, lines);
  io::VtkXmlWriter writer(path, "PolyData");
  writer.print("<FieldData>\n");
  writer.info_arrays(info);
  writer.print("</FieldData>\n");
  writer.begin_poly_data(lines.points.size(), lines.lines.size(), 0);
  writer.print("<PointData>\n");
  for (const auto& [name, values] : lines.scalars) writer.numbers(name, values);
  for (const auto& [name, values] : lines.vectors) writer.vectors(name, values);
  writer.print("</PointData>\n");
  writer.points(lines.points);
  write_lines(writer, lines);
  writer.print("</Piece>\n");
  writer.commit();
}

Polylines read_polylines(const std::filesystem::path& path) {
  io::check_file(path);
  const io::VtkXmlReader file(path, "PolyData");
  Polylines lines;
  lines.points = file.points();
  io::for_each_cell(path, file.cells("Lines"), [&](std::span<const std::int64_t> corners) {
    std::vector<std::uint32_t>& line = lines.lines.emplace_back();
    for (const std::int64_t v : corners) {
      if (v < 0 || v >= std::ssize(lines.points)) file.fail("a line refers to a point that is not there");
      line.push_back(static_cast<std::uint32_t>(v));
    }
  });
  if (lines.lines.empty()) file.fail("holds no line");
  io::keep_point_arrays(file, lines);
  return lines;
}

}  // namespace lumesh
