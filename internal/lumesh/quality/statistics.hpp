#pragma once
/// @file Element quality and volumes of a mesh, in numbers.

#include <span>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/quality/measures.hpp"

namespace lumesh::quality {

/// Measures every cell. Threads: parallel inside, bitwise identical for every thread count. Cost: about 0.3
/// us per tetrahedron and core.
[[nodiscard]] MeshStatistics measure(const MeshView& mesh);

/// Least scaled Jacobian over the corners of a cell (of a pyramid: those of its base); 1 for a cube, <= 0 if
/// inverted.
[[nodiscard]] double scaled_jacobian(std::span<const Vec3> points, const Cell<5>& pyramid);
[[nodiscard]] double scaled_jacobian(std::span<const Vec3> points, const Cell<6>& prism);
[[nodiscard]] double scaled_jacobian(std::span<const Vec3> points, const Cell<8>& hexahedron);

}  // namespace lumesh::quality
