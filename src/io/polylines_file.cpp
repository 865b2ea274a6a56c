#include "lumesh/io/polylines_file.hpp"

#include <fmt/format.h>

#include "file_fault.hpp"
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
  writer.print("<Lines>\n");
  writer.numbers("connectivity", vertices);
  writer.numbers("offsets", ends);
  writer.print("</Lines>\n");
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
  writer.print("</FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"{}\" ",
               lines.points.size(), lines.lines.size());
  writer.print("NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n<PointData>\n");
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
  const std::vector<double> xyz =
      file.doubles(file.piece().child("Points").child("DataArray"), "point coordinates");
  if (xyz.size() != 3 * file.count("NumberOfPoints")) file.fail(io::kFewPoints);
  for (std::size_t i = 0; i < xyz.size(); i += 3) lines.points.emplace_back(xyz[i], xyz[i + 1], xyz[i + 2]);
  const pugi::xml_node node = file.piece().child("Lines");
  const auto corners = file.integers(io::VtkXmlReader::find_array(node, "connectivity"), "line connectivity");
  const auto ends = file.integers(io::VtkXmlReader::find_array(node, "offsets"), "line offsets");
  std::int64_t begin = 0;
  for (const std::int64_t end : ends) {
    if (end < begin || end > static_cast<std::int64_t>(corners.size()))
      file.fail("its line offsets are damaged");
    std::vector<std::uint32_t>& line = lines.lines.emplace_back();
    for (; begin < end; ++begin) {
      const std::int64_t v = corners[static_cast<std::size_t>(begin)];
      if (v < 0 || v >= static_cast<std::int64_t>(lines.points.size()))
        file.fail("a line refers to a point that is not there");
      line.push_back(static_cast<std::uint32_t>(v));
    }
  }
  if (lines.lines.empty()) file.fail("holds no line");
  for (const pugi::xml_node& array : file.piece().child("PointData").children("DataArray")) {
    const std::string name = array.attribute("Name").value();
    std::vector<double> values = file.doubles(array, name.c_str());
    if (values.size() == lines.points.size()) {
      lines.scalars[name] = std::move(values);
    } else if (values.size() == 3 * lines.points.size()) {
      for (std::size_t i = 0; i < values.size(); i += 3)
        lines.vectors[name].emplace_back(values[i], values[i + 1], values[i + 2]);
    }
  }
  return lines;
}

}  // namespace lumesh
