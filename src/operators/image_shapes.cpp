#include <algorithm>

#include "lumesh/core/error.hpp"
#include "lumesh/domain/image_surface.hpp"
#include "lumesh/operators/patch_shapes.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::operators {
namespace {

constexpr double kReachVoxels = 1.5;

/// The number of a label in the image.
Material material_of(const ImageDomain& domain, Label label) {
  for (Material m = 1; m < domain.label_count(); ++m)
    if (domain.label_of(m) == label) return m;
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

/// The vertices of each patch, once, ascending.
std::vector<std::vector<std::uint32_t>> vertices_of_patches(const BoundaryFaces& faces, std::size_t patches) {
  std::vector<std::vector<std::uint32_t>> vertices(patches);
  for (std::size_t i = 0; i < faces.triangles.size(); ++i) {
    auto& own = vertices[static_cast<std::size_t>(faces.patches[i])];
    own.insert(own.end(), faces.triangles[i].begin(), faces.triangles[i].end());
  }
  parallel::for_each_index(
      patches,
      [&](std::size_t p) {
        std::sort(vertices[p].begin(), vertices[p].end());
        vertices[p].erase(std::unique(vertices[p].begin(), vertices[p].end()), vertices[p].end());
      },
      1);
  return vertices;
}

/// How far vertices lie from the boundary that they are to follow.
struct Offsets {
  std::size_t vertices = 0, near = 0;
  double sum_mm = 0;  ///< Outwards, of those near.
};

Offsets offsets_of(const TetMesh& mesh, const ImageSurface& surface,
                   const std::vector<std::uint32_t>& vertices) {
  constexpr std::size_t kBlock = 256;
  return parallel::reduce_blocks<Offsets>(
      vertices.size(), kBlock, {},
      [&](std::size_t begin, std::size_t end) {
        Offsets offsets{end - begin};
        for (std::size_t i = begin; i < end; ++i) {
          const Vec3& point = mesh.point(VertexId(vertices[i]));
          const std::optional<SurfacePoint> boundary = surface.boundary_near(point);
          if (!boundary) continue;
          ++offsets.near;
          offsets.sum_mm += boundary->normal.dot(point - boundary->point);
        }
        return offsets;
      },
      [](const Offsets& a, const Offsets& b) {
        return Offsets{a.vertices + b.vertices, a.near + b.near, a.sum_mm + b.sum_mm};
      });
}

}  // namespace

std::size_t follow_image(const TetMesh& mesh, const std::shared_ptr<const ImageDomain>& domain,
                         PatchShapes& shapes) {
  const BoundaryFaces faces = mesh.boundary_faces();
  const std::vector<Label> inside = labels_inside(mesh, faces);
  const auto vertices = vertices_of_patches(faces, shapes.size());
  std::size_t following = 0;
  Offsets all;
  for (std::size_t p = 0; p < shapes.size(); ++p) {
    if (shapes[p].freedom != PatchFreedom::kCurved || shapes[p].surface->is_analytic() ||
        inside[p] == kBackground)
      continue;
    const auto surface =
        std::make_shared<ImageSurface>(domain, material_of(*domain, inside[p]), 0, shapes[p].surface,
                                       kReachVoxels * domain->voxel_size_mm());
    const Offsets offsets = offsets_of(mesh, *surface, vertices[p]);
    if (offsets.near > 0) surface->set_shift(offsets.sum_mm / static_cast<double>(offsets.near));
    all.vertices += offsets.vertices;
    all.near += offsets.near;
    shapes[p].surface = surface;
    ++following;
  }
  if (2 * all.near < all.vertices)
    throw Error(
        ErrorKind::kBadInput,
        "most of the mesh's surface lies far off its boundary, more than 1.5 voxels; give the image that the "
        "mesh was made of, in the same frame and unit");
  return following;
}

}  // namespace lumesh::operators
