#include "lumesh/quality/hausdorff.hpp"

#include <algorithm>
#include <cmath>

#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/mesh/points_in_use.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"
#include "nearby.hpp"
#include "on_planes.hpp"
#include "samples.hpp"
#include "voxel_faces.hpp"

namespace lumesh::quality {

namespace {

/// Image, cuts and scale of one comparison.
struct Scene {
  const LabelImage& image;
  CutPlanes planes;
  double voxel_size_mm;

  [[nodiscard]] Vec3 place_of(const std::array<std::int32_t, 3>& twice_index) const {
    return image.frame().to_physical(Vec3(twice_index[0], twice_index[1], twice_index[2]) / 2);
  }
};

DistanceSummary mesh_to_image(const Scene& scene, std::span<const Vec3> points,
                              std::span<const Cell<3>> triangles, const FaceTree& boundary) {
  const auto distances_of = [&](std::size_t t, std::vector<WeightedValue>& out) {
    const Vec3 &a = points[triangles[t][0]], &b = points[triangles[t][1]], &c = points[triangles[t][2]];
    if (scene.planes.contain({a, b, c})) return;
    double distance = std::numeric_limits<double>::infinity();
    Vec3 last = a;
    sample_triangle(a, b, c, 0.5 * scene.voxel_size_mm, [&](const Vec3& p, double weight) {
      distance = boundary.distance(along_axes(scene.image.frame(), p), bound_from(distance, last, p));
      last = p;
      out.push_back({distance, weight, p});
    });
  };
  std::vector<WeightedValue> values = parallel::collect<WeightedValue>(triangles.size(), 256, distances_of);
  return summarise(values);
}

double area_of(const VoxelFace& face, const Vec3& spacing_mm) {
  return spacing_mm.prod() / spacing_mm[face.axis];
}

/// Corners of the faces, each once, as doubled indices.
std::vector<std::array<std::int32_t, 3>> corners_of(std::span<const VoxelFace> faces) {
  std::vector<std::array<std::int32_t, 3>> corners(4 * faces.size());
  parallel::for_each_index(faces.size(), [&](std::size_t i) {
    const int u = (faces[i].axis + 1) % 3, v = (faces[i].axis + 2) % 3;
    for (int c = 0; c < 4; ++c) {
      std::array<std::int32_t, 3>& corner = corners[4 * i + static_cast<std::size_t>(c)];
      corner = faces[i].twice_centre;
      corner[u] += (c & 1) ? 1 : -1;
      corner[v] += (c & 2) ? 1 : -1;
    }
  });
  parallel::sort_unique(corners);
  return corners;
}

/// Runs distance queries over blocks of consecutive items; item(i) gives a value whose weight and place are
/// set.
template <class MakeItem>
std::vector<WeightedValue> distances_to(const TriangleTree& tree, std::size_t count, const MakeItem& item) {
  std::vector<WeightedValue> values(count);
  for_each_nearby(tree, count, [&](Nearby& nearby, std::size_t i) {
    values[i] = item(i);
    values[i].value = nearby.distance(values[i].place_mm);
  });
  return values;
}

DistanceSummary image_to_mesh(const Scene& scene, const TriangleTree& surface,
                              std::span<const VoxelFace> all_faces) {
  std::vector<VoxelFace> faces;
  for (const VoxelFace& face : all_faces)
    if (!scene.planes.beyond(scene.place_of(face.twice_centre))) faces.push_back(face);
  std::vector<std::array<std::int32_t, 3>> corners = corners_of(faces);
  std::erase_if(corners, [&](const auto& corner) { return scene.planes.beyond(scene.place_of(corner)); });
  const Vec3& spacing = scene.image.frame().spacing_mm;
  std::vector<WeightedValue> values = distances_to(surface, faces.size(), [&](std::size_t i) {
    return WeightedValue{0, area_of(faces[i], spacing), scene.place_of(faces[i].twice_centre)};
  });
  const std::vector<WeightedValue> at_corners = distances_to(surface, corners.size(), [&](std::size_t i) {
    return WeightedValue{0, 0, scene.place_of(corners[i])};
  });
  values.insert(values.end(), at_corners.begin(), at_corners.end());
  return summarise(values);
}

std::vector<Vec3> used_points(const Scene& scene, std::span<const Vec3> points,
                              std::span<const Cell<3>> triangles) {
  const std::vector<std::uint8_t> used = points_in_use(points.size(), triangles);
  std::vector<Vec3> result;
  for (std::size_t v = 0; v < points.size(); ++v)
    if (used[v] != 0 && !scene.planes.contain({points[v]})) result.push_back(points[v]);
  return result;
}

void compare_points(const Scene& scene, const std::vector<Vec3>& vertices, std::span<const VoxelFace> faces,
                    SurfaceDistances& result) {
  std::vector<VoxelFace> voxels = boundary_voxels(faces);
  std::erase_if(voxels, [&](const VoxelFace& voxel) {
    return scene.planes.beyond(scene.place_of(voxel.twice_centre));
  });
  if (vertices.empty() || voxels.empty()) return;
  std::vector<Cell<3>> as_triangles(vertices.size());  // A triangle of three equal corners is a point.
  for (std::uint32_t v = 0; v < vertices.size(); ++v) as_triangles[v] = {v, v, v};
  const TriangleTree vertex_tree(vertices, as_triangles);
  const FaceTree voxel_tree(voxels, scene.image.frame().spacing_mm);
  std::vector<WeightedValue> to_vertices =
      distances_to(vertex_tree, voxel_tree.faces().size(), [&](std::size_t i) {
        return WeightedValue{0, 1, scene.place_of(voxel_tree.faces()[i].twice_centre)};
      });
  for (const WeightedValue& v : to_vertices)
    result.voxels_to_vertices_mm = std::max(result.voxels_to_vertices_mm, v.value);
  result.vertices_to_voxels_mm = parallel::max_of(vertices.size(), 1024, 0.0, [&](std::size_t i) {
    return voxel_tree.distance(along_axes(scene.image.frame(), vertices[i]));
  });
  result.vertex_to_voxel_two_sided_mm = std::max(result.vertices_to_voxels_mm, result.voxels_to_vertices_mm);
}

std::optional<SurfaceDistances> compare(const Scene& scene, std::span<const Vec3> points,
                                        const std::vector<Cell<3>>& triangles, std::vector<VoxelFace> faces) {
  if (triangles.empty() || faces.empty()) return std::nullopt;
  SurfaceDistances result;
  const FaceTree boundary(std::move(faces), scene.image.frame().spacing_mm);
  result.mesh_to_image_mm = mesh_to_image(scene, points, triangles, boundary);
  result.image_to_mesh_mm = image_to_mesh(scene, TriangleTree(points, triangles), boundary.faces());
  compare_points(scene, used_points(scene, points, triangles), boundary.faces(), result);
  return result;
}

}  // namespace

ImageDistances compare_with_image(const MeshView& mesh, const MeshSurface& surface, const LabelImage& image,
                                  std::span<const CutPlane> planes) {
  ImageDistances result;
  result.voxel_size_mm = std::cbrt(image.frame().voxel_volume_mm3());
  const Scene scene{image, CutPlanes(planes, result.voxel_size_mm), result.voxel_size_mm};
  std::vector<LabelFaces> labels = collect_voxel_faces(image);
  std::vector<VoxelFace> outer;
  for (LabelFaces& label : labels) {
    if (labels.size() > 1)
      for (const VoxelFace& face : label.faces)
        if (face.other == 0) outer.push_back(face);
    result.labels.push_back(
        {label.label, label.voxels, static_cast<double>(label.voxels) * image.frame().voxel_volume_mm3(),
         compare(scene, mesh.points, surface.around(label.label), std::move(label.faces))});
  }
  const std::vector<Cell<3>> outside = surface.outer();
  const bool same = labels.size() == 1 && surface.around(labels[0].label).size() == surface.triangles.size();
  if (same)
    result.outer = result.labels[0].distances;
  else if (labels.size() > 1)
    result.outer = compare(scene, mesh.points, outside, std::move(outer));
  return result;
}

}  // namespace lumesh::quality
