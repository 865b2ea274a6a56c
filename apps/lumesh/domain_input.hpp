#pragma once
/// @file What is meshed: the labels of an image, or the inside of a closed surface.

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "common.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/stages/image_shape.hpp"
#include "lumesh/stages/surface_input.hpp"

namespace lumesh::cli {

struct DomainInput {
  std::string path;
  ImageSelection selection;
  InputCuts cuts;
  LabelFieldOptions field;  ///< Of an image.
  SurfaceInputOptions surface;
  bool needs_axes = false;
};

/// The positional argument, and the options of images and of surfaces.
void add_domain_options(CLI::App& command, DomainInput& input);

/// @throws Error{kUsage} for options that do not suit the input, before it is read.
void check_domain_options(const CLI::App& command, DomainInput& input);

struct DomainRead {
  std::shared_ptr<const Domain> domain;
  std::vector<Opening> openings = {};            ///< Of the domain.
  std::optional<ImageShape> shape = {};          ///< Of an image.
  Polylines axes = {};                           ///< Where they are wanted.
  std::string closed_vessels = {};               ///< A line, if all its vessels end inside.
  std::vector<surfaces::ClosedRim> closed = {};  ///< What was closed of a surface.
};

/// Finds the openings of an image's domain, and warns of those that its voxels do not show.
[[nodiscard]] DomainRead with_openings(std::shared_ptr<const ImageDomain> domain, const LabelImage& image,
                                       const DomainInput& input, Context& context);

/// @throws Error{kBadInput} that names the file.
[[nodiscard]] DomainRead read_domain(const DomainInput& input, Context& context);

/// What commands that mesh a domain say of its openings.
struct OpeningOptions {
  std::vector<std::string> names;  ///< Texts for renaming_from().
  bool is_strict = false;
};
/// --name and --strict.
void add_opening_options(CLI::App& command, OpeningOptions& options);

/// The names as patches of a mesh of the domain are to get them; known before it is made.
/// @throws Error{kBadInput} as with_patches().
[[nodiscard]] std::vector<PatchRenaming> renamings_for(const OpeningOptions& options,
                                                       std::span<const Opening> openings);

/// The openings of a mesh against its domain's; warns of those that are wrong.
[[nodiscard]] OpeningsCompared checked_openings(const MeshView& mesh, const Domain& domain,
                                                std::span<const Opening> openings, Context& context);

/// @param without_name  Lines of rename_found().
/// @throws Error{kNotReached} if a patch that has a name by the user is missing, or if the user is strict and
/// an opening is missing or wrong.
void require_openings(const OpeningOptions& options, const std::string& path,
                      const OpeningsCompared& openings, const std::vector<std::string>& without_name);

/// A line for each patch, with its area and the image's where it is an opening.
[[nodiscard]] std::string patch_lines(const MeshInfo& info, std::span<const std::int32_t> patches,
                                      const OpeningsCompared& openings);
/// A line on the time that each step took, but for single passes.
[[nodiscard]] std::string time_line(const Context& context, double seconds);

/// Writes a mesh in a unit, and its boundary where that is wanted.
void write_with_surface(const MeshView& mesh, const std::string& unit, const std::string& mesh_path,
                        const std::string& surface_path, Context& context);

}  // namespace lumesh::cli
