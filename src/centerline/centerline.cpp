#include "lumesh/centerline/centerline.hpp"

#include "inputs.hpp"
#include "lines.hpp"
#include "lumesh/core/error.hpp"
#include "voxel_tree.hpp"

namespace lumesh {

using centerline::Lumen;
using centerline::Tube;

namespace {

Polylines to_polylines(const Lumen& lumen, const std::vector<Tube>& tubes) {
  const ImageFrame& frame = lumen.frame();
  Polylines lines;
  std::vector<double>& radii = lines.scalars["radius"];
  std::vector<double>& branches = lines.scalars["branch"];
  for (std::size_t t = 0; t < tubes.size(); ++t) {
    std::vector<std::uint32_t>& line = lines.lines.emplace_back();
    for (std::size_t i = 0; i < tubes[t].size(); ++i) {
      line.push_back(static_cast<std::uint32_t>(lines.points.size()));
      lines.points.push_back(frame.origin_mm + frame.direction * tubes[t].centres[i]);
      radii.push_back(tubes[t].radii[i]);
      branches.push_back(static_cast<double>(t));
    }
    if (tubes[t].closed) line.push_back(line.front());
  }
  return lines;
}

Polylines lines_of(const Lumen& lumen, const CenterlineOptions& options, Context& context) {
  const std::vector<centerline::VoxelPath> paths =
      context.phase("paths", [&] { return centerline::find_paths(lumen, options.shortest_tip); });
  if (paths.empty())
    throw Error(ErrorKind::kBadInput,
                "the object is not longer than wide, so that it has no vessel's centerline");
  return context.phase(
      "fit", [&] { return to_polylines(lumen, centerline::tubes_along(lumen, paths, options.spacing_mm)); });
}

}  // namespace

Polylines extract_centerline(const LabelImage& image, const CenterlineOptions& options, Context& context) {
  return extract_centerline(image, {}, options, context);
}

Polylines extract_centerline(const LabelImage& image, std::span<const CutPlane> cuts,
                             const CenterlineOptions& options, Context& context) {
  options.validate();
  const Lumen lumen =
      context.phase("lumen", [&] { return centerline::lumen_of_image(image, cuts, context); });
  return lines_of(lumen, options, context);
}

Polylines extract_centerline(const MeshView& mesh, const CenterlineOptions& options, Context& context) {
  options.validate();
  const Lumen lumen =
      context.phase("lumen", [&] { return centerline::lumen_of_mesh(mesh, options, context); });
  return lines_of(lumen, options, context);
}

}  // namespace lumesh
