#pragma once
/// @file The direction of a vessel's axis at a place, from sections before and behind it.

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "lumesh/domain/domain.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// The cut of a plane through one vessel.
struct VesselSection {
  Vec3 centre_mm = Vec3::Zero();
  double area_mm2 = 0;
  double length_over_width = 1;  ///< Root of the ratio of its second moments.
};

/// The section around a place of a plane. None where the plane meets no vessel there, or one of the
/// surface's ends or the image's border in it.
/// @param reach_mm  The area and length of sections that go on beyond it are infinite.
using SectionOf = std::function<std::optional<VesselSection>(const CutPlane& plane, double reach_mm)>;

/// Sections by the voxels of a layer, as thick as the image's are along the plane's normal, that hang
/// together. @param cuts  Sections that reach beyond one of them are none.
[[nodiscard]] std::optional<VesselSection> section_of_voxels(const LabelImage& image,
                                                             std::span<const CutPlane> cuts,
                                                             const CutPlane& plane, double reach_mm);

/// Standard deviation of the centre of a circle's section by voxels along one direction: edges of voxels lie
/// evenly within half a voxel of the outline.
[[nodiscard]] inline double deviation_of_centre_mm(double radius_mm, double voxel_mm) {
  constexpr double kOfVoxel = 0.16;  // 1 / sqrt(12 pi).
  return kOfVoxel * voxel_mm * std::sqrt(voxel_mm / radius_mm);
}

/// Sections of a closed surface whose ends are patches of the kind opening. Cost: linear in its triangles.
[[nodiscard]] std::optional<VesselSection> section_of_surface(const MixedMesh& mesh, const CutPlane& plane,
                                                              double reach_mm);

/// The direction of a vessel's axis at a place.
struct AxisDirection {
  enum class Doubt : std::uint8_t {
    kNone,
    kShort,   ///< Sections of one vessel are fewer than four, or within a radius: ends and borders are near.
    kJoined,  ///< So are they, and to one side at least they become longer, or shorter: vessels join.
  };
  Doubt doubt = Doubt::kNone;
  Vec3 unit = Vec3::Zero();  ///< In the sense of the plane's normal.
  double error = 0;          ///< Standard deviation of its parts across, of length 1.
  /// Area of the section at the place, where sections stay alike for longer than those of a ball would, so
  /// that it is the vessel's own, oval or not; else 0.
  double section_mm2 = 0;
};

/// The tangent of the curve of the centres of sections, two radii to the one side of a place and one to the
/// other: parallel ones, or, where these leave it open, as in strong bends, ones that turn with the vessel.
/// @param guess  A plane through a point of the vessel, roughly across it, whose normal points to the side of
/// which one radius is looked at. @param layer_mm  Sections are not nearer to each other.
/// @param chance_mm  Standard deviation of a centre that the voxels leave.
[[nodiscard]] AxisDirection axis_by_sections(const SectionOf& section_of, const CutPlane& guess,
                                             double radius_mm, double layer_mm, double chance_mm);

/// The direction in which a vessel of a closed surface goes out of a flat end: the tangent there of the curve
/// of the centres of sections parallel to the end, over two radii before it. None where they are not those of
/// one vessel over a radius, or scatter.
[[nodiscard]] std::optional<Vec3> axis_before_end(const MixedMesh& mesh, const Vec3& centre_mm,
                                                  const Vec3& normal, double radius_mm);

/// The direction of the axis by its line and by sections: their mean by their errors, and by the sections
/// alone where both disagree; by the line alone where sections are too few. None where vessels join, or where
/// both disagree and sections scatter.
/// @param by_line  Unit.
[[nodiscard]] std::optional<Vec3> axis_of_both(const Vec3& by_line, const AxisDirection& by_sections);

}  // namespace lumesh
