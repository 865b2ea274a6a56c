#pragma once
/// @file Vertices where the boundary of a label is not a manifold.

#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh::delaunay {

/// Vertices around which the tetrahedra of a label, or those of all others, are not connected through faces;
/// every part of the outside is one. Labels of tetrahedra are materials. In the order of their places,
/// whatever their numbers are.
[[nodiscard]] std::vector<VertexId> pinched_vertices(const TetMesh& mesh, const Domain& domain);

/// The pinched ones of some vertices, each named once, in the order of their places.
[[nodiscard]] std::vector<VertexId> pinched_among(const TetMesh& mesh, const Domain& domain,
                                                  std::span<const VertexId> suspects);

/// What tetrahedra around pinched vertices become: of a material next to them, as few as do, or all of the
/// outside, with which nothing enters the object.
enum class PinchRepair : std::uint8_t { kToNeighbours, kToOutside };

/// Gives tetrahedra around pinched vertices other materials until there are no such vertices.
/// @param suspects  All pinched vertices. @return Their number.
std::size_t relabel_pinched(TetMesh& mesh, const Domain& domain, const std::vector<VertexId>& suspects,
                            PinchRepair way = PinchRepair::kToNeighbours);

}  // namespace lumesh::delaunay
