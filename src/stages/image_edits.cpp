// Changes of voxels that users ask for, each of which is said.
#include <fmt/core.h>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/image/touching.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/input_parts.hpp"

namespace lumesh {
namespace {

void say(const VoxelsChanged& changed, const char* what, const LabelImage& image, const Context& context) {
  if (changed.voxels == 0) return;
  const Vec3 place = image.frame().to_physical(changed.first.cast<double>());
  context.warn(fmt::format("{} voxels, {:.4g} mm³, {} ({}, such as ({}, {}, {}) at {} mm)", changed.voxels,
                           changed.volume_mm3, what, counted(changed.places, "place"), changed.first.x(),
                           changed.first.y(), changed.first.z(), coordinates_text(place, 4)));
}

/// How many pieces there are, joined through faces, unless one became two or all became one.
void say_pieces(bool separates, std::size_t before, std::size_t now, bool has_changed,
                const Context& context) {
  if (!has_changed)
    context.warn(fmt::format("no vessels that touch{} were found; the object stays in {}",
                             separates ? "" : " or are near", counted(before, "piece")));
  else if (separates && now <= before)
    context.warn(fmt::format(
        "vessels that were separated are still joined elsewhere: the object is in {} now, {} before",
        counted(now, "piece"), before));
  else if (now != (separates ? before + 1 : 1))
    context.warn(fmt::format("the object is in {} now, {} before", counted(now, "piece"), before));
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
  const std::size_t before = voxel_components(image, ComponentScope::kUnion).size();
  const bool separates = selection.touching == TouchChoice::kSeparate;
  const VoxelsChanged changed =
      context.phase("touching", [&] { return separates ? separate_touching(image) : join_touching(image); });
  say(changed,
      separates ? "between vessels that touch became background"
                : "between vessels got the label around them",
      image, context);
  say_pieces(separates, before, voxel_components(image, ComponentScope::kUnion).size(), changed.voxels > 0,
             context);
}

}  // namespace lumesh
