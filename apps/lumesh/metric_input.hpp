#pragma once
/// @file What the commands that work with metrics read.

#include <CLI/CLI.hpp>
#include <string>

#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/metric_field.hpp"

namespace lumesh::cli {

/// --metric and --analytic, of which one may be given; formulas are checked.
void add_metric_options(CLI::App& command, std::string& metric_path, std::string& formula);
/// --gradation: 0 where it is not given.
CLI::Option* add_gradation_option(CLI::App& command, double& growth);

/// The mesh with adjacency. @throws Error{kBadInput} that names the file if it has other cells than
/// tetrahedra, none at all, or is not valid.
[[nodiscard]] TetMesh tetrahedra_of(const MixedMesh& mesh, const std::string& path);

/// The tensors that the mesh carries, or those of a .sol or .solb file. Checked: one positive definite tensor
/// per vertex.
/// @throws Error{kBadInput} that names file and vertex.
[[nodiscard]] std::vector<SymTensor> metric_of(const MixedMesh& mesh, const std::string& mesh_path,
                                               const std::string& metric_path);

/// True if the sizes of every tensor are the same in all directions, within a hundredth.
[[nodiscard]] bool are_isotropic(const std::vector<SymTensor>& tensors);

/// A background of `mesh` with these tensors, and with bounded growth where `gradation` > 0.
[[nodiscard]] metric::MetricField background_field(const TetMesh& mesh, const std::vector<SymTensor>& tensors,
                                                   double gradation);

/// Where a command's metric comes from: a formula if it has a name, else a file, else the mesh itself.
struct MetricSource {
  std::string mesh_path, metric_path, formula;
};
[[nodiscard]] metric::MetricField field_of(const MetricSource& source, const MixedMesh& input,
                                           const TetMesh& mesh, double gradation = 0);

}  // namespace lumesh::cli
