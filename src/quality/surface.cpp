#include "lumesh/quality/surface.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "cell_faces.hpp"
#include "lumesh/core/angles.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/patch_list.hpp"

namespace lumesh::quality {

std::vector<Cell<3>> MeshSurface::around(Label label) const {
  std::vector<Cell<3>> result;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto& [a, b, c] = triangles[i];
    if (labels[i][0] == label) result.push_back({a, b, c});
    if (labels[i][1] == label) result.push_back({a, c, b});
  }
  return result;
}

std::vector<Cell<3>> MeshSurface::outer() const {
  std::vector<Cell<3>> result;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (labels[i][1] == kOutside) result.push_back(triangles[i]);
  return result;
}

namespace {

struct SurfaceFace {
  Cell<3> corners;
  std::array<Label, 2> labels;
  std::uint32_t overfull;
};

/// Corners ascending, and the patch that the mesh names for them.
struct NamedFace {
  Cell<3> corners;
  std::int32_t patch;
  auto operator<=>(const NamedFace&) const = default;
};

parallel::KeyTable<NamedFace> named_faces(const MeshView& mesh) {
  std::vector<NamedFace> faces;
  const auto add = [&](const Cell<3>& corners, std::int32_t patch) {
    faces.push_back({sorted_corners(corners), patch});
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) add(mesh.triangles[i], mesh.triangle_patches[i]);
  for (std::size_t i = 0; i < mesh.quadrilaterals.size(); ++i) {
    CellTriangles halves;
    halves.add_quad(mesh.quadrilaterals[i]);
    for (const Cell<3>& half : halves) add(half, mesh.quadrilateral_patches[i]);
  }
  return {faces, mesh.points.size(), [](const NamedFace& face) { return face.corners[0]; }};
}

std::vector<std::int32_t> look_up_patches(const MeshView& mesh, const std::vector<Cell<3>>& triangles) {
  const parallel::KeyTable<NamedFace> named = named_faces(mesh);
  std::vector<std::int32_t> patches(triangles.size(), -1);
  parallel::for_each_index(triangles.size(), [&](std::size_t i) {
    const Cell<3> corners = sorted_corners(triangles[i]);
    for (const NamedFace& face : named.of(corners[0]))
      if (face.corners == corners) patches[i] = face.patch;
  });
  return patches;
}

}  // namespace

MeshSurface extract_surface(const MeshView& mesh) {
  const AllCells cells(mesh);
  const parallel::KeyTable<CellFace> faces = collect_faces(mesh);
  const auto found = faces.collect_runs<SurfaceFace>(
      same_corners, [&](std::span<const CellFace> run, std::vector<SurfaceFace>& out) {
        const std::uint32_t overfull = run.size() > 2 ? 1 : 0;
        const Label first = cells.label(run[0].cell);
        if (run.size() == 1) return out.push_back({run[0].outward(), {first, kOutside}, overfull});
        const Label second = cells.label(run[1].cell);
        if (first < second) out.push_back({run[0].outward(), {first, second}, overfull});
        if (second < first) out.push_back({run[1].outward(), {second, first}, overfull});
        if (second == first && overfull) out.push_back({run[0].outward(), {first, kOutside}, overfull});
      });
  MeshSurface surface;
  for (const SurfaceFace& face : found) {
    surface.triangles.push_back(face.corners);
    surface.labels.push_back(face.labels);
    surface.overfull_faces += face.overfull;
  }
  surface.patches = look_up_patches(mesh, surface.triangles);
  return surface;
}

MeshSurface extract_surface(const TetMesh& mesh) {
  BoundaryFaces faces = mesh.boundary_faces();
  MeshSurface surface;
  surface.labels.reserve(faces.triangles.size());
  for (const auto& [inside, behind] : faces.tets)
    surface.labels.push_back({mesh.label(inside), behind.valid() ? mesh.label(behind) : kOutside});
  surface.triangles = std::move(faces.triangles);
  surface.patches = std::move(faces.patches);
  return surface;
}

namespace {

struct PlaneFit {
  AreaSum sum;
  double largest_cosine = -1;  // Of the smallest angles.
  std::uint64_t faces = 0;
};

/// Largest distance of the patch's vertices to the plane through their mean with the least squared distances.
double flatness(const MeshView& mesh, const MeshSurface& surface, std::int32_t patch) {
  std::vector<std::uint32_t> vertices;
  for (std::size_t i = 0; i < surface.triangles.size(); ++i)
    if (surface.patches[i] == patch)
      vertices.insert(vertices.end(), surface.triangles[i].begin(), surface.triangles[i].end());
  sort_unique(vertices);
  Vec3 mean = Vec3::Zero();
  for (const std::uint32_t v : vertices) mean += mesh.points[v] / static_cast<double>(vertices.size());
  Mat3 scatter = Mat3::Zero();
  for (const std::uint32_t v : vertices)
    scatter += (mesh.points[v] - mean) * (mesh.points[v] - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(scatter);
  const Vec3 normal = solver.eigenvectors().col(0);  // Of the smallest eigenvalue.
  double largest = 0;
  for (const std::uint32_t v : vertices)
    largest = std::max(largest, std::abs(normal.dot(mesh.points[v] - mean)));
  return largest;
}

}  // namespace

std::vector<PatchSummary> summarise_patches(const MeshView& mesh, const MeshSurface& surface) {
  const std::size_t named = mesh.info->patches.size();
  std::vector<PlaneFit> fits(named + 1);
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    const auto& [a, b, c] = surface.triangles[i];
    const std::int32_t patch = surface.patches[i];
    const bool known = patch >= 0 && static_cast<std::size_t>(patch) < named;
    PlaneFit& fit = fits[known ? static_cast<std::size_t>(patch) : named];
    fit.sum.add(mesh.points[a], mesh.points[b], mesh.points[c]);
    const double cosine = cosine_of_smallest_angle(mesh.points[a], mesh.points[b], mesh.points[c]);
    fit.largest_cosine = cosine <= 1 ? std::max(fit.largest_cosine, cosine) : 1;
    ++fit.faces;
  }
  std::vector<PatchSummary> result;
  for (std::size_t p = 0; p < fits.size(); ++p) {
    if (fits[p].faces == 0) continue;
    PatchSummary summary;
    summary.name = p < named ? mesh.info->patches[p].name : "(none)";
    summary.kind = p < named ? mesh.info->patches[p].kind : PatchKind::kWall;
    summary.flow = p < named ? mesh.info->patches[p].flow : FlowSide::kUnknown;
    summary.faces = fits[p].faces;
    summary.area_mm2 = fits[p].sum.area;
    summary.smallest_angle_deg = degrees(std::acos(fits[p].largest_cosine));
    if (fits[p].sum.area > 0) summary.centre_mm = fits[p].sum.centre();
    const Vec3& normal = fits[p].sum.normal;
    if (normal.norm() > 1e-6 * fits[p].sum.area) summary.normal = normal.normalized();
    if (p < named && is_plane(summary.kind))
      summary.flatness_mm = flatness(mesh, surface, static_cast<std::int32_t>(p));
    result.push_back(std::move(summary));
  }
  return result;
}

}  // namespace lumesh::quality
