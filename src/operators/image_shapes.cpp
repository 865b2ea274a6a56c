#include <algorithm>

#include "lumesh/core/error.hpp"
#include "lumesh/domain/image_surface.hpp"
#include "lumesh/operators/patch_shapes.hpp"

namespace lumesh::operators {
namespace {

constexpr double kReachVoxels = 1.5;

/// The number of a label in the image.
Material material_of(const ImageDomain& domain, Label label) {
  for (Material m = 1; m < domain.label_count(); ++m)
    if (domain.label_of(m) == label) return m;
  throw Error(ErrorKind::kBadInput, "the image has no label " + std::to_string(label) +
                                        ", which the mesh has; give the image of the mesh");
}

/// The label inside each patch of the outside; kBackground for all others.
std::vector<Label> labels_inside(const TetMesh& mesh, const BoundaryFaces& faces) {
  std::vector<Label> labels(mesh.info().patches.size(), kBackground);
  for (std::size_t i = 0; i < faces.triangles.size(); ++i)
    if (!faces.tets[i][1].valid())
      labels[static_cast<std::size_t>(faces.patches[i])] = mesh.label(faces.tets[i][0]);
  return labels;
}

/// How far the mesh lies from the boundary that one of its patches is to follow.
struct Offsets {
  std::size_t corners = 0, near = 0;
  double sum_mm = 0;  ///< Outwards, of those near.
};

void add_offset(const ImageSurface& surface, const Vec3& point, Offsets& offsets) {
  ++offsets.corners;
  const std::optional<SurfacePoint> boundary = surface.boundary_near(point);
  if (!boundary) return;
  ++offsets.near;
  offsets.sum_mm += boundary->normal.dot(point - boundary->point);
}

}  // namespace

void follow_image(const TetMesh& mesh, const std::shared_ptr<const ImageDomain>& domain,
                  PatchShapes& shapes) {
  const BoundaryFaces faces = mesh.boundary_faces();
  const std::vector<Label> inside = labels_inside(mesh, faces);
  std::vector<std::shared_ptr<ImageSurface>> surfaces(shapes.size());
  for (std::size_t p = 0; p < shapes.size(); ++p)
    if (shapes[p].freedom == PatchFreedom::kCurved && !shapes[p].surface->is_analytic())
      surfaces[p] = std::make_shared<ImageSurface>(domain, material_of(*domain, inside[p]), 0,
                                                   shapes[p].surface, kReachVoxels * domain->voxel_size_mm());
  std::vector<Offsets> offsets(shapes.size());
  for (std::size_t i = 0; i < faces.triangles.size(); ++i)
    if (const auto p = static_cast<std::size_t>(faces.patches[i]); surfaces[p])
      for (const std::uint32_t v : faces.triangles[i])
        add_offset(*surfaces[p], mesh.point(VertexId(v)), offsets[p]);
  std::size_t corners = 0, near = 0;
  for (std::size_t p = 0; p < shapes.size(); ++p) {
    if (!surfaces[p]) continue;
    corners += offsets[p].corners;
    near += offsets[p].near;
    if (offsets[p].near > 0) surfaces[p]->set_shift(offsets[p].sum_mm / static_cast<double>(offsets[p].near));
    shapes[p].surface = surfaces[p];
  }
  if (2 * near < corners)
    throw Error(ErrorKind::kBadInput,
                "most of the mesh's surface lies more than 1.5 voxels off the image's boundary; give the "
                "image of the "
                "mesh, in the same frame and unit");
}

}  // namespace lumesh::operators
