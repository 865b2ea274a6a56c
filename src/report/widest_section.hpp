#pragma once
/// @file Where to cut a mesh open so that most of its inside can be seen.

#include "camera.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::report {

/// A plane, and from where one looks straight at it.
struct SectionView {
  CutPlane plane;
  ViewAngles angles;
};

/// The plane with about the largest section of those that face a viewer within 40 degrees of `angles`. Looks
/// at some 200,000 cells at most. Cost: about 20 ms.
/// @param apart_from  Unit normal of another cut; planes within 45 degrees of it are passed over. Zero: none.
[[nodiscard]] SectionView widest_section(const MeshView& mesh, const ViewAngles& angles,
                                         const Vec3& apart_from = Vec3::Zero());

}  // namespace lumesh::report
