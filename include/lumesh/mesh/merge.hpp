#pragma once
/// @file Several meshes that touch as one, with shared vertices.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

class OptionList;

/// Meaning of a label that stands in several meshes under one number.
enum class EqualLabels : std::uint8_t {
  kByName,  ///< One material, unless both have names that differ.
  kApart,   ///< Another material in each mesh.
  kSame,    ///< One material, whatever its names: the parts come from one mesh.
};

struct MergeOptions {
  /// Points of different surfaces that are no farther apart are one, in the points' unit, >= 0. Without a
  /// value: 2e-6 of the largest coordinate, which is what single precision or six digits leave, but no more
  /// than a tenth of the shortest edge of the surfaces.
  std::optional<double> tolerance = {};
  EqualLabels equal_labels = EqualLabels::kByName;
  bool allows_apart = false;  ///< Takes meshes that share no face, too.
  /// Parts that come from one mesh: surfaces that nearly touch are grooves of it, and not looked at.
  bool surfaces_match = false;

  /// Options for parts that part_of() made of one mesh.
  [[nodiscard]] static MergeOptions of_one_mesh() {
    return {
        .tolerance = 0.0, .equal_labels = EqualLabels::kSame, .allows_apart = true, .surfaces_match = true};
  }
  void describe(OptionList& list);
};

/// One of the meshes.
struct MergePart {
  const MixedMesh* mesh = nullptr;
  std::string name;  ///< For messages, such as its file.
};

struct MergeReport {
  /// A label of a part that has another number in the result.
  struct Renumbered {
    std::size_t part = 0;
    Label from = kBackground, to = kBackground;
    std::string name;
  };
  double tolerance = 0;             ///< As used.
  std::uint64_t shared_points = 0;  ///< Points of the result that are in more than one part.
  std::uint64_t shared_faces = 0;   ///< Triangles and quadrilaterals that two parts share.
  double shared_area = 0;           ///< In the square of the points' unit.
  double farthest = 0;              ///< Largest distance of points that became one.
  std::vector<Renumbered> renumbered;
};

struct MergeResult {
  MixedMesh mesh;
  MergeReport report;
};

/// Joins meshes whose outer surfaces share faces into one conforming mesh.
///
/// Points of the surfaces that coincide become one, at the place it has in the first part. Faces that
/// coincide then lie between two cells: between two labels they are a patch of kind kInterface that keeps the
/// name of the patch in the first part that coincides as a whole (else "interface_A_B"); within one label
/// they are gone. Patches of the same name and kind are one; of the same name and different kinds, the later
/// one becomes NAME_2. Labels of the same name are one material; those of the same number as
/// MergeOptions::equal_labels says, where the later one gets the next free number. Points and cells keep
/// their order, part after part. The metric stays where all parts have one, and so do wanted sizes.
///
/// @param parts  At least two, of the same unit and frame; faces without patch stay without.
/// @throws Error{kBadInput} if a part's cells overlap; if parts lie on the same side of a face, so overlap;
/// if surfaces lie on each other whose faces differ; if a part shares no face with the others; if a
/// tetrahedron turns over as its points move; if points of one part lie within the tolerance of each other.
/// Overlap is found at shared faces only. Parallel inside, bitwise identical for every thread count. Memory:
/// about 100 bytes per tetrahedron besides the meshes. Cost: about 1 s per million tetrahedra on two cores.
[[nodiscard]] MergeResult merge_meshes(std::span<const MergePart> parts, const MergeOptions& options = {});

}  // namespace lumesh
