#pragma once
/// @file What the commands that work with metrics read.

#include <CLI/CLI.hpp>
#include <string>

#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/metric_field.hpp"

namespace lumesh::cli {

/// --analytic: the name of a formula, checked.
CLI::Option* add_analytic_option(CLI::App& command, std::string& formula);

/// The mesh with adjacency. @throws Error{kBadInput} that names the file if it has other cells than
/// tetrahedra, none at all, or is not valid.
[[nodiscard]] TetMesh tetrahedra_of(const MixedMesh& mesh, const std::string& path);

/// The tensors that the mesh carries, or those of a .sol or .solb file. Checked: one positive definite tensor
/// per vertex.
/// @throws Error{kBadInput} that names file and vertex.
[[nodiscard]] std::vector<SymTensor> metric_of(const MixedMesh& mesh, const std::string& mesh_path,
                                               const std::string& metric_path);

/// A background of `mesh` with these tensors.
[[nodiscard]] metric::MetricField background_field(const TetMesh& mesh,
                                                   const std::vector<SymTensor>& tensors);

}  // namespace lumesh::cli
