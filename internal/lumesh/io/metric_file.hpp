#pragma once
/// @file Metrics and solutions from and to Medit's solution files, which stand beside a mesh file.

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "lumesh/core/option.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/io/file_formats.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh {

/// Reads a metric from .sol (text) or .solb (binary, versions 1 to 4, both byte orders): the section
/// SolAtVertices with one field, of symmetric tensors or of sizes.
///
/// @param expected_count  Vertices of the mesh that the metric belongs to.
/// @return One tensor per vertex in 1/mm^2, in the order of the mesh's vertices. A size h (mm) becomes the
/// tensor h^-2 times the identity.
/// @throws Error{kBadInput} if the file is missing, broken, two-dimensional or has another number of vertices
/// or another kind of field, or if a tensor is not finite and positive definite; the message is one line that
/// names the vertex, from 1 as Medit counts. Memory: the file, and the tensors.
[[nodiscard]] std::vector<SymTensor> read_metric(const std::filesystem::path& path,
                                                 std::size_t expected_count);

/// Reads a solution of one number per vertex from the same kinds of files.
/// @return The numbers in the order of the mesh's vertices; they may be infinite or not a number.
/// @throws Error{kBadInput} as read_metric(), for a field of another kind too.
[[nodiscard]] std::vector<double> read_solution(const std::filesystem::path& path,
                                                std::size_t expected_count);

/// True if the name ends as those of files that write_metric() writes.
[[nodiscard]] inline bool is_metric_file(const std::filesystem::path& path) {
  return is_for(path, FileUse::kMetricAlone);
}

/// Writes .sol, or .solb of version 2 (3 above 2 GiB), in double precision: read_metric() gives the same
/// bits. The file is written beside the target and renamed when complete.
///
/// @param metric  One tensor per vertex in 1/mm^2, in the order of the mesh's vertices.
/// @throws Error{kBadInput} if the extension is neither, a tensor is not finite and positive definite, or
/// writing fails; nothing is left behind then.
void write_metric(const std::filesystem::path& path, std::span<const SymTensor> metric);

}  // namespace lumesh
