#include "lumesh/stages/phantom_stage.hpp"

#include <fmt/core.h>

#include <filesystem>

#include "lumesh/core/error.hpp"
#include "lumesh/core/version.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/io/polylines_file.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/stages/input_parts.hpp"

namespace lumesh {
namespace {

void require_lines(const std::string& path, const Polylines& lines, PhantomKind kind) {
  if (!path.empty() && lines.lines.empty())
    throw Error(ErrorKind::kUsage,
                fmt::format("a {} has no such lines; leave out {}", phantom_kind_name(kind), path));
}

void write_lines(const std::string& path, const Polylines& lines, PhantomKind kind) {
  if (path.empty()) return;
  MeshInfo info;
  info.provenance = {{"program", std::string("lumesh ") + kVersion},
                     {"command", "phantom"},
                     {"kind", std::string(phantom_kind_name(kind))}};
  write_polylines(path, lines, info);
}

}  // namespace

std::string PhantomRequest::parameters_path() const {
  if (!parameters.empty()) return parameters;
  std::filesystem::path beside = image;
  if (beside.extension() == ".gz") beside.replace_extension();
  return beside.replace_extension(".phantom.json").string();
}

PhantomMade make_phantom(const PhantomRequest& request, Context& context) {
  const PhantomKind kind = request.spec.kind;
  PhantomMade made{Phantom(request.spec), {}, {}, {}, {}};
  made.centerline = centerline_of(made.phantom);
  made.velocity = velocity_of(made.phantom);
  require_lines(request.centerline, made.centerline, kind);
  require_lines(request.velocity, made.velocity, kind);
  const LabelImage image = context.phase("voxels", [&] { return made.phantom.rasterise(); });
  made.labels = label_topology(image);
  context.phase("volumes", [&] {
    for (const LabelTopology& label : made.labels)
      made.volumes_mm3.push_back(made.phantom.volume_mm3(label.label));
  });
  context.phase("write", [&] {  // Takes long: a stop is too late only once the image is complete.
    write_image(request.image, image, [&] { context.results_exist(); });
  });
  write_text_file(request.parameters_path(), to_json_text(made.phantom.spec()));
  write_lines(request.centerline, made.centerline, kind);
  write_lines(request.velocity, made.velocity, kind);
  return made;
}

}  // namespace lumesh
