#pragma once
/// @file Flow extensions: vessels of an image that go on straight beyond their openings.

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lumesh/domain/image_domain.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

class OptionList;
struct OptionParsed;

/// A length in mm, or in radii of the vessel where it is taken.
struct LocalLength {
  double value = 0;
  bool is_in_radii = false;

  [[nodiscard]] double in_mm(double radius_mm) const { return is_in_radii ? value * radius_mm : value; }
  [[nodiscard]] std::string text() const;  ///< "5r", "12.5".
  [[nodiscard]] bool is_valid() const;     ///< Finite and at least 0.
};

/// The length of a text: "5r" is five radii, "12.5" as many mm.
/// @throws Error{kUsage} for other texts, which does not name the option.
[[nodiscard]] LocalLength local_length_from(const std::string& text);

/// The length of one opening; of all that are not named, where the name is empty.
struct NamedLength {
  std::string opening;
  LocalLength length;
};

/// Lengths of a list: "5r", "inlet_1=10r,outlet_2=0", "5r,outlet_2=0". @throws Error{kUsage} as
/// local_length_from().
[[nodiscard]] std::vector<NamedLength> named_lengths_from(const std::string& text);

/// Option of a length in these words.
[[nodiscard]] OptionParsed local_length_option(std::optional<LocalLength>& length);

/// The length of a vessel, of which a name among several is one with another length than those of all.
/// @param names  Of its openings. @throws Error{kBadInput} if two of them have different lengths, or for more
/// than a thousand radii.
[[nodiscard]] double length_wanted_mm(std::span<const NamedLength> lengths,
                                      const std::vector<std::string>& names, double radius_mm);
/// @throws Error{kBadInput} for a name that no opening has. @param where  What has them: "the mesh".
void check_names_of(std::span<const NamedLength> lengths, const std::vector<std::string>& openings,
                    const std::string& where);

struct ExtensionOptions {
  std::vector<NamedLength> lengths = {};       ///< None: no extension.
  std::optional<LocalLength> transition = {};  ///< From the section to a circle; none: the section is kept.

  [[nodiscard]] bool is_wanted() const { return !lengths.empty(); }
  void describe(OptionList& list);
  /// The lengths alone, for meshes, whose sections are kept.
  void describe_lengths(OptionList& list);
  /// @throws Error{kUsage} that names the option.
  void validate() const;
};

struct ExtendedImage {
  LabelImage image;  ///< Its values, with the extensions; of another size and origin than before.
  std::shared_ptr<const ImageDomain> domain;
  std::vector<std::string> notes;  ///< Extensions that are not as asked for.
};

/// Extends the vessels of an image beyond their openings. From an opening on, the section in its plane, all
/// labels alike, is carried along the vessel's axis there, so that wall and lumen stay a pair; over the
/// transition it becomes a circle of the same area. The vessel ends flat, square to the axis, in an opening
/// of the same name. Within the image, the functions of the labels stay as they are to the last bit. The
/// axis is that of the sections over one radius before the opening; where these do not tell it, the normal.
/// An extension that would come near to another, or to the object, is one radius shorter than that (five
/// voxels at least), with a note. Openings that are not extended stay where they are.
///
/// @param domain  Of the image. @param openings  find_openings() of it.
/// @throws Error{kBadInput} if an opening that is named does not exist, or if the grid of the extended image,
/// around the object and extensions, would have more than four times the image's voxels and more than
/// 2^27. Cost: a copy of voxels and field. Threads: parallel inside, bitwise identical for every thread
/// count.
[[nodiscard]] ExtendedImage extend_openings(const LabelImage& image, const ImageDomain& domain,
                                            std::span<const Opening> openings,
                                            const ExtensionOptions& options);

}  // namespace lumesh
