#pragma once
// Openings that two vessels share, as they touch there.

#include <array>
#include <optional>

#include "lumesh/domain/openings.hpp"

namespace lumesh {

struct SectionWaist {
  double width_mm = 0;
  std::array<double, 2> diameters_mm{};  ///< Diameters of the parts' largest inscribed circles, falling.

  [[nodiscard]] double share() const { return width_mm / diameters_mm[1]; }
};

/// The waist of an opening that two vessels seem to share: its section narrows to 0.9 of the narrower part's
/// diameter or less between two compact parts of 3 voxels in diameter or more, and so does the section a
/// radius of that part further in, one of the two to 0.85; none elsewhere, as of rims and of hollow sections.
/// A fork of one vessel is round further in. Parts are those of the watersheds of the distance from the
/// outline. The smooth boundary hides where vessels of less than 4 voxels in radius touch.
[[nodiscard]] std::optional<SectionWaist> find_waist(const Domain& domain, const Opening& opening);

/// The section of a label on the squares of another one, moved: the parts that lie before those inside it.
[[nodiscard]] OpeningSquares section_before(const Domain& domain, Label label, const OpeningSquares& section,
                                            const Vec3& way_mm);

}  // namespace lumesh
