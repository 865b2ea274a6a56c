#pragma once
// Sections at the image's border that are no ends of vessels: what the border cuts along its side.

#include <optional>
#include <span>

#include "lumesh/vessels/opening_sections.hpp"

namespace lumesh {

/// How the object goes on behind a section.
struct SideCut {
  double depth_mm = 0;  ///< Up to which it was followed.
  double share = 0;     ///< Its area there over that at the border.

  [[nodiscard]] bool grows() const { return share > 1; }
};

/// Follows the object, all labels alike, from a section into the image, parallel to the border. A vessel
/// keeps its section over a radius (of the circle of the same area), whatever the angle it leaves at; a
/// vessel that the border cuts along its length ends within that, and what is cut off the side of a bend or a
/// sac, or a vessel where it joins a wider one, grows within 0.35 of it, or a voxel. A sac that is cut
/// through shrinks to less than half within one and a half radii of its largest section, and by less than a
/// quarter over the first half of that way, as vessels that taper do not; then no layer reaches another face
/// of the image, or has grown by 40 % and is as long as a vessel that turns. None where neither is so, where
/// voxels are too few to tell, where a cut plane leaves out what is followed, and for tissue, which reaches
/// all faces of the image around it or is more than eight times as large as the section. Cost: up to eight
/// times the voxels of the section, four radii deep.
[[nodiscard]] std::optional<SideCut> find_side_cut(const LabelImage& image, std::span<const CutPlane> cuts,
                                                   const BorderSection& section);

}  // namespace lumesh
