#pragma once
/// @file Labels whose cells stay as they are while a command changes the rest.

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "lumesh/adapt/keep.hpp"
#include "lumesh/metric/shaping.hpp"

namespace lumesh::cli {

/// --keep.
CLI::Option* add_keep_option(CLI::App& command, std::vector<std::string>& labels);

/// The mesh in its two parts; none where no label is to be kept. Where its file lists no faces, it gets them.
/// @throws Error{kBadInput} that names the file.
[[nodiscard]] std::optional<KeptCells> kept_cells(const std::vector<std::string>& labels, MixedMesh& mesh,
                                                  const std::string& path);

/// One of the two: the mesh, or its part that is free to change.
[[nodiscard]] const MixedMesh& changing_part(const MixedMesh& mesh, const std::optional<KeptCells>& kept);

}  // namespace lumesh::cli
