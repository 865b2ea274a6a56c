#include <fmt/core.h>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/layers/layers.hpp"

namespace lumesh {
namespace {

void describe_heights(OptionList& list, LayerOptions& o) {
  list.number("first_height", o.first_height, above(0), "Height of the layer next to the surface, across it")
      .in("mm, or what relative_to says")
      .zero("no layers")
      .alias("blds");
  list.choice(
      "relative_to", o.scale,
      {{"mm", HeightScale::kAbsolute}, {"radius", HeightScale::kRadius}, {"edge", HeightScale::kEdge}},
      "What heights are multiples of: mm, the local radius (half the way to the opposite side), or the mean "
      "edge length around");
  list.number("growth", o.growth, above(0),
              "Height of each layer through that before; below 1 only with a count")
      .alias("blr");
  list.number("growth_rise", o.growth_rise, at_least(1),
              "Factor of the growth itself per layer, after those of constant growth")
      .alias("bldr");
  list.number("constant_layers", o.constant_layers, between(1, 200),
              "Layers of constant growth, before the growth itself rises")
      .alias("bli");
  list.number("most_growth", o.max_growth, above(0), "Bound of the growth that rises").alias("blrm");
  list.number("count", o.count, between(1, 200),
              "Number of layers; without it and a thickness they grow until they are as high as the edges "
              "around are long")
      .zero("as the thickness or the sizes ask for")
      .alias("nbl");
  list.number("thickness", o.thickness, above(0),
              "Thickness of all layers, met exactly: the growth is adapted to it")
      .in("mm, or what relative_to says")
      .zero("as the count makes it");
  list.choice("short_of_room", o.short_of_room,
              {{"drop", ShortOfRoom::kDrop}, {"shrink", ShortOfRoom::kShrink}},
              "Where columns do not fit: drop: outer layers go and the first height is kept; shrink: all "
              "layers become thinner alike");
}

}  // namespace

void LayerOptions::describe(OptionList& list) {
  list.texts("patches", patches, "Patches to grow on; none: all walls").alias("patch");
  list.choice(
      "side", side, {{"outward", LayerSide::kOutward}, {"inward", LayerSide::kInward}},
      "outward: around the mesh, which stays as it is; inward: within it, where its interior is deformed");
  describe_heights(list, *this);
  list.choice("cells", cells, {{"prisms", LayerCells::kPrisms}, {"tetrahedra", LayerCells::kTetrahedra}},
              "Prisms, or three tetrahedra for each");
  list.flag("split_openings", splits_openings,
            "The ring of layers around an opening becomes a patch of its own, OPENING_layer");
  list.number("mbl", aflr.mbl, between(1, 1), "As in AFLR, always so: there are boundary layers");
  list.number("fints", aflr.fints, between(0, 0), "As in AFLR, always so: the surface stays as it is");
  list.flag("open", aflr.open,
            "As in AFLR, always so: layers alone, and no cells beyond them in the open space");
}

void LayerOptions::validate() const {
  require_ranges_of(*this);
  const auto require = [](bool good, const std::string& message) {
    if (!good) throw Error(ErrorKind::kBadInput, message);
  };
  require(first_height > 0,
          option_name("first_height") + " is missing: the height of the layer next to the surface");
  require(growth >= 1 || count > 0, "a growth below 1 needs the number of layers, " + option_name("count"));
  require(!counts_by_sizes() || growth > 1 || (growth_rise > 1 && max_growth > 1),
          "layers that do not grow never become as high as edges are long; give " + option_name("count") +
              " or " + option_name("thickness"));
  require(!counts_by_sizes() || short_of_room == ShortOfRoom::kDrop,
          option_name("short_of_room") + " shrink needs the number of layers or their thickness, " +
              option_name("count") + " or " + option_name("thickness"));
  require(thickness == 0 || thickness >= first_height,
          fmt::format("the thickness {:g} of all layers is less than the first height {:g}", thickness,
                      first_height));
}

}  // namespace lumesh
