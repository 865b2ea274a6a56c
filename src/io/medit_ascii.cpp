// Medit .mesh, as its programs (Mmg, FreeFEM, Gmsh) write it; counts from 1.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <span>
#include <string>

#include "cell_blocks.hpp"
#include "medit_rows.hpp"
#include "mesh_builder.hpp"
#include "mesh_formats.hpp"
#include "mesh_info_json.hpp"
#include "output_file.hpp"
#include "text_scanner.hpp"

namespace lumesh::io {

namespace {

constexpr std::string_view kInfoMark = "# lumesh_info ";

/// In short lines: some readers take lines of at most 255 characters.
void write_info(OutputFile& file, const MeshInfo& info) {
  constexpr std::size_t kLineLength = 160;
  const std::string json = info_to_json(info);
  for (std::size_t i = 0; i < json.size(); i += kLineLength)
    file.print("{}{}|\n", kInfoMark, std::string_view(json).substr(i, kLineLength));
}

MeshInfo read_info(std::string_view text) {
  std::string json;
  std::size_t at = text.find(kInfoMark);
  while (at != std::string_view::npos) {
    const std::size_t begin = at + kInfoMark.size();
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    json += line.substr(0, line.rfind('|'));
    at = text.substr(end, kInfoMark.size() + 1) == std::string("\n").append(kInfoMark) ? end + 1 : text.npos;
  }
  return info_from_json(json);
}

/// Sections we do not know: numbers up to the next keyword.
void skip_section(TextScanner& scanner, std::string_view keyword) {
  if (keyword.ends_with("P2"))
    scanner.fail("second order cells (" + std::string(keyword) + ") are not supported");
  const auto is_number = [](std::string_view word) {
    return !word.empty() && (std::isdigit(static_cast<unsigned char>(word[0])) != 0 || word[0] == '-' ||
                             word[0] == '+' || word[0] == '.');
  };
  while (is_number(scanner.peek())) scanner.word();
}

}  // namespace

void write_medit_ascii(const std::filesystem::path& path, const MeshView& mesh) {
  OutputFile file(path);
  file.print("MeshVersionFormatted 2\nDimension 3\n");
  write_info(file, *mesh.info);
  file.print("Vertices\n{}\n", mesh.points.size());
  for (const Vec3& p : mesh.points) file.print("{} {} {} 0\n", p.x(), p.y(), p.z());
  for_each_medit_row<std::int64_t>(
      mesh,
      [&](const CellBlock& block) {
        file.print("{}\n{}\n", names_of(block.shape).medit_keyword, block.size());
      },
      [&](std::span<const std::int64_t> row) { file.print("{}\n", fmt::join(row, " ")); });
  file.print("End\n");
  file.commit();
}

MixedMesh read_medit_ascii(const std::filesystem::path& path) {
  TextScanner scanner(path, '#');
  MeshBuilder builder(path);
  scanner.expect("MeshVersionFormatted");
  scanner.integer("the format's version");
  for (std::string_view keyword = scanner.word(); keyword != "End"; keyword = scanner.word()) {
    if (keyword.empty()) scanner.fail("\"End\" is missing, the file is cut off");
    if (keyword == "Dimension") {
      if (scanner.integer("the dimension") != 3) scanner.unsuitable("only meshes of dimension 3 can be read");
    } else if (keyword == "Vertices") {
      read_medit_vertices(scanner, scanner.count("the number of vertices", 4), builder);
    } else if (const ShapeNames* section = find_shape(&ShapeNames::medit_keyword, keyword)) {
      const std::size_t count = scanner.count("the number of cells", section->corners + 1);
      read_medit_cells(scanner, *section, count, builder);
    } else {
      skip_section(scanner, keyword);
    }
  }
  builder.set_info(read_info(scanner.text()));
  return builder.finish();
}

}  // namespace lumesh::io
