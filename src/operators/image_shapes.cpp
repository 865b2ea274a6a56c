#include <algorithm>
#include <cmath>

#include "lumesh/core/error.hpp"
#include "lumesh/domain/image_surface.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/operators/patch_shapes.hpp"
#include "lumesh/operators/sagittas.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh::operators {
namespace {

constexpr double kReachVoxels = 1.5;

/// The number of a label in the image.
Material material_of(const ImageDomain& domain, Label label) {
  if (const auto material = domain.material_of(label)) return *material;
  throw Error(ErrorKind::kBadInput, "has no label " + std::to_string(label) +
                                        ", which the mesh has; give the image that the mesh was made of");
}

/// The label inside each patch of the outside; kBackground for all others, and for patches of several labels.
std::vector<Label> labels_inside(const TetMesh& mesh, const BoundaryFaces& faces) {
  std::vector<Label> labels(mesh.info().patches.size(), kBackground);
  std::vector<bool> is_mixed(labels.size(), false);
  for (std::size_t i = 0; i < faces.triangles.size(); ++i) {
    if (faces.tets[i][1].valid()) continue;
    const auto patch = static_cast<std::size_t>(faces.patches[i]);
    const Label label = mesh.label(faces.tets[i][0]);
    if (labels[patch] != kBackground && labels[patch] != label) is_mixed[patch] = true;
    labels[patch] = label;
  }
  for (std::size_t p = 0; p < labels.size(); ++p)
    if (is_mixed[p]) labels[p] = kBackground;
  return labels;
}

/// The numbers of the triangles of each patch.
std::vector<std::vector<std::uint32_t>> triangles_of_patches(const BoundaryFaces& faces,
                                                             std::size_t patches) {
  std::vector<std::vector<std::uint32_t>> triangles(patches);
  for (std::uint32_t i = 0; i < faces.triangles.size(); ++i)
    triangles[static_cast<std::size_t>(faces.patches[i])].push_back(i);
  return triangles;
}

/// How far triangles and their corners lie from the boundary that they are to follow.
struct Offsets {
  std::size_t triangles = 0, near = 0;
  /// Sums over the triangles near: areas, and areas times the mean distance outwards.
  double area_mm2 = 0, of_triangles_mm3 = 0, of_corners_mm3 = 0;

  /// A mesh whose triangles enclose what the image's boundary does has its vertices over it, by the sagitta;
  /// another one may have them on it, and encloses less. What both kinds have in common is no reason to move.
  [[nodiscard]] double shift_mm() const {
    const double smallest = std::min(std::abs(of_triangles_mm3), std::abs(of_corners_mm3));
    if (!(area_mm2 > 0)) return 0;
    return (std::abs(of_triangles_mm3) == smallest ? of_triangles_mm3 : of_corners_mm3) / area_mm2;
  }
};

Offsets offset_of(const std::array<Vec3, 3>& corners, const ImageSurface& surface) {
  const auto boundary_near = [&](const Vec3& point) { return surface.boundary_near(point); };
  Offsets offsets{.triangles = 1};
  std::array<Vec3, 3> over;
  double of_corners = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::optional<SurfacePoint> boundary = boundary_near(corners[k]);
    if (!boundary) return offsets;
    over[k] = boundary->point;
    of_corners += boundary->normal.dot(corners[k] - boundary->point) / 3;
  }
  const std::optional<double> over_triangle = mean_height_over(corners, over, boundary_near);
  if (!over_triangle) return offsets;
  offsets.near = 1;
  offsets.area_mm2 = triangle_area(corners[0], corners[1], corners[2]);
  offsets.of_corners_mm3 = offsets.area_mm2 * of_corners;
  offsets.of_triangles_mm3 = -offsets.area_mm2 * *over_triangle;
  return offsets;
}

Offsets operator+(const Offsets& a, const Offsets& b) {
  return {a.triangles + b.triangles, a.near + b.near, a.area_mm2 + b.area_mm2,
          a.of_triangles_mm3 + b.of_triangles_mm3, a.of_corners_mm3 + b.of_corners_mm3};
}

Offsets offsets_of(const TetMesh& mesh, const ImageSurface& surface, const BoundaryFaces& faces,
                   const std::vector<std::uint32_t>& triangles) {
  constexpr std::size_t kBlock = 256;
  return parallel::sum<Offsets>(triangles.size(), kBlock, [&](std::size_t i) {
    const auto [a, b, c] = faces.triangles[triangles[i]];
    return offset_of({mesh.point(VertexId(a)), mesh.point(VertexId(b)), mesh.point(VertexId(c))}, surface);
  });
}

}  // namespace

std::size_t follow_image(const TetMesh& mesh, const std::shared_ptr<const ImageDomain>& domain,
                         PatchShapes& shapes) {
  const BoundaryFaces faces = mesh.boundary_faces();
  const std::vector<Label> inside = labels_inside(mesh, faces);
  const auto triangles = triangles_of_patches(faces, shapes.size());
  std::size_t following = 0;
  Offsets all;
  for (std::size_t p = 0; p < shapes.size(); ++p) {
    if (shapes[p].freedom != PatchFreedom::kCurved || shapes[p].surface->is_analytic() ||
        inside[p] == kBackground)
      continue;
    const auto surface =
        std::make_shared<ImageSurface>(domain, material_of(*domain, inside[p]), 0, shapes[p].surface,
                                       kReachVoxels * domain->voxel_size_mm());
    const Offsets offsets = offsets_of(mesh, *surface, faces, triangles[p]);
    surface->set_shift(offsets.shift_mm());
    all = all + offsets;
    shapes[p].surface = surface;
    shapes[p].keeps_volume = true;
    ++following;
  }
  if (2 * all.near < all.triangles)
    throw Error(
        ErrorKind::kBadInput,
        "most of the mesh's surface lies far off its boundary, more than 1.5 voxels; give the image that the "
        "mesh was made of, in the same frame and unit");
  return following;
}

}  // namespace lumesh::operators
