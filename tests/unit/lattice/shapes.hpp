#pragma once
// Label images of shapes with known surfaces, and their meshes, for tests.

#include <gtest/gtest.h>

#include <functional>

#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/lattice/lattice.hpp"
#include "lumesh/mesh/validate.hpp"
#include "measures.hpp"

namespace lumesh::test {

inline MixedMesh meshed(const LabelImage& image, const LatticeOptions& options = {},
                        const ImageDomainOptions& domain_options = {}) {
  const ImageDomain domain(image, domain_options);
  Context context;
  return mesh_lattice(image, domain, options, context).mesh;
}

/// What every mesh promises: valid, oriented, angles within the default limits.
inline ValidationReport expect_good(const MixedMesh& mesh) {
  const ValidationReport report = validate(mesh.view());
  EXPECT_TRUE(report.ok()) << report.text();
  const AngleRange angles = dihedral_range(mesh);
  EXPECT_GE(angles.min_deg, 14.8);
  EXPECT_LE(angles.max_deg, 150.2);
  EXPECT_GT(smallest_cell_volume(mesh), 0);
  expect_conforming(mesh);
  return report;
}

inline void expect_label_volumes(const LabelImage& image, const MixedMesh& mesh, double tolerance) {
  std::map<Label, double> voxels;
  for (const LabelImage::Index index : image.voxels())
    voxels[image.values()[index]] += image.frame().voxel_volume_mm3();
  const auto found = label_volumes(mesh);
  for (const auto& [label, volume] : voxels) {
    if (label == kBackground) continue;
    ASSERT_EQ(found.count(label), 1U) << "label " << label << " is lost";
    EXPECT_NEAR(found.at(label), volume, tolerance * volume) << "label " << label;
  }
}

inline std::int32_t patch_number(const MixedMesh& mesh, const std::string& name) {
  for (std::size_t p = 0; p < mesh.info.patches.size(); ++p) {
    if (mesh.info.patches[p].name == name) return static_cast<std::int32_t>(p);
  }
  ADD_FAILURE() << "no patch " << name;
  return -1;
}

inline std::vector<Cell<3>> triangles_of(const MixedMesh& mesh, const std::string& name) {
  const std::int32_t patch = patch_number(mesh, name);
  std::vector<Cell<3>> found;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.triangle_patches[t] == patch) found.push_back(mesh.triangles[t]);
  }
  EXPECT_FALSE(found.empty()) << name;
  return found;
}

inline std::set<std::uint32_t> vertices_of(const std::vector<Cell<3>>& triangles) {
  std::set<std::uint32_t> found;
  for (const Cell<3>& t : triangles) found.insert(t.begin(), t.end());
  return found;
}

inline std::vector<std::string> patch_names(const MixedMesh& mesh) {
  std::vector<std::string> names;
  for (const Patch& p : mesh.info.patches) names.push_back(p.name);
  std::sort(names.begin(), names.end());
  return names;
}

/// How far patch vertices lie from a surface given by its distance, in voxels: mean and largest.
struct Offsets {
  double mean = 0, most = 0;
};
inline Offsets offsets_of(const MixedMesh& mesh, const std::string& patch,
                          const std::function<double(const Vec3&)>& distance) {
  const auto vertices = vertices_of(triangles_of(mesh, patch));
  Offsets result;
  for (const std::uint32_t v : vertices) {
    const double d = std::abs(distance(mesh.points[v]));
    result.mean += d / static_cast<double>(vertices.size());
    result.most = std::max(result.most, d);
  }
  return result;
}

/// Angles between a patch's triangles and a surface's normals: what the given share of the area keeps to.
inline double normal_error_deg(const MixedMesh& mesh, const std::string& patch, double share,
                               const std::function<Vec3(const Vec3&)>& normal) {
  std::vector<std::pair<double, double>> angle_and_area;
  double area = 0;
  for (const Cell<3>& t : triangles_of(mesh, patch)) {
    const Vec3 own = area_vector(mesh, t);
    const Vec3 truth = normal((mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]) / 3);
    angle_and_area.emplace_back(degrees(std::atan2(own.cross(truth).norm(), own.dot(truth))), own.norm());
    area += own.norm();
  }
  std::sort(angle_and_area.begin(), angle_and_area.end());
  double passed = 0;
  for (const auto& [angle, own] : angle_and_area) {
    passed += own;
    if (passed >= share * area) return angle;
  }
  return angle_and_area.back().first;
}

/// Calls body(place, inside, outside) for the centre and the corners of each face between two voxels of
/// different labels, in voxel indices.
template <class Body>
void for_each_place_between(const LabelImage& image, const Body& body) {
  const Index3 size = image.frame().size;
  for (int k = 1; k < size.z(); ++k) {
    for (int j = 1; j < size.y(); ++j) {
      for (int i = 1; i < size.x(); ++i) {
        for (int axis = 0; axis < 3; ++axis) {
          const Index3 voxel(i, j, k), other = voxel - Index3::Unit(axis);
          if (image.at(voxel) == image.at(other)) continue;
          const Vec3 centre = voxel.cast<double>() - 0.5 * Vec3::Unit(axis);
          body(centre, image.at(voxel), image.at(other));
          for (int corner = 0; corner < 4; ++corner) {
            Vec3 at = centre;
            at[(axis + 1) % 3] += corner % 2 == 0 ? -0.5 : 0.5;
            at[(axis + 2) % 3] += corner < 2 ? -0.5 : 0.5;
            body(at, image.at(voxel), image.at(other));
          }
        }
      }
    }
  }
}

/// From faces between voxels, centres and corners, to the mesh's triangles.
inline double worst_distance_mm(const LabelImage& image, const MixedMesh& mesh) {
  const TriangleTree tree(mesh.points, mesh.triangles);
  double worst = 0;
  for_each_place_between(image, [&](const Vec3& at, Material, Material) {
    worst = std::max(worst, tree.nearest(image.frame().to_physical(at)).distance);
  });
  return worst;
}

/// From the places of the domain's boundary that are nearest to these.
inline double worst_distance_from_domain_mm(const LabelImage& image, const ImageDomain& domain,
                                            const MixedMesh& mesh) {
  const TriangleTree tree(mesh.points, mesh.triangles);
  double worst = 0;
  int all = 0, found = 0;
  for_each_place_between(image, [&](const Vec3& at, Material a, Material b) {
    const auto place = domain.project(image.frame().to_physical(at), {std::min(a, b), std::max(a, b)},
                                      domain.voxel_size_mm());
    ++all;
    if (!place) return;
    ++found;
    worst = std::max(worst, tree.nearest(*place).distance);
  });
  EXPECT_GT(found, 0.8 * all);
  return worst;
}

}  // namespace lumesh::test
