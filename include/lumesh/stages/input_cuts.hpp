#pragma once
/// @file What of an image is cut off before it is meshed, and how far it goes on beyond its openings.

#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/domain/cut_plane.hpp"
#include "lumesh/domain/extension.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/polylines.hpp"

namespace lumesh {

class OptionList;

struct InputCuts {
  std::vector<CutPlane> planes = {};  ///< As they are, through everything.
  std::vector<Vec3> places_mm = {};   ///< Each cuts the one vessel there, square to its axis.
  std::string ends = {};            ///< For local_length_from(): how far from each end it is cut; empty: not.
  ExtensionOptions extension = {};  ///< Of what is left.

  [[nodiscard]] bool none() const { return planes.empty() && is_whole(); }
  /// But for planes, which a phantom can be cut with, too.
  [[nodiscard]] bool is_whole() const { return places_mm.empty() && ends.empty() && !extension.is_wanted(); }

  void describe(OptionList& list);
  /// @throws Error{kUsage} that names the option.
  void validate() const;
};

/// Cuts the vessels at the places, as cut_off_vessel() does, one after the other: each at the point of the
/// centerlines of its piece that is the fewest radii away. Then each end of the centerlines of the whole is
/// cut off, as far before it as `ends` says, in radii at that place; one that can't be stays, with a warning.
///
/// @param image  Loses what lies beyond.
/// @return Those and the whole planes, for ImageDomainOptions.
/// @throws Error{kBadInput} for a place without the object within three voxels, or more than two radii from
/// any axis, or beyond a cut before it; and as extract_centerline() and cut_off_vessel() do. Cost and
/// threads: for each place as these.
[[nodiscard]] std::vector<CutPlane> cut_off(LabelImage& image, const InputCuts& cuts, Context& context);

/// The domain of an image after cut_off(), extended as asked for. @param image, planes  Where it is extended:
/// become those of the result. @throws Error{kBadInput} as ImageDomain and extend_openings(), and if there is
/// no opening to extend.
[[nodiscard]] std::shared_ptr<const ImageDomain> domain_of_cut(LabelImage& image,
                                                               std::vector<CutPlane>& planes,
                                                               const InputCuts& cuts,
                                                               const LabelFieldOptions& field,
                                                               Context& context);

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

/// Each cut as the command line takes it: "--cut-at 1,2,3", "--cut-plane 1 2 3 0 0 1".
[[nodiscard]] std::vector<std::string> cut_options(const InputCuts& cuts);
/// What cuts the image that a mesh was made from, in the same words. @param provenance  Of the mesh: "cuts",
/// else what "options" says of them.
[[nodiscard]] std::vector<std::string> cut_options(const std::map<std::string, std::string>& provenance);
/// The key of that in provenances; its value has the cuts one after the other.
inline constexpr const char* kCutsKey = "cuts";

}  // namespace lumesh
