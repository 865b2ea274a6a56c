#pragma once
/// @file A folder that goes away, a mesh with every shape of cell, and files made by hand.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::fixtures {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "lumesh-io-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path operator/(std::string_view name) const { return path_ / name; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::size_t file_count() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  std::filesystem::path path_;
};

inline std::filesystem::path write_file(const std::filesystem::path& path, std::string_view content) {
  std::ofstream(path, std::ios::binary).write(content.data(), static_cast<std::streamsize>(content.size()));
  return path;
}

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A unit cube (label 1), a pyramid on its top (label 2), a prism at its side x = 1 (label 3) and a
/// tetrahedron on the pyramid (label 7), with their boundary and interface faces, and everything a MeshInfo
/// can say. Volumes: 1, 1/3, 1/2, 1.25/6.
inline MixedMesh every_cell_shape() {
  MixedMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1},     {1, 0, 1},
                 {1, 1, 1}, {0, 1, 1}, {2, 0, 0}, {2, 1, 0}, {0.5, 0.5, 2}, {0.5, -1, 1.5}};
  mesh.hexahedra = {{0, 1, 2, 3, 4, 5, 6, 7}};
  mesh.hexahedron_labels = {1};
  mesh.pyramids = {{4, 5, 6, 7, 10}};
  mesh.pyramid_labels = {2};
  mesh.prisms = {{1, 8, 5, 2, 9, 6}};
  mesh.prism_labels = {3};
  mesh.tetrahedra = {{4, 5, 10, 11}};
  mesh.tetrahedron_labels = {7};
  mesh.triangles = {{5, 6, 10},  {6, 7, 10},  {7, 4, 10}, {4, 5, 10}, {5, 4, 11},
                    {10, 5, 11}, {4, 10, 11}, {1, 8, 5},  {2, 6, 9}};
  mesh.triangle_patches = {1, 1, 1, 4, 0, 0, 0, 2, 2};
  mesh.quadrilaterals = {{0, 3, 2, 1}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 4, 7, 3},
                         {4, 5, 6, 7}, {1, 2, 6, 5}, {1, 2, 9, 8}, {8, 9, 6, 5}};
  mesh.quadrilateral_patches = {0, 0, 0, 0, 3, 3, 2, 2};
  mesh.info.frame = "RAS";
  mesh.info.patches = {{"wall", PatchKind::kWall, {1, 0}},
                       {"dome wall", PatchKind::kWall, {2, 0}},
                       {"inlet_1", PatchKind::kOpening, {3, 0}},
                       {"interface_1_2", PatchKind::kInterface, {1, 2}},
                       {"interface_2_7", PatchKind::kInterface, {2, 7}}};
  mesh.info.label_names = {{1, "lumen"}, {7, "clot <old> & \"new\""}};
  mesh.info.provenance = {
      {"version", "0.1.0"}, {"command", "lumesh lattice \"a b.nrrd\" --x=$1 é"}, {"input_sha256", "ab"}};
  return mesh;
}

/// A view of the faces of a mesh, as a surface without cells has them.
inline MeshView faces_alone(const MixedMesh& mesh) {
  MeshView faces = mesh.view();
  for_each_cell_list([](auto& cells, auto& labels) { cells = {}, labels = {}; }, faces);
  return faces;
}

/// Positive definite, each with six numbers that are all different, so that no two may change places.
inline std::vector<SymTensor> different_tensors(std::size_t count) {
  std::vector<SymTensor> tensors;
  for (std::size_t i = 0; i < count; ++i) {
    const double scale = 1 + static_cast<double>(i) / 3;
    tensors.push_back(scale * SymTensor{.xx = 4, .xy = 0.5, .xz = -0.25, .yy = 9.1, .yz = 1.5, .zz = 16});
  }
  return tensors;
}

using TaggedCell = std::pair<std::vector<std::uint32_t>, std::int32_t>;

template <std::size_t N>
std::vector<TaggedCell> sorted_cells(const std::vector<Cell<N>>& cells,
                                     const std::vector<std::int32_t>& tags) {
  std::vector<TaggedCell> all;
  for (std::size_t i = 0; i < cells.size(); ++i)
    all.push_back({{cells[i].begin(), cells[i].end()}, tags.at(i)});
  std::sort(all.begin(), all.end());
  return all;
}

/// Every cell with its label and every face with its patch, in an order that does not depend on the file's.
inline std::vector<std::vector<TaggedCell>> everything(const MixedMesh& mesh) {
  return {sorted_cells(mesh.tetrahedra, mesh.tetrahedron_labels),
          sorted_cells(mesh.pyramids, mesh.pyramid_labels),
          sorted_cells(mesh.prisms, mesh.prism_labels),
          sorted_cells(mesh.hexahedra, mesh.hexahedron_labels),
          sorted_cells(mesh.triangles, mesh.triangle_patches),
          sorted_cells(mesh.quadrilaterals, mesh.quadrilateral_patches)};
}

/// What the Error of a failing call says; empty if there is none. An Error's message is one line.
template <class Call>
std::string error_of(const Call& call, ErrorKind expected = ErrorKind::kBadInput) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), expected) << error.what();
    const std::string text = error.what();
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    return text;
  }
  ADD_FAILURE() << "no Error was thrown";
  return {};
}

}  // namespace lumesh::fixtures
