#include "lumesh/operators/input_surface.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "lumesh/geometry/triangle.hpp"

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

/// An opening, for one, is as flat at a rim where the wall around leaves it at a small angle.
bool is_plane(std::span<const Vec3> points, const std::vector<Cell<3>>& triangles) {
  constexpr double kPlane = 1 - 1e-9;
  Vec3 sum = Vec3::Zero();
  double area = 0;
  for (const auto& [a, b, c] : triangles) {
    const Vec3 normal = triangle_area_normal(points[a], points[b], points[c]);
    sum += normal;
    area += normal.norm();
  }
  return sum.norm() > kPlane * area;
}

}  // namespace

InputSurface::InputSurface(const TetMesh& mesh) : points_(mesh.points().begin(), mesh.points().end()) {
  const BoundaryFaces faces = mesh.boundary_faces();
  std::vector<std::vector<Cell<3>>> triangles(mesh.info().patches.size());
  for (std::size_t i = 0; i < faces.triangles.size(); ++i)
    triangles[static_cast<std::size_t>(faces.patches[i])].push_back(faces.triangles[i]);
  for (auto& patch : triangles) {
    TriangleTree tree(points_, patch);
    const bool is_flat = is_plane(points_, patch);
    parts_.push_back({std::move(tree), std::move(patch), is_flat});
  }
  normals_ = vertex_normals(points_, faces.triangles);
}

Vec3 InputSurface::smooth(PatchId patch, const TriangleTree::Nearest& nearest) const {
  if (parts_[patch.value].is_plane) return nearest.point;
  const auto [a, b, c] = parts_[patch.value].triangles[nearest.triangle];
  const std::array<Vec3, 3> corners = {points_[a], points_[b], points_[c]};
  const std::array<Vec3, 3> normals = {normals_[a], normals_[b], normals_[c]};
  return shape_of(corners, normals) == FaceShape::kSmooth
             ? over_triangle(corners, normals, nearest.point).point
             : nearest.point;
}

}  // namespace lumesh::operators
