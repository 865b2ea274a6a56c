#pragma once
/// @file Meshes that layers are grown on, and what is measured of the result.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "fixtures/images.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/lattice/lattice.hpp"
#include "lumesh/layers/layers.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/mesh/validate.hpp"

namespace lumesh::fixtures {

[[nodiscard]] inline TetMesh meshed(const LabelImage& image) {
  const ImageDomain domain(image, {});
  Context context;
  return TetMesh::build(mesh_lattice(image, domain, {}, context).mesh.view());
}

[[nodiscard]] inline TetMesh ball(double radius_mm) {
  const int size = static_cast<int>(2 * radius_mm) + 8;
  const Vec3 centre = Vec3::Constant(0.5 * (size - 1));
  return meshed(voxels_of(frame_of({size, size, size}), {0, 1},
                          [&](const Vec3& p) { return (p - centre).norm() < radius_mm ? 1 : 0; }));
}

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kTubeRadius = 10;

/// Along z, open at both ends.
[[nodiscard]] inline TetMesh tube(double radius_mm = kTubeRadius) {
  return meshed(voxels_of(frame_of({40, 40, 50}), {0, 1}, [=](const Vec3& p) {
    return std::hypot(p.x() - 19.5, p.y() - 19.5) < radius_mm ? 1 : 0;
  }));
}

/// Two balls 4 mm apart, joined by a bridge far from the gap's middle.
[[nodiscard]] inline TetMesh near_balls() {
  const Vec3 a(14, 14, 14), b(38, 14, 14);
  return meshed(voxels_of(frame_of({53, 30, 40}), {0, 1}, [&](const Vec3& p) {
    const bool bridge = std::hypot(p.y() - 14, p.z() - 22) < 4 && p.x() > 14 && p.x() < 38;
    return (p - a).norm() < 10 || (p - b).norm() < 10 || bridge ? 1 : 0;
  }));
}

[[nodiscard]] inline double between(double low, double high, std::mt19937& random) {
  return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
}

/// Four balls, each near the one before.
[[nodiscard]] inline TetMesh random_blobs(std::mt19937& random) {
  std::vector<std::pair<Vec3, double>> balls;
  Vec3 at = Vec3::Constant(20);
  for (int i = 0; i < 4; ++i) {
    balls.emplace_back(at, between(3, 8, random));
    at += Vec3(between(-7, 7, random), between(-7, 7, random), between(-7, 7, random));
    at = at.cwiseMax(8).cwiseMin(32);
  }
  return meshed(voxels_of(frame_of({40, 40, 40}), {0, 1}, [&](const Vec3& p) {
    return std::any_of(balls.begin(), balls.end(),
                       [&](const auto& one) { return (p - one.first).norm() < one.second; })
               ? 1
               : 0;
  }));
}

inline LayerResult grown(const TetMesh& mesh, const LayerOptions& options) {
  Context context;
  return grow_layers(mesh, options, context);
}

[[nodiscard]] inline MixedMesh copy_of(const TetMesh& mesh) {
  const BoundaryFaces faces = mesh.boundary_faces();
  return copy_of(mesh.view(faces));
}

[[nodiscard]] inline double volume_of(const MixedMesh& mesh, Label label) {
  for (const LabelBoundary& one : validate(mesh.view()).labels)
    if (one.label == label) return one.volume;
  return 0;
}

[[nodiscard]] inline double area_of(const MixedMesh& mesh, const std::string& patch) {
  double area = 0;
  for_each_patch_triangle(mesh.view(), [&](const Cell<3>& c, std::int32_t p) {
    if (mesh.info.patches[static_cast<std::size_t>(p)].name == patch)
      area +=
          0.5 * (mesh.points[c[1]] - mesh.points[c[0]]).cross(mesh.points[c[2]] - mesh.points[c[0]]).norm();
  });
  return area;
}

/// Faces of cells of every shape that no other cell has, by their sorted corners.
class Faces {
 public:
  explicit Faces(const MixedMesh& mesh) {
    for (const Cell<4>& c : mesh.tetrahedra)
      for (const auto& [i, j, k] : {std::array{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}})
        add({at(c, i), at(c, j), at(c, k)});
    for (const Cell<5>& c : mesh.pyramids) {
      add({c[0], c[1], c[2], c[3]});
      for (int i = 0; i < 4; ++i) add({at(c, i), at(c, (i + 1) % 4), c[4]});
    }
    for (const Cell<6>& c : mesh.prisms) {
      add({c[0], c[1], c[2]}), add({c[3], c[4], c[5]});
      for (int i = 0; i < 3; ++i) add({at(c, i), at(c, (i + 1) % 3), at(c, 3 + (i + 1) % 3), at(c, 3 + i)});
    }
    for (const Cell<8>& c : mesh.hexahedra) {
      add({c[0], c[1], c[2], c[3]}), add({c[4], c[5], c[6], c[7]});
      for (int i = 0; i < 4; ++i) add({at(c, i), at(c, (i + 1) % 4), at(c, 4 + (i + 1) % 4), at(c, 4 + i)});
    }
  }
  [[nodiscard]] int times(std::vector<std::uint32_t> face) const {
    std::sort(face.begin(), face.end());
    const auto found = times_.find(face);
    return found == times_.end() ? 0 : found->second;
  }
  [[nodiscard]] std::size_t on_the_outside() const {
    return static_cast<std::size_t>(
        std::count_if(times_.begin(), times_.end(), [](const auto& one) { return one.second == 1; }));
  }
  [[nodiscard]] bool are_at_most_two() const {
    return std::all_of(times_.begin(), times_.end(), [](const auto& one) { return one.second <= 2; });
  }

 private:
  template <class Any>
  static std::uint32_t at(const Any& c, int i) {
    return c[static_cast<std::size_t>(i)];
  }
  void add(std::vector<std::uint32_t> face) {
    std::sort(face.begin(), face.end());
    ++times_[face];
  }
  std::map<std::vector<std::uint32_t>, int> times_;
};

/// Every face is shared by two cells or lies on the outside with a patch; interfaces between.
inline void expect_conforming(const MixedMesh& mesh) {
  const Faces faces(mesh);
  EXPECT_TRUE(faces.are_at_most_two());
  std::size_t outside = 0;
  const auto look = [&](const auto& cells, const std::vector<std::int32_t>& patches) {
    for (std::size_t f = 0; f < cells.size(); ++f) {
      const bool between =
          mesh.info.patches[static_cast<std::size_t>(patches[f])].kind == PatchKind::kInterface;
      ASSERT_EQ(faces.times({cells[f].begin(), cells[f].end()}), between ? 2 : 1);
      outside += between ? 0 : 1;
    }
  };
  look(mesh.triangles, mesh.triangle_patches);
  look(mesh.quadrilaterals, mesh.quadrilateral_patches);
  EXPECT_EQ(outside, faces.on_the_outside());
}

}  // namespace lumesh::fixtures
