#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "cell_blocks.hpp"
#include "label_arrays.hpp"
#include "mesh_formats.hpp"
#include "mesh_info_json.hpp"
#include "metric_tensors.hpp"
#include "point_arrays.hpp"
#include "polygons.hpp"
#include "vtk_xml_reader.hpp"

namespace lumesh::io {

namespace {

/// Labels of cells, which are numbers of patches where the cells are faces.
struct CellLabels {
  std::vector<std::int64_t> of_cell;
  std::string array;  ///< Empty where there is none.
};

CellLabels read_labels(const VtkXmlReader& file, std::size_t cells) {
  const pugi::xml_node data = file.piece().child("CellData");
  for (const char* name : kLabelArrays) {
    const pugi::xml_node array = VtkXmlReader::find_array(data, name);
    if (!array) continue;
    std::vector<std::int64_t> labels = file.integers(array, name);
    if (labels.size() != cells) file.fail("does not hold as many labels as cells");
    const auto fits = [](std::int64_t label) { return label >= INT32_MIN && label <= INT32_MAX; };
    if (!std::ranges::all_of(labels, fits)) file.fail("a label is too large");
    return {std::move(labels), name};
  }
  return {std::vector<std::int64_t>(cells, 1), ""};
}

/// @return  The array of their labels.
std::string read_cells(const VtkXmlReader& file, MixedMesh& mesh) {
  const std::size_t cells = file.count("NumberOfCells");
  const CellCorners corners = file.cells("Cells");
  const auto types =
      file.integers(VtkXmlReader::find_array(file.piece().child("Cells"), "types"), "cell types");
  if (corners.ends.size() != cells || types.size() != cells)
    file.fail("does not hold as many cells as it says");
  CellLabels labels = read_labels(file, cells);
  std::size_t c = 0;
  for_each_cell(file.path(), corners, [&](std::span<const std::int64_t> cell) {
    add_vtk_cell(file.path(), types[c], cell, static_cast<Label>(labels.of_cell[c]), mesh);
    ++c;
  });
  return std::move(labels.array);
}

template <std::size_t N>
void read_faces(const VtkXmlReader& file, std::size_t block, std::size_t points, std::vector<Cell<N>>& faces,
                std::vector<std::int32_t>& patches) {
  const char *const name = kFaceArrays[block], *const patch_name = kFacePatchArrays[block];
  const pugi::xml_node fields = file.dataset().child("FieldData");
  const pugi::xml_node array = VtkXmlReader::find_array(fields, name);
  if (!array) return;
  const auto corners = file.integers(array, name);
  const auto tags = file.integers(VtkXmlReader::find_array(fields, patch_name), patch_name);
  take_vtk_faces(file.path(), corners, tags, patch_name, kPatchEnd, points, faces, patches);
}

void read_info(const VtkXmlReader& file, MixedMesh& mesh) {
  const pugi::xml_node array = VtkXmlReader::find_array(file.dataset().child("FieldData"), "lumesh_info");
  if (array) mesh.info = info_from_json(file.text(array));
}

std::vector<SymTensor> read_metric_array(const std::filesystem::path& path, const VtkXmlReader& file,
                                         std::size_t points) {
  const pugi::xml_node array = VtkXmlReader::find_array(file.piece().child("PointData"), "metric");
  if (!array) return {};
  return metric_from_vtk(path, file.doubles(array, "metric"),
                         array.attribute("NumberOfComponents").as_uint(1), points);
}

std::vector<double> read_sizes(const VtkXmlReader& file, std::size_t points) {
  const pugi::xml_node array = VtkXmlReader::find_array(file.piece().child("PointData"), "size");
  if (!array || array.attribute("NumberOfComponents").as_uint(1) != 1) return {};
  std::vector<double> sizes = file.doubles(array, "size");
  if (sizes.size() != points) file.fail(kFewSizes);
  return sizes;
}

MixedMesh read_points_and_info(const VtkXmlReader& file) {
  MixedMesh mesh;
  mesh.points = file.points();
  read_info(file, mesh);
  return mesh;
}

}  // namespace

MixedMesh read_vtk_xml_points(const std::filesystem::path& path, std::string_view dataset_type) {
  return read_points_and_info(VtkXmlReader(path, dataset_type));
}

PointData read_vtk_xml_point_data(const std::filesystem::path& path, std::string_view dataset_type) {
  const VtkXmlReader file(path, dataset_type);
  MixedMesh mesh = read_points_and_info(file);
  PointData data;
  data.points = std::move(mesh.points);
  data.info = std::move(mesh.info);
  keep_point_arrays(file, data);
  return data;
}

MixedMesh read_vtu(const std::filesystem::path& path) {
  const VtkXmlReader file(path, "UnstructuredGrid");
  MixedMesh mesh;
  mesh.points = file.points();
  mesh.metric = read_metric_array(path, file, mesh.points.size());
  mesh.sizes_mm = read_sizes(file, mesh.points.size());
  const std::string labels = read_cells(file, mesh);
  read_info(file, mesh);
  read_faces(file, 0, mesh.points.size(), mesh.triangles, mesh.triangle_patches);
  read_faces(file, 1, mesh.points.size(), mesh.quadrilaterals, mesh.quadrilateral_patches);
  complete_patches(path, mesh, labels);
  return mesh;
}

namespace {

CellArrays cell_arrays(const VtkXmlReader& file) {
  const pugi::xml_node cells = file.piece().child("CellData");
  CellArrays arrays;
  for (const pugi::xml_node& array : cells.children("DataArray"))
    arrays.names.emplace_back(array.attribute("Name").value());
  arrays.find = [&file, cells](const std::string& name) -> std::optional<std::vector<std::int64_t>> {
    const pugi::xml_node found = VtkXmlReader::find_array(cells, name.c_str());
    if (!found) return std::nullopt;
    return file.integers(found, name.c_str());
  };
  return arrays;
}

/// @param patch_array  Empty: the first of those that are known.
MixedMesh read_polygons(const std::filesystem::path& path, const std::string& patch_array,
                        const Context& context) {
  const VtkXmlReader file(path, "PolyData");
  MixedMesh mesh;
  mesh.points = file.points();
  read_info(file, mesh);
  Polygons polygons;
  polygons.polygons = file.cells("Polys");
  const auto count = [&](const char* attribute) { return file.piece().attribute(attribute).as_uint(0); };
  if (count("NumberOfStrips") > 0) polygons.strips = file.cells("Strips");
  polygons.cells_before = std::size_t{count("NumberOfVerts")} + count("NumberOfLines");
  add_polygons(path, polygons, cell_arrays(file), patch_array, context, mesh);
  return mesh;
}

}  // namespace

MixedMesh read_vtp_surface(const std::filesystem::path& path) {
  return read_polygons(path, "", Context());
}

MixedMesh read_vtp_surface_by(const std::filesystem::path& path, const std::string& patch_array,
                              const Context& context) {
  return read_polygons(path, patch_array, context);
}

}  // namespace lumesh::io
