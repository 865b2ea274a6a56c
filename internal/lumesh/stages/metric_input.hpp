#pragma once
/// @file Meshes with a metric, as the stages take them.

#include <string>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh {

/// The mesh with adjacency. @throws Error{kBadInput} that names the file if it has other cells than
/// tetrahedra, none at all, or is not valid.
[[nodiscard]] TetMesh tetrahedra_of(const MixedMesh& mesh, const std::string& path);

/// The error of a mesh that carries no metric. @param way  How to give it one: "make one with …".
[[nodiscard]] Error without_metric(const std::string& mesh_path, const std::string& way);

/// The tensors that the mesh carries, or those of a .sol or .solb file. Checked: one positive definite tensor
/// per vertex.
/// @throws Error{kBadInput} that names file and vertex.
[[nodiscard]] std::vector<SymTensor> metric_of(const MixedMesh& mesh, const std::string& mesh_path,
                                               const std::string& metric_path);

/// True if the sizes of every tensor are the same in all directions, within a hundredth.
[[nodiscard]] bool are_isotropic(const std::vector<SymTensor>& tensors);

}  // namespace lumesh
