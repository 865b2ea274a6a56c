// XDMF for FEniCS: one pair of files for the cells with their labels, one for the boundary faces with their
// patches, and the names of the tags as JSON. Both pairs hold all points, since dolfinx finds the vertices of
// faces by their numbers in the mesh. It takes one shape of cell per file and the first attribute of a grid.
#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "file_fault.hpp"
#include "hdf5_image.hpp"
#include "lumesh/core/version.hpp"
#include "mesh_formats.hpp"
#include "mesh_info_json.hpp"
#include "output_file.hpp"
#include "vtk_xml_writer.hpp"

namespace lumesh::io {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// One grid: its two files, and the cells it holds with their tags.
struct Grid {
  fs::path light;  ///< XML that describes the arrays.
  fs::path heavy;  ///< The arrays; dolfinx looks for them under this name, whatever the XML says.
  std::string_view shape;
  std::size_t corners;
  std::span<const std::int32_t> cells;
  std::span<const std::int32_t> tags;
  const char* tag_name;
};

fs::path beside(const fs::path& path, const std::string& ending) {
  return path.parent_path() / (path.stem().string() + ending);
}

void write_light(OutputFile& file, const MeshView& mesh, const Grid& grid) {
  const std::string heavy = xml_escaped(grid.heavy.filename().string());
  file.print("<?xml version=\"1.0\"?>\n<!-- lumesh {} -->\n<Xdmf Version=\"3.0\">\n<Domain>\n", kVersion);
  file.print("<Grid Name=\"Grid\" GridType=\"Uniform\">\n<Geometry GeometryType=\"XYZ\">\n");
  file.print("<DataItem DataType=\"Float\" Dimensions=\"{} 3\" Format=\"HDF\" Precision=\"8\">{}:/points",
             mesh.points.size(), heavy);
  file.print("</DataItem>\n</Geometry>\n");
  file.print("<Topology TopologyType=\"{}\" NumberOfElements=\"{}\" NodesPerElement=\"{}\">\n", grid.shape,
             grid.tags.size(), grid.corners);
  file.print("<DataItem DataType=\"Int\" Dimensions=\"{} {}\" Format=\"HDF\" Precision=\"4\">{}:/cells",
             grid.tags.size(), grid.corners, heavy);
  file.print("</DataItem>\n</Topology>\n");
  file.print("<Attribute Name=\"{}\" AttributeType=\"Scalar\" Center=\"Cell\">\n", grid.tag_name);
  file.print("<DataItem DataType=\"Int\" Dimensions=\"{}\" Format=\"HDF\" Precision=\"4\">{}:/{}",
             grid.tags.size(), heavy, grid.tag_name);
  file.print("</DataItem>\n</Attribute>\n</Grid>\n</Domain>\n</Xdmf>\n");
}

void write_heavy(OutputFile& file, const MeshView& mesh, const Grid& grid) {
  Hdf5Image image;
  image.add("points", {reinterpret_cast<const double*>(mesh.points.data()), 3 * mesh.points.size()}, 3);
  image.add("cells", grid.cells, grid.corners);
  image.add(grid.tag_name, grid.tags, 1);
  const std::vector<std::byte> bytes = image.finish();
  file.write(bytes.data(), bytes.size());
}

/// Vertex indices are below 2^31 (checked), so their bits serve as signed numbers.
template <std::size_t N>
std::span<const std::int32_t> indices_of(std::span<const Cell<N>> cells) {
  return {reinterpret_cast<const std::int32_t*>(cells.data()), N * cells.size()};
}

std::string tags_as_json(const MeshView& mesh, const Grid& cells, const Grid& facets) {
  const json info = json::parse(info_to_json(*mesh.info));
  json cell_tags = json::array();
  for (const Label label : std::set<Label>(mesh.tetrahedron_labels.begin(), mesh.tetrahedron_labels.end())) {
    const std::string unnamed = fmt::format("label_{}", label);
    cell_tags.push_back(
        {{"tag", label}, {"name", info["label_names"].value(std::to_string(label), unnamed)}});
  }
  json facet_tags = json::array();
  for (const json& patch : info["patches"]) {
    json entry = patch;
    entry["tag"] = facet_tags.size() + 1;
    facet_tags.push_back(std::move(entry));
  }
  const json all = {{"cells", cells.light.filename().string()},
                    {"facets", facets.light.filename().string()},
                    {"cell_tags", cell_tags},
                    {"facet_tags", facet_tags},
                    {"unit", info["unit"]},
                    {"frame", info["frame"]},
                    {"provenance", info["provenance"]}};
  return all.dump(2, ' ', true, json::error_handler_t::replace) + "\n";
}

}  // namespace

void write_xdmf(const fs::path& path, const MeshView& mesh) {
  // The name of the HDF5 file and that of the array in it stand behind each other with a colon between.
  if (path.filename().string().find(':') != std::string::npos)
    fail(path, "readers of XDMF split names at a colon; choose a name without");
  std::vector<std::int32_t> facet_tags(mesh.triangle_patches.begin(), mesh.triangle_patches.end());
  for (std::int32_t& tag : facet_tags) ++tag;
  const std::string extension = path.extension().string();
  const Grid cells = {path,
                      beside(path, ".h5"),
                      "Tetrahedron",
                      4,
                      indices_of<4>(mesh.tetrahedra),
                      mesh.tetrahedron_labels,
                      "cell_tags"};
  const Grid facets = {beside(path, "_facets" + extension),
                       beside(path, "_facets.h5"),
                       "Triangle",
                       3,
                       indices_of<3>(mesh.triangles),
                       facet_tags,
                       "facet_tags"};
  OutputFile tags(beside(path, "_tags.json"));
  OutputFile cells_light(cells.light);
  OutputFile cells_heavy(cells.heavy);
  OutputFile facets_light(facets.light);
  OutputFile facets_heavy(facets.heavy);
  tags.write(tags_as_json(mesh, cells, facets));
  write_light(cells_light, mesh, cells);
  write_heavy(cells_heavy, mesh, cells);
  write_light(facets_light, mesh, facets);
  write_heavy(facets_heavy, mesh, facets);
  // All are complete before the first takes its name, so that a full disk leaves the files of before.
  const std::array<OutputFile*, 5> files = {&cells_heavy, &facets_heavy, &facets_light, &tags, &cells_light};
  for (OutputFile* file : files) file->flush();
  for (OutputFile* file : files) file->commit();
}

}  // namespace lumesh::io
