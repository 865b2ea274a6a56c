#include "lumesh/operators/input_surface.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/operators/patch_shapes.hpp"

namespace lumesh::operators {
namespace {

/// What a face is by the normals at its corners: that of a plane, of a smooth surface, or at a crease.
enum class FaceShape { kFlat, kSmooth, kCreased };

FaceShape shape_of(const std::array<Vec3, 3>& corners, const std::array<Vec3, 3>& normals) {
  constexpr double kSmooth = 0.9, kFlat = 1 - 1e-14;  // Cosines; of 26 degrees: a full circle of seven edges.
  const Vec3 normal = triangle_normal(corners[0], corners[1], corners[2]);
  double smallest = 1;
  for (const Vec3& n : normals) smallest = std::min(smallest, n.dot(normal));
  return smallest >= kFlat     ? FaceShape::kFlat
         : smallest >= kSmooth ? FaceShape::kSmooth
                               : FaceShape::kCreased;
}

}  // namespace

InputSurface::InputSurface(const TetMesh& mesh, KeepWithin keep_within)
    : points_(mesh.points().begin(), mesh.points().end()), keep_within_(std::move(keep_within)) {
  const BoundaryFaces faces = mesh.boundary_faces();
  std::vector<std::vector<Cell<3>>> triangles(mesh.info().patches.size());
  for (std::size_t i = 0; i < faces.triangles.size(); ++i)
    triangles[static_cast<std::size_t>(faces.patches[i])].push_back(faces.triangles[i]);
  // Openings, for one, are planes also at rims that the wall leaves at a small angle.
  constexpr double kPlane =
      1e-6;  // Of the mesh's size: about how exactly refinement puts points into a plane.
  const PatchShapes planes = planes_where_flat(mesh, kPlane);
  for (std::size_t p = 0; p < triangles.size(); ++p)
    parts_.push_back({TriangleTree(points_, triangles[p]), std::move(triangles[p]),
                      planes[p].freedom == PatchFreedom::kPlane});
  normals_ = vertex_normals(points_, faces.triangles);
}

Vec3 InputSurface::smooth(PatchId patch, const TriangleTree::Nearest& nearest) const {
  if (parts_[patch.value].is_plane) return nearest.point;
  const auto [a, b, c] = parts_[patch.value].triangles[nearest.triangle];
  const std::array<Vec3, 3> corners = {points_[a], points_[b], points_[c]};
  const std::array<Vec3, 3> normals = {normals_[a], normals_[b], normals_[c]};
  if (shape_of(corners, normals) != FaceShape::kSmooth) return nearest.point;
  const Vec3 place = over_triangle(corners, normals, nearest.point).point;
  return distance_outside(keep_within_, place) > 0 ? nearest.point : place;
}

}  // namespace lumesh::operators
