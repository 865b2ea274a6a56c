#include "lumesh/domain/walls_in_planes.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/edge_key.hpp"

namespace lumesh {
namespace {

struct FlatTriangle {
  Cell<3> corners;
  std::int32_t patch;
};

/// The pieces among some triangles of one plane.
void add_pieces(const MeshView& mesh, std::span<const FlatTriangle> triangles, const CutPlane& plane,
                double min_area_mm2, std::vector<WallInPlane>& walls) {
  DisjointSets sets(triangles.size());
  std::map<std::array<std::uint32_t, 2>, std::uint32_t> first;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for_each_edge_of(triangles[t].corners, [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, is_new] = first.try_emplace({std::min(a, b), std::max(a, b)}, t);
      if (!is_new) sets.merge(t, at->second);
    });
  std::map<std::uint32_t, WallInPlane> pieces;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const auto [corners, patch] = triangles[t];
    const Vec3 &a = mesh.points[corners[0]], &b = mesh.points[corners[1]], &c = mesh.points[corners[2]];
    WallInPlane& piece = pieces[sets.find(t)];
    const double area_mm2 = triangle_area(a, b, c);
    piece.patch = mesh.info->patches[static_cast<std::size_t>(patch)].name;
    piece.area_mm2 += area_mm2;
    piece.centre_mm += area_mm2 * triangle_centre(a, b, c);
  }
  for (auto& [root, piece] : pieces) {
    if (piece.area_mm2 <= min_area_mm2) continue;
    piece.centre_mm /= piece.area_mm2;
    piece.normal = plane.normal;
    walls.push_back(std::move(piece));
  }
}

}  // namespace

std::vector<WallInPlane> walls_in_planes(const MeshView& mesh, const Domain& domain) {
  const double max_off_mm = 1e-3 * domain.resolution_mm();
  std::vector<std::vector<FlatTriangle>> in_planes(domain.cut_planes().size());
  if (in_planes.empty()) return {};
  for_each_patch_triangle(mesh, [&](const Cell<3>& corners, std::int32_t patch) {
    const auto at = static_cast<std::size_t>(patch);
    if (at >= mesh.info->patches.size() || mesh.info->patches[at].kind != PatchKind::kWall) return;
    for (std::size_t p = 0; p < in_planes.size(); ++p)
      if (std::ranges::all_of(corners, [&](std::uint32_t v) {
            const CutPlane& plane = domain.cut_planes()[p];
            return std::abs(plane.height(mesh.points[v])) <= max_off_mm &&
                   (mesh.points[v] - plane.point_mm).norm() <= plane.radius_mm;
          }))
        in_planes[p].push_back({corners, patch});
  });
  std::vector<WallInPlane> walls;
  for (std::size_t p = 0; p < in_planes.size(); ++p) {
    const CutPlane& plane = domain.cut_planes()[p];
    add_pieces(mesh, in_planes[p], plane, voxel_face_mm2(domain, plane.normal), walls);
  }
  return walls;
}

std::vector<std::string> doubts_about(const std::vector<WallInPlane>& walls) {
  std::vector<std::string> lines;
  for (const WallInPlane& wall : walls)
    lines.push_back(
        fmt::format("{:.3g} mm² of {} lie in the plane of a border or cut at {}, where the input has no "
                    "opening; another `edge_length` may help",
                    wall.area_mm2, wall.patch, place_text(wall.centre_mm)));
  return lines;
}

}  // namespace lumesh
