#pragma once
/// @file What a mesh says of its making, and of the image that it was made from against what it is compared
/// with.

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/stages/input.hpp"

namespace lumesh {

/// How a front end makes a mesh.
struct Making {
  std::string command;
  std::string options;  ///< Options given that change the mesh, as the front end spells them.
};

/// What a mesh says of that: program, command, options, input and its hash, cuts.
/// @param before  What the input says, where that is a mesh: what it was made from stays the input, so that
/// the result can be compared with its image.
[[nodiscard]] std::map<std::string, std::string> provenance_of(
    const Making& making, const std::string& input_path,
    const std::map<std::string, std::string>& before = {});

/// Doubts that a mesh was made of an image: none, or one line that ends with the consequence.
[[nodiscard]] std::vector<std::string> doubts_about_image(const std::string& image_path,
                                                          const std::string& mesh_path, const MeshInfo& info,
                                                          std::string_view consequence);

/// Notes the cuts of an image that a mesh is made from, if there are any, as words of the command line.
void put_cuts(const InputCuts& cuts, std::map<std::string, std::string>& provenance);

/// Whether a mesh was made of an image that was extended at openings.
[[nodiscard]] bool was_extended(const MeshInfo& info);

/// A line if fewer cuts are given than the mesh was made with, else nothing.
[[nodiscard]] std::vector<std::string> doubts_about_cuts(const InputCuts& given, const std::string& mesh_path,
                                                         const MeshInfo& info);

/// Notes cuts of a finished mesh beside those of its image, which it may be compared with later.
void note_cuts(std::span<const CutPlane> planes, std::map<std::string, std::string>& provenance);

}  // namespace lumesh
