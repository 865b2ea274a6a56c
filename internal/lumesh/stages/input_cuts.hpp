#pragma once
/// @file Cuts of an image in words, places where it cannot be cut, and extensions of what was cut.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/domain/extension.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/stages/input.hpp"

namespace lumesh {

/// An image without what is cut off. @param planes  Become those that cut it, for its domain.
/// @throws Error{kBadInput} that names the file.
[[nodiscard]] LabelImage read_cut_image(const std::string& path, const ImageSelection& selection,
                                        const InputCuts& cuts, std::vector<CutPlane>& planes,
                                        Context& context);

/// A warning of a plane that everything lies before.
[[nodiscard]] std::string line_on_plane_beyond(const CutPlane& plane);

/// The second half of domain_of_cut(). @param domain  Of the image, not extended. @param openings  Its
/// find_openings().
[[nodiscard]] std::shared_ptr<const ImageDomain> extended_domain(
    LabelImage& image, std::vector<CutPlane>& planes, const ImageDomain& domain,
    std::span<const Opening> openings, const ExtensionOptions& options, Context& context);

/// Why cut_off() would refuse to cut at a place; empty if it would not.
/// @param lines  Through the vessel there, with the scalar "radius" in mm. @param before  What cuts the image
/// already. Cost: a copy of the image, and as cut_off_vessel().
[[nodiscard]] std::string refusal_of_cut(const LabelImage& image, const Polylines& lines,
                                         std::span<const CutPlane> before, const Vec3& place_mm);

}  // namespace lumesh
