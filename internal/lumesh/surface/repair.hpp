#pragma once
/// @file Local repair of triangle surfaces: what is sound stays to the last bit.

#include <cstdint>
#include <string>

#include "lumesh/mesh/triangle_mesh.hpp"
#include "lumesh/surface/reports.hpp"

namespace lumesh::surfaces {

struct RepairedSurface {
  TriangleMesh surface;  ///< Empty where it could not be repaired.
  RepairReport report;
  std::string failure;  ///< Why not; empty where it was repaired.
  Vec3 failure_mm = Vec3::Zero();

  [[nodiscard]] bool ok() const { return failure.empty(); }
};

/// Leaves out components smaller than 1 % of the whole, and those that lie on a larger one within a distance
/// and are turned as it is. Triangles of each component are turned alike. @return How many components.
/// Threads: one. Cost: about 2 us per triangle.
std::uint64_t drop_specks_and_copies(TriangleMesh& surface, double distance_mm);

/// Makes a surface a manifold without self-crossings (exactly), closed but for its openings, and turned
/// outwards. After Attene 2010, A lightweight approach to repairing digitized polygon meshes,
/// doi:10.1007/s00371-010-0416-3: cuts it at edges of three triangles and at points of several fans, drops
/// specks, parts that lie on others and those that hang on others at points, turns triangles alike, fills
/// holes, and puts vertices back that were pulled past their neighbours; then, up to ten times, takes out
/// triangles that cross or lie back on their neighbours, with k rings around in round k, and fills again;
/// where that moves too much, takes out pieces of triangles shorter than half of what may move; where that
/// fails, outer_boundary(). New triangles take the patch with most of their rim's edges.
///
/// Accepted only if components, genus and openings are those that the surface had after the first filling, or
/// after outer_boundary(), and nothing moved farther than asked.
/// @param max_distance_mm  > 0; also what lies on another part is no farther from it.
/// Threads: parallel inside, the same for every thread count. Cost: about 10 us per triangle.
[[nodiscard]] RepairedSurface repair_locally(const TriangleMesh& surface, double max_distance_mm);

}  // namespace lumesh::surfaces
