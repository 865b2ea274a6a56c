#include "domain_input.hpp"

#include <fmt/core.h>

#include "lumesh/core/error.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh::cli {

void add_domain_options(CLI::App& command, DomainInput& input) {
  command
      .add_option(
          "image", input.path,
          std::string("Label image ") + kImageFormats + ", or closed surface (.stl, .vtp, .mesh, .msh)")
      ->required();
  add_selection_options(command, input.selection, "Mesh");
  add_cut_plane_option(command, input.cut_planes, "cut off what lies on the normal's side");
  input.smoothing =
      command.add_option("--smoothing", input.image.field.sigma,
                         "Low-pass width in voxels, 0.5 to 3; default 1.25, or as much less, down to 0.7, as "
                         "thin parts need to keep the volume");
  command
      .add_option("--feature-angle", input.surface.feature_angle_deg,
                  "Of a surface: edges are kept where it turns by more than this, in degrees, up to 180")
      ->capture_default_str();
}

void check_domain_options(const CLI::App& command, const DomainInput& input) {
  static_cast<void>(planes_from(input.cut_planes));
  input.surface.validate();
  const bool is_surface = is_mesh_file(input.path);
  const auto refuse = [&](const char* option) {
    if (command.get_option(option)->count() > 0)
      throw Error(ErrorKind::kUsage, fmt::format("{} is for {}, and {} is {}; leave it out", option,
                                                 is_surface ? "images" : "surfaces", input.path,
                                                 is_surface ? "a surface" : "an image"));
  };
  if (!is_surface) return refuse("--feature-angle");
  for (const char* option : {"--labels", "--threshold", "--largest-component", "--cut-plane", "--smoothing"})
    refuse(option);
}

DomainRead read_domain(const DomainInput& input, Context& context) {
  if (is_mesh_file(input.path)) {
    const MixedMesh surface = context.phase("read", [&] { return read_surface(input.path); });
    return naming(input.path, [&] {
      return DomainRead{context.phase("domain", [&] { return domain_of(surface, input.surface); }), {}, 0};
    });
  }
  const LabelImage image =
      context.phase("read", [&] { return read_selected_image(input.path, input.selection, context); });
  ImageDomainOptions options = input.image;
  options.cut_planes = planes_from(input.cut_planes);
  ImageShape shape = context.phase("shape", [&] { return shape_of(image); });
  DomainRead read{nullptr, std::move(shape), options.field.sigma};
  read.domain = context.phase("domain", [&]() -> std::unique_ptr<Domain> {
    if (input.smoothing->count() > 0) return std::make_unique<ImageDomain>(image, options);
    return volume_keeping_domain(image, options, read.smoothing_voxels);
  });
  return read;
}

}  // namespace lumesh::cli
