// Changes of voxels that users ask for, each of which is said.
#include <fmt/core.h>

#include "lumesh/image/touching.hpp"
#include "lumesh/stages/input.hpp"

namespace lumesh {
namespace {

void say(const VoxelsChanged& changed, const char* what, const LabelImage& image, const Context& context) {
  if (changed.voxels == 0) return;
  const Vec3 place = image.frame().to_physical(changed.first.cast<double>());
  context.warn(fmt::format(
      "{} voxels, {:.4g} mm³, {} ({} {}, such as ({}, {}, {}) at {:.4g}, {:.4g}, {:.4g} mm)", changed.voxels,
      changed.volume_mm3, what, changed.places, changed.places == 1 ? "place" : "places", changed.first.x(),
      changed.first.y(), changed.first.z(), place.x(), place.y(), place.z()));
}

}  // namespace

void edit_image(const ImageSelection& selection, Context& context, LabelImage& image) {
  if (selection.largest_component) keep_largest_component(image, ComponentScope::kUnion);
  if (selection.drop_below > 0)
    say(drop_small_components(image, selection.drop_below), "of small pieces became background", image,
        context);
  if (selection.fill_cavities)
    say(fill_cavities(image), "that were enclosed got the label around them", image, context);
  if (selection.touching == TouchChoice::kKeep) return;
  const VoxelsChanged changed =
      context.phase("touching", [&] { return change_touching(selection.touching, image); });
  say(changed,
      selection.touching == TouchChoice::kSeparate ? "between vessels that touch became background"
                                                   : "between vessels got the label around them",
      image, context);
}

}  // namespace lumesh
