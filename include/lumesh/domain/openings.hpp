#pragma once
/// @file Where the object is cut off, before anything is meshed; and what a mesh makes of it.

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// A connected part of one label's section in one cut plane (a border of the image, or one that was asked
/// for).
struct Opening {
  Label label = kBackground;
  double area_mm2 = 0;
  Vec3 centre_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< Unit, out of the object.
  Box3 box_mm;                  ///< Around the part.

  /// Of the circle with the same area.
  [[nodiscard]] double radius_mm() const { return std::sqrt(area_mm2 / std::numbers::pi); }
};

/// The openings of a domain by falling area, so that the first is the inlet where names follow their order;
/// none if it has no cut planes. Areas are right to about 0.2 %. A part smaller than half a voxel's face is
/// none: a wall that grazes the border. Threads: parallel inside, the same bits for every thread count. Cost:
/// about 0.1 us for each voxel of the cut planes that may hold the object, and 2 ms per opening.
[[nodiscard]] std::vector<Opening> find_openings(const Domain& domain);

/// A place near the rim of an opening: in the cut plane, within `step_mm` of where a label ends there.
struct RimPlace {
  Vec3 position_mm;
  std::array<Material, 3> materials;  ///< The label, what is beside it, and what is beyond the plane.
};

/// At least one within twice `step_mm` of any place of a rim. Cost: as find_openings(), for squares of that
/// size.
[[nodiscard]] std::vector<RimPlace> find_rim_places(const Domain& domain, double step_mm);

/// Number of the opening that a part of a mesh is: of those of its label with a plane within a voxel of its
/// centre, the nearest; `openings.size()` if there is none within a voxel of its box.
[[nodiscard]] std::size_t nearest_opening(std::span<const Opening> openings, Label label,
                                          const Vec3& centre_mm, const Vec3& normal, double voxel_mm);

/// An opening in image and mesh.
struct OpeningInMesh {
  Opening opening;
  std::string patches;  ///< Names, joined by " + "; empty if the mesh does not have it.
  double mesh_area_mm2 = 0;

  [[nodiscard]] double change_percent() const { return 100 * (mesh_area_mm2 / opening.area_mm2 - 1); }
};

struct OpeningsCompared {
  std::vector<OpeningInMesh> openings;  ///< All of the domain.
  std::vector<std::string> others;      ///< Openings of the mesh that are none of the domain.
};

/// @param mesh  Of the domain; its patches of PatchKind::kOpening are looked at.
[[nodiscard]] OpeningsCompared compare_openings(const MeshView& mesh, std::span<const Opening> openings,
                                                double voxel_mm);

/// More than this and an opening's area is wrong.
inline constexpr double kWrongOpeningPercent = 5;

[[nodiscard]] inline bool is_wrong(const OpeningInMesh& opening) {
  return opening.patches.empty() || std::abs(opening.change_percent()) > kWrongOpeningPercent;
}

/// A line for each opening that is missing or whose area is wrong, and for the others.
[[nodiscard]] std::vector<std::string> doubts_about(const OpeningsCompared& compared);

}  // namespace lumesh
