#pragma once
/// @file What is meshed: the labels of an image, or the inside of a closed surface.

#include <CLI/CLI.hpp>
#include <span>
#include <string>
#include <vector>

#include "common.hpp"
#include "lumesh/stages/domain_read.hpp"
#include "lumesh/stages/opening_request.hpp"

namespace lumesh::cli {

/// The positional argument, and the options of images and of surfaces.
void add_domain_options(CLI::App& command, DomainInput& input);

/// @throws Error{kUsage} for options that do not suit the input, before it is read.
void check_domain_options(const CLI::App& command, DomainInput& input);

/// --name and --strict.
void add_opening_options(CLI::App& command, OpeningRequest& request);
/// OpeningRequest::renamings(), whose errors name that option.
[[nodiscard]] std::vector<PatchRenaming> renamings_for(const OpeningRequest& request,
                                                       std::span<const Opening> openings);

/// A line for each patch, with its area and the image's where it is an opening.
[[nodiscard]] std::string patch_lines(const MeshInfo& info, std::span<const std::int32_t> patches,
                                      const OpeningsCompared& openings);
/// A line on the time that each step took, but for single passes.
[[nodiscard]] std::string time_line(const Context& context, double seconds);

/// Writes a mesh in a unit, and its boundary where that is wanted.
void write_with_surface(const MeshView& mesh, const std::string& unit, const std::string& mesh_path,
                        const std::string& surface_path, Context& context);

}  // namespace lumesh::cli
