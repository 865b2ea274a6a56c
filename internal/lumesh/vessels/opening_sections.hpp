#pragma once
/// @file Openings at the image's border against the voxels there.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "lumesh/domain/openings.hpp"
#include "lumesh/field/field_options.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// Connected voxel faces of one label on one side of the image.
struct BorderSection {
  Label label = kBackground;
  std::vector<Vec3> centres_mm;  ///< Centres of the faces.
  double face_mm2 = 0;
  Vec3 normal = Vec3::UnitX();  ///< Out of the image.
  int axis = 0;                 ///< Axis of the image across it.
  bool is_last = false;         ///< Whether it is in the last layer along the axis.
  std::size_t edge_count = 0;   ///< Edges between its faces and others.
  /// Sections of its label in the next layer that lie behind it, by numbers of their own: how many faces each
  /// has.
  std::map<std::uint32_t, std::size_t> next_parts;

  [[nodiscard]] double area_mm2() const { return face_mm2 * static_cast<double>(centres_mm.size()); }
  [[nodiscard]] Vec3 centre_mm() const;
  [[nodiscard]] double reach_mm() const;  ///< No face is farther from the centre.
  /// Whether it has 8 faces or more: fewer may be a wall that grazes the border.
  [[nodiscard]] bool is_wide() const { return centres_mm.size() >= 8; }
};

/// Standard deviation of how many centres of voxels an outline of so many edges of voxels holds, by chance:
/// 0.676 r in circles of radius r, 0.085 per edge.
[[nodiscard]] inline double deviation_of_count(double edges) {
  constexpr double kPerEdge = 0.085;
  return std::sqrt(kPerEdge * edges);
}

/// Sections, without what lies beyond cuts. Cost: linear in the faces of the border.
[[nodiscard]] std::vector<BorderSection> border_sections(const LabelImage& image,
                                                         std::span<const CutPlane> cuts);

/// A line for each opening at the border whose section is far from what the faces of the border's voxels say:
/// its area by more than a tenth and 0.7 voxels times the section's width, or by more than a twentieth, 2.5
/// times the standard deviation of how many centres of voxels fall within an outline of its length, and a
/// tenth of what the section differs from the next layer's by; or that grows by more than a quarter within a
/// voxel, as a wall along the border does; or joined from separate sections; for sections of at least 8 faces
/// that are in no opening; for sections of hollow walls; and for openings in two or three faces of the image
/// that one vessel leaves through their edge; and for each pair of labels of which an opening lies in or
/// around one of the other. Smooth sections and voxels differ by less, measured on oblique
/// cylinders of 1.5 to 20 voxels in radius. For openings that are no ends of vessels, but cut along one or
/// off the side of one, instead of lines on their areas.
/// @param cuts  What lies beyond them is left out.
/// @param fidelity  Of the domain's boundary: remedies do not name what is in use. Cost: linear in the faces
/// of the border and, for each of its sections, in up to eight times its faces, a radius deep.
[[nodiscard]] std::vector<std::string> doubts_about_sections(
    const LabelImage& image, std::span<const CutPlane> cuts, std::span<const Opening> openings,
    BoundaryFidelity fidelity = BoundaryFidelity::kSmooth);

/// A line for each opening whose section narrows between two parts, here and further in, as where two vessels
/// touch, and for each at the image's border whose area is likely to be 8.5 % off or more, as its section
/// changes there and its voxels are few, but for those that are no ends of vessels; none of these where
/// values place the boundary. Told before openings are extended. Cost: linear in the faces of the border, and
/// about 1 ms per opening.
[[nodiscard]] std::vector<std::string> doubts_about_shapes(const LabelImage& image, const Domain& domain,
                                                           std::span<const Opening> openings);

}  // namespace lumesh
