// OFF of Geomview: points and polygons of a surface, text; no place for patches.
#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include "cell_blocks.hpp"
#include "file_fault.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/mesh/points_in_use.hpp"
#include "mesh_builder.hpp"
#include "mesh_formats.hpp"
#include "output_file.hpp"
#include "unit_and_frame.hpp"
#include "unpacked_file.hpp"

namespace lumesh::io {

namespace {

constexpr std::size_t kHeaderLines = 10;

/// Lines without comments; what follows the numbers of a point or polygon, such as its colour, is left out.
class OffReader {
 public:
  explicit OffReader(const std::filesystem::path& path) : path_(path), in_(unpacked_file(path)) {}

  MixedMesh read() {
    next_line();
    std::string word;
    line_ >> word;
    if (word != "OFF") fail_here("the first word is not OFF, normals or colours of points are not read");
    if ((line_ >> std::ws).eof()) next_line();
    const std::int64_t points = integer("the number of points"), polygons = integer("the number of polygons");
    for (std::int64_t i = 0; i < points; ++i) {
      next_line();
      Vec3 p;
      if (!(line_ >> p.x() >> p.y() >> p.z())) fail_here("a point is damaged");
      builder_.add_point(p);
    }
    for (std::int64_t i = 0; i < polygons; ++i) read_polygon();
    if (polygons == 0) fail_here("holds no polygon");
    builder_.name_patch(0, kWallName);
    MixedMesh mesh = builder_.finish();
    read_unit_and_frame(comments_, mesh.info);
    return mesh;
  }

 private:
  [[noreturn]] void fail_here(std::string_view what) const { fail_at_line(path_, line_number_, what); }

  /// The next line that holds a word.
  void next_line() {
    for (std::string line; std::getline(in_, line);) {
      ++line_number_;
      const std::size_t comment = std::min(line.find('#'), line.size());
      if (line_number_ <= kHeaderLines) comments_ += line.substr(comment) + '\n';
      line.resize(comment);
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
      line_ = std::istringstream(line);
      return;
    }
    fail_here("the file is cut off");
  }

  std::int64_t integer(std::string_view what) {
    std::int64_t value = 0;
    if (!(line_ >> value) || value < 0) fail_here(fmt::format("{} is damaged", what));
    return value;
  }

  void read_polygon() {
    next_line();
    const std::int64_t size = integer("a polygon's number of corners");
    std::vector<std::int64_t> corners;
    for (std::int64_t k = 0; k < size; ++k) corners.push_back(integer("a corner"));
    if (size < 3) fail_here(kFewCorners);
    builder_.add_polygon(corners, 0);
  }

  const std::filesystem::path& path_;
  std::istringstream in_, line_;
  std::size_t line_number_ = 0;
  std::string comments_;  // Of the first lines.
  MeshBuilder builder_{path_};
};

}  // namespace

MixedMesh read_off(const std::filesystem::path& path) {
  return OffReader(path).read();
}

void write_off(const std::filesystem::path& path, const MeshView& mesh) {
  PointNumbers numbers(mesh.points.size());
  std::size_t faces = 0;
  for (const CellBlock& block : face_blocks(mesh)) {
    faces += block.size();
    for (const std::uint32_t v : block.vertices) numbers.of(v);
  }
  if (faces == 0) fail(path, kNoFaces);
  OutputFile file(path);
  file.print("OFF\n# {}\n{} {} 0\n", unit_and_frame(*mesh.info), numbers.points().size(), faces);
  for (const std::uint32_t v : numbers.points())
    file.print("{} {} {}\n", mesh.points[v].x(), mesh.points[v].y(), mesh.points[v].z());
  for (const CellBlock& block : face_blocks(mesh)) {
    for (std::size_t f = 0; f < block.size(); ++f) {
      file.print("{}", block.corners);
      for (const std::uint32_t v : block.cell(f)) file.print(" {}", numbers.of(v));
      file.print("\n");
    }
  }
  file.commit();
}

}  // namespace lumesh::io
