#pragma once
/// @file Faces that the surfaces of several meshes share.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "joined_points.hpp"
#include "lumesh/mesh/cell_sides.hpp"

namespace lumesh::detail {

/// A face between two parts, the lower one first.
struct Contact {
  Cell<4> key;                         ///< As key_of(), of joined points.
  std::array<FaceCorners, 2> outward;  ///< Out of the cell of each part.
  std::array<std::uint32_t, 2> parts;
  std::array<Label, 2> labels;  ///< Of the cells, as the parts number them.
};

/// In the order of their keys.
/// @throws Error{kBadInput} if two parts lie on the same side of a face.
[[nodiscard]] std::vector<Contact> find_contacts(std::span<const PartSurface> parts,
                                                 const JoinedPoints& joined);

/// That of a face; null if there is none. @param contacts  In the order of their keys.
[[nodiscard]] const Contact* find_contact(std::span<const Contact> contacts, const FaceCorners& face);

/// @throws Error{kBadInput} where the surfaces of two parts lie on each other without sharing faces.
void check_surfaces_match(std::span<const PartSurface> parts, const JoinedPoints& joined,
                          std::span<const Contact> contacts);

/// @throws Error{kBadInput} unless shared faces join all parts; it says how far apart the first one is.
void check_parts_touch(std::span<const PartSurface> parts, const JoinedPoints& joined,
                       std::span<const Contact> contacts);

}  // namespace lumesh::detail
