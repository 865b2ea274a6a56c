#include "lumesh/operators/patch_shapes.hpp"

#include "lumesh/geometry/hilbert.hpp"

namespace lumesh::operators {
namespace {

/// What tells whether points lie in one plane.
struct Spread {
  Vec3 normal_sum = Vec3::Zero();
  Vec3 origin = Vec3::Zero();  // Any of the points.
  Box3 box;
};

/// The axis along which the box has no extent, if there is just one.
Vec3 flat_axis(const Box3& box) {
  const Vec3 extent = box.sizes();
  Vec3 axis = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    if (extent[k] == 0) axis[k] = 1;
  return axis.sum() == 1 ? axis : Vec3::Zero();
}

}  // namespace

PatchShapes planes_where_flat(const TetMesh& mesh, double tolerance) {
  const BoundaryFaces faces = mesh.boundary_faces();
  const std::span<const Vec3> points = mesh.points();
  const std::size_t patches = mesh.info().patches.size();
  std::vector<Spread> spreads(patches);
  for (std::size_t i = 0; i < faces.triangles.size(); ++i) {
    Spread& spread = spreads[static_cast<std::size_t>(faces.patches[i])];
    const auto [a, b, c] = faces.triangles[i];
    spread.normal_sum += (points[b] - points[a]).cross(points[c] - points[a]);
    for (const std::uint32_t v : faces.triangles[i]) spread.box.extend(points[v]);
    spread.origin = points[a];
  }
  PatchShapes shapes(patches);
  for (std::size_t p = 0; p < patches; ++p) {
    if (spreads[p].box.isEmpty()) continue;
    const Vec3 axis = flat_axis(spreads[p].box);
    const bool along_axis = axis.squaredNorm() > 0;
    if (!along_axis && !(spreads[p].normal_sum.norm() > 0)) continue;
    shapes[p].freedom = PatchFreedom::kPlane;
    shapes[p].normal = along_axis ? axis : spreads[p].normal_sum.normalized();
    shapes[p].offset = shapes[p].normal.dot(spreads[p].origin);
  }
  const double allowed = tolerance * bounding_box(points).diagonal().norm();
  for (std::size_t i = 0; i < faces.triangles.size(); ++i) {
    const auto p = static_cast<std::size_t>(faces.patches[i]);
    for (const std::uint32_t v : faces.triangles[i])
      if (std::abs(shapes[p].normal.dot(points[v] - spreads[p].origin)) > allowed) shapes[p] = {};
  }
  return shapes;
}

PatchShapes all_frozen(const TetMesh& mesh) {
  return PatchShapes(mesh.info().patches.size());
}

}  // namespace lumesh::operators
