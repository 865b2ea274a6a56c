#pragma once
// Which vessels are extended how far.

#include <span>
#include <string>
#include <vector>

#include "lumesh/domain/extension.hpp"
#include "opening_groups.hpp"
#include "vessel_tube.hpp"

namespace lumesh {

struct ExtensionPlan {
  std::vector<OpeningGroup> groups;
  std::vector<VesselTube> tubes;  ///< One for each group; without length where it is not extended.
  std::vector<double> lengths_mm;
  std::vector<std::string> notes;
};

/// @throws Error{kBadInput} for names that no opening has, or lengths that contradict each other.
[[nodiscard]] ExtensionPlan plan_extensions(const ImageDomain& domain, std::span<const Opening> openings,
                                            const ExtensionOptions& options);

/// Whether the image's own object may be there: within the image, and not beyond what cuts it.
[[nodiscard]] bool is_of_image(const ImageDomain& domain, const Vec3& x);

}  // namespace lumesh
