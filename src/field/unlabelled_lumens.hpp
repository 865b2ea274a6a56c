#pragma once
// Background that the object encloses at the image's border, as the lumen of a vessel of which only the wall
// has a label. One smooth function for both sides of a thin wall is off where nothing goes on beyond the
// border.

#include <optional>

#include "label_pairs.hpp"

namespace lumesh::field {

/// Both sides of the wall as objects of their own.
struct UnlabelledLumens {
  LabelImage lumens;  ///< 1 in the lumens.
  LabelImage filled;  ///< The image, lumens filled.
  PairFaces faces_of_lumens, faces_of_filled;
};

/// Lumens: background that hangs together by faces, is surrounded by the object wherever it leaves the image,
/// and does not do so at all the object's faces. None of few voxels, which are noise.
/// @param outer_wall  Faces between all labels together and the background.
/// Cost: of the image's six faces; where the object surrounds any background there, of as much background as
/// it takes to come around the object, and one more copy of the image for lumens.
[[nodiscard]] std::optional<UnlabelledLumens> find_unlabelled_lumens(const LabelImage& image,
                                                                     const PairFaces& outer_wall);

}  // namespace lumesh::field
