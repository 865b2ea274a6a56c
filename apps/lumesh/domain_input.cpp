#include "domain_input.hpp"

#include <fmt/core.h>

#include "lumesh/io/mesh_file.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {

void add_domain_options(CLI::App& command, DomainInput& input) {
  command
      .add_option(
          "image", input.path,
          with_formats("Label image", FileUse::kReadImage) + with_formats(", or surface", FileUse::kRead))
      ->required();
  add_options_of(command, input.selection);
  add_unit_option(command, input.selection.unit);
  add_options_of(command, input.cuts);
  add_options_of(command, input.field);
  add_options_of(command, input.surface);
}

void check_domain_options(const CLI::App& command, DomainInput& input) {
  input.surface.validate();
  input.cuts.validate();
  input.is_surface = is_mesh_file(input.path);
  const std::string reason = input.is_surface ? fmt::format("is for images, and {} is a surface", input.path)
                                              : only_for_surfaces(input.path);
  if (!input.is_surface) return require_not_given(command, options_of(input.surface), reason);
  require_not_given(command, options_of(input.selection), reason);
  require_not_given(command, options_of(input.field), reason);
}

void add_opening_options(CLI::App& command, OpeningRequest& request) {
  add_name_option(command, request.names);
  command.add_flag("--strict", request.is_strict,
                   "Exit with 3, after the mesh was written, if there is no opening, or one is missing, in "
                   "parts or more than 5 % off in area");
}

}  // namespace lumesh::cli
