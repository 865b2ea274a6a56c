#pragma once
/// @file Polygons of VTK's PolyData and the patches that arrays of cells tell.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "file_fault.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::io {

/// Arrays of whole numbers on the cells of a file.
struct CellArrays {
  std::function<std::optional<std::vector<std::int64_t>>(const std::string& name)> find;
  std::vector<std::string> names;
};

/// Corners one cell after the other, and where each cell's end.
struct CellCorners {
  std::vector<std::int64_t> corners, ends;
};

/// Calls visit(corners) for each cell of a file, in their order.
template <class Visit>
void for_each_cell(const std::filesystem::path& path, const CellCorners& cells, const Visit& visit) {
  const std::span<const std::int64_t> corners = cells.corners;
  std::int64_t begin = 0;
  for (const std::int64_t end : cells.ends) {
    if (end < begin || end > std::ssize(corners)) fail(path, kBadOffsets);
    visit(corners.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin)));
    begin = end;
  }
}

/// Cells of PolyData.
struct Polygons {
  CellCorners polygons;
  CellCorners strips;            ///< Strips of triangles, which come after the polygons.
  std::size_t cells_before = 0;  ///< Vertices and lines, which cell arrays have first.
};

/// Adds triangles and quadrilaterals to a mesh that has its points, with the patches of an array.
/// @param patch_array  Its name; empty: ours, SimVascular's, or VMTK's, the first that tells patches apart,
/// with warnings of those that do and whose numbers patches cannot have.
/// @throws Error{kBadInput} if there is no such array, or the cells are damaged.
void add_polygons(const std::filesystem::path& path, const Polygons& polygons, const CellArrays& arrays,
                  const std::string& patch_array, const Context& context, MixedMesh& mesh);

/// Number of patches that meshes which change can have.
inline constexpr std::int64_t kPatchEnd = 65'535;

/// Checks that faces have patches, and adds those with faces that the file does not describe, named by their
/// numbers in it. @param array  Name of the array that has the numbers.
void complete_patches(const std::filesystem::path& path, MixedMesh& mesh, const std::string& array,
                      const std::string& unnamed = "patch_");

}  // namespace lumesh::io
