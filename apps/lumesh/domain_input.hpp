#pragma once
/// @file What is meshed: the labels of an image, or the inside of a closed surface.

#include <CLI/CLI.hpp>

#include "common.hpp"
#include "frames.hpp"
#include "lumesh/stages/domain_read.hpp"
#include "lumesh/stages/opening_request.hpp"

namespace lumesh::cli {

/// A command that makes a mesh of an image or surface.
template <class Request>
struct FirstMeshCommand {
  Request request;
  MeshOutput output;
  std::string json_path;
  RunOptions run;

  [[nodiscard]] FrameParts frames() {
    return {&request.input.selection, request.input.path, {&output.mesh, &output.surface, &json_path}};
  }
};

/// The positional argument, and the options of images and of surfaces.
void add_domain_options(CLI::App& command, DomainInput& input);

/// @throws Error{kUsage} for options that do not suit the input, before it is read.
void check_domain_options(const CLI::App& command, DomainInput& input);

/// --name and --strict.
void add_opening_options(CLI::App& command, OpeningRequest& request);

}  // namespace lumesh::cli
