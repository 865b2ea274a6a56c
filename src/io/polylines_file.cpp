#include "lumesh/io/polylines_file.hpp"

#include <fmt/format.h>

#include <cstring>

#include "lumesh/core/error.hpp"
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
  writer.array({"connectivity", "Int32", 1, vertices.size()},
               [&](std::size_t first, std::size_t last, std::byte* out) {
                 std::memcpy(out, vertices.data() + first, (last - first) * sizeof(vertices[0]));
               });
  writer.array({"offsets", "Int64", 1, ends.size()},
               [&](std::size_t first, std::size_t last, std::byte* out) {
                 std::memcpy(out, ends.data() + first, (last - first) * sizeof(ends[0]));
               });
  writer.print("</Lines>\n");
}

void check_arrays(const std::filesystem::path& path, const Polylines& lines) {
  const auto check = [&](const std::string& name, std::size_t size) {
    if (size != lines.points.size())
      throw Error(ErrorKind::kBadInput, fmt::format("{}: array {} has {} values for {} points", path.string(),
                                                    name, size, lines.points.size()));
  };
  for (const auto& [name, values] : lines.scalars) check(name, values.size());
  for (const auto& [name, values] : lines.vectors) check(name, values.size());
}

}  // namespace

void write_polylines(const std::filesystem::path& path, const Polylines& lines, const MeshInfo& info) {
  if (path.extension() != ".vtp")
    throw Error(ErrorKind::kBadInput, fmt::format("{}: lines are written as .vtp", path.string()));
  check_arrays(path, lines);
  io::VtkXmlWriter writer(path, "PolyData");
  writer.print("<FieldData>\n");
  writer.info_arrays(info);
  writer.print("</FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"{}\" ",
               lines.points.size(), lines.lines.size());
  writer.print("NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n<PointData>\n");
  for (const auto& [name, values] : lines.scalars) {
    writer.array({name, "Float64", 1, values.size()},
                 [&](std::size_t first, std::size_t last, std::byte* out) {
                   std::memcpy(out, values.data() + first, (last - first) * sizeof(double));
                 });
  }
  for (const auto& [name, values] : lines.vectors) {
    writer.array({name, "Float64", 3, values.size()},
                 [&](std::size_t first, std::size_t last, std::byte* out) {
                   std::memcpy(out, values.data() + first, (last - first) * sizeof(Vec3));
                 });
  }
  writer.print("</PointData>\n");
  writer.points(lines.points);
  write_lines(writer, lines);
  writer.print("</Piece>\n");
  writer.commit();
}

}  // namespace lumesh
