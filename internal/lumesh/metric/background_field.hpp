#pragma once
/// @file A metric field that a mesh carries while the mesh itself changes.

#include <span>

#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/metric_field.hpp"

namespace lumesh::metric {

/// A background of `mesh`, which is compact, with these tensors, and with bounded growth where `gradation`
/// > 0.
[[nodiscard]] MetricField background_field(const TetMesh& mesh, std::span<const SymTensor> tensors,
                                           double gradation);

}  // namespace lumesh::metric
