#pragma once
/// @file Sections of vessels at openings, and where their vessels lead, for extensions.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lumesh/geometry/wall_ramp.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::layers {

/// A face of a patch, with three or four corners.
struct PatchFace {
  std::vector<std::uint32_t> corners;
  std::int32_t patch;
  Label label = kBackground;  // Of the cell behind it: a patch may have several.
};

/// The openings that go on together.
struct SweptSection {
  std::vector<std::int32_t> patches;
  std::vector<PatchFace> faces;
  std::vector<std::uint32_t> vertices;  // Ascending.
  Vec3 centre_mm = Vec3::Zero(), normal = Vec3::Zero(), axis = Vec3::Zero();
  double reach_mm = 0, radius_mm = 0, edge_mm = 0;
  /// Where it becomes a circle: over this length, and then so many times as far from the axis, by vertex.
  double transition_mm = 0;
  std::vector<double> of_circle = {};
  bool is_clear = true;   // Whether the walls say the axis.
  bool is_rough = false;  // Whether they say it badly.
  WallRamp ramp = {Vec3::UnitZ(), 1};

  /// The place of a vertex that has gone so far along the axis.
  [[nodiscard]] Vec3 swept(const Vec3& point, std::uint32_t v, double along_mm) const;
  [[nodiscard]] bool has(std::int32_t patch) const {
    return std::ranges::find(patches, patch) != patches.end();
  }

 private:
  [[nodiscard]] Vec3 towards_circle(const Vec3& point, std::uint32_t v, double along_mm) const;
};

/// The sections of a mesh, which must live as long; it may grow between calls.
class SectionFinder {
 public:
  explicit SectionFinder(const MixedMesh& mesh) : mesh_(mesh) {}

  /// The section of an opening and those that touch it in one plane, with the vessel's axis. No faces: the
  /// patch has none.
  [[nodiscard]] SweptSection section_at(std::int32_t first) const;
  /// Gives the faces the labels of the cells behind them.
  void find_labels(SweptSection& s) const;
  /// Gives the section the slopes of its walls. @param row_mm  Height of a row of the wall. @param most_mm
  /// Most length that the ramp may have.
  void find_ramp(SweptSection& s, double row_mm, double most_mm) const;
  /// Makes the section a circle of its area over a length. @return False, and the section stays as it is, if
  /// it is not star-shaped.
  [[nodiscard]] bool find_circle(SweptSection& s, double transition_mm) const;

 private:
  struct WallDirection {
    Vec3 along = Vec3::Zero();
    double left = std::numeric_limits<double>::infinity();  // R.m.s. of the equations; infinite: left open.
  };

  [[nodiscard]] const Patch& patch(std::int32_t p) const {
    return mesh_.info.patches[static_cast<std::size_t>(p)];
  }
  [[nodiscard]] const Vec3& point(std::uint32_t v) const { return mesh_.points[v]; }
  [[nodiscard]] Vec3 area_normal(std::span<const std::uint32_t> face) const;
  [[nodiscard]] Vec3 middle_of(std::span<const std::uint32_t> face) const;
  [[nodiscard]] std::vector<Vec3> patch_normals() const;
  [[nodiscard]] std::vector<std::int32_t> joined_openings(std::int32_t first) const;
  [[nodiscard]] double hollow_lumen_mm2(const SweptSection& s, double section_mm2) const;
  [[nodiscard]] Vec3 axis_at(SweptSection& s) const;
  template <class Function>
  void for_each_wall_before(const SweptSection& s, double depth_mm, const Function& function) const;
  [[nodiscard]] std::vector<Vec3> middles_of_parts(std::span<const std::uint32_t> face, double long_mm) const;
  [[nodiscard]] WallDirection wall_direction(const SweptSection& s, double depth_mm) const;

  const MixedMesh& mesh_;
};

}  // namespace lumesh::layers
