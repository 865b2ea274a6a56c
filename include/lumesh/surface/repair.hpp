#pragma once
/// @file Local repair of triangle surfaces: what is sound stays to the last bit.

#include <cstdint>
#include <string>

#include "lumesh/surface/distance.hpp"

namespace lumesh::surfaces {

/// What a repair did.
struct RepairReport {
  std::uint64_t duplicate_triangles = 0;  ///< Left out.
  std::uint64_t dropped_parts = 0;        ///< Specks, and parts that lie on others.
  std::uint64_t dropped_triangles = 0;    ///< Of those parts.
  std::uint64_t singular_edges = 0;       ///< Of three triangles or more, cut.
  std::uint64_t singular_points = 0;      ///< Of more than one fan, divided.
  std::uint64_t turned_triangles = 0;
  std::uint64_t flipped_edges = 0;      ///< Beside triangles without area.
  std::uint64_t holes = 0;              ///< Filled ones of the given surface.
  double widest_hole_mm = 0;            ///< Radius.
  int rounds = 0;                       ///< In which triangles that cross were replaced.
  std::uint64_t removed_triangles = 0;  ///< In those rounds.
  std::uint64_t new_triangles = 0;      ///< All that were not given.
  std::uint64_t openings = 0;           ///< That were left open.
  std::uint64_t components = 0;
  std::int64_t genus = 0;
  /// The farther of both sides of the Hausdorff distance, but for fillings of holes that were given, and
  /// parts that were dropped.
  FarthestPoint moved;
};

struct RepairedSurface {
  TriangleMesh surface;  ///< Empty where it could not be repaired.
  RepairReport report;
  std::string failure;  ///< Why not; empty where it was repaired.
  Vec3 failure_mm = Vec3::Zero();

  [[nodiscard]] bool ok() const { return failure.empty(); }
};

/// Makes a surface a manifold without self-crossings (exactly), closed but for its openings, and turned
/// outwards. After Attene 2010, A lightweight approach to repairing digitized polygon meshes,
/// doi:10.1007/s00371-010-0416-3: cuts it at edges of three triangles and at points of several fans, drops
/// specks and parts that lie on others, turns triangles alike, fills holes; then, up to ten times, takes out
/// triangles that cross or lie back on their neighbours, with k rings around in round k, and fills again. No
/// vertex moves. New triangles take the patch with most of their rim's edges.
///
/// Accepted only if components, genus and openings are those that the surface had after the first filling,
/// and nothing moved farther than asked.
/// @param max_distance_mm  > 0; also what lies on another part is no farther from it.
/// Threads: parallel inside, the same for every thread count. Cost: about 10 us per triangle.
[[nodiscard]] RepairedSurface repair_locally(const TriangleMesh& surface, double max_distance_mm);

}  // namespace lumesh::surfaces
