#pragma once
/// @file Cards with the tables of an evaluation; empty where it has nothing to tell.

#include <string>

#include "lumesh/quality/evaluation.hpp"

namespace lumesh::report {

/// Volume, components and topology of each label, beside the image's.
[[nodiscard]] std::string labels_section(const quality::Evaluation& e);
/// Distances between the mesh and the image.
[[nodiscard]] std::string distances_section(const quality::Evaluation& e);
/// Voxels that lie in cells of their own label.
[[nodiscard]] std::string kept_section(const quality::Evaluation& e);
/// Openings in mesh and image.
[[nodiscard]] std::string openings_section(const quality::Evaluation& e);
/// Where the branches are narrowest, those that lose most first.
[[nodiscard]] std::string narrowest_section(const quality::Evaluation& e);
/// Against the exact shape of a phantom.
[[nodiscard]] std::string reference_section(const quality::Evaluation& e);
/// Patches, and whether the surface is closed.
[[nodiscard]] std::string boundary_section(const quality::Evaluation& e);
/// What makes the mesh invalid.
[[nodiscard]] std::string problems_section(const quality::Evaluation& e);

}  // namespace lumesh::report
