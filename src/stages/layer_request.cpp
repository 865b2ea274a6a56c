#include <fmt/core.h>

#include <array>
#include <optional>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/parse_number.hpp"
#include "lumesh/io/file_formats.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/stages/layers_stage.hpp"

namespace lumesh {
namespace {

/// Takes "wall=2", "wall" or "2" into the options; an empty text says nothing.
void take_layer_label(const std::string& text, LayerOptions& options) {
  const auto throw_bad_label = [&](const std::string& why) {
    throw Error(ErrorKind::kUsage, fmt::format("\"{}\": {}", text, why));
  };
  const std::size_t equals = text.find('=');
  const bool has_both = equals != std::string::npos;
  const std::string number = has_both ? text.substr(equals + 1) : text;
  const std::optional<Label> label = parse_number<Label>(number);
  if (label && *label <= 0) throw_bad_label("labels are above 0");
  const bool looks_like_number =
      !number.empty() && number.find_first_not_of("+-.0123456789") == std::string::npos;
  if (equals == 0) throw_bad_label("the name is missing; write NAME=NUMBER");
  if (!label && (has_both || looks_like_number))
    throw_bad_label(fmt::format("\"{}\" is no whole number; write NAME=NUMBER", number));
  options.label = label.value_or(0);
  options.label_name = label && !has_both ? "" : text.substr(0, equals);
}

std::string layer_label_text(const LayerOptions& options) {
  const std::string number = options.label == 0 ? "" : std::to_string(options.label);
  return options.label_name + (options.label_name.empty() || number.empty() ? "" : "=") + number;
}

}  // namespace

void LayerRequest::describe(OptionList& list) {
  options.describe(list);
  list.text("into", into,
            "Inwards, in a mesh of several labels: the one that is deformed, by name or number; none: all "
            "at the patches, as one");
  list.parsed("label",
              {[this] { return layer_label_text(options); },
               [this](const std::string& text) { take_layer_label(text, options); }},
              "Label of the layers: NAME=NUMBER, NAME or NUMBER; none: vessel_wall (inwards layer), the next "
              "free number. That of the mesh beside them makes one region of both");
}

void LayerRequest::validate() const {
  options.validate();
  if (!into.empty() && options.side == LayerSide::kOutward)
    throw Error(ErrorKind::kUsage, fmt::format("{} says which label is deformed; it needs {} inward",
                                               option_name("into"), option_name("side")));
}

void LayersAndExtension::describe(OptionList& list) {
  layers.describe(list);
  extension.describe_lengths(list);
}

void LayersAndExtension::validate() const {
  if (layers.is_wanted()) layers.validate();
  if (!layers.is_wanted() && !extension.is_wanted())
    throw Error(ErrorKind::kUsage, fmt::format("give {} for layers, or {} for flow extensions",
                                               option_name("first_height"), option_name("extend")));
  extension.validate();
}

void LayersAndExtension::require_held_by(const std::string& path) const {
  if (layers.options.cells == LayerCells::kPrisms && !is_for(path, FileUse::kWriteMixed))
    throw Error(ErrorKind::kUsage,
                fmt::format("{}: holds tetrahedra only; choose {}, or set {} tetrahedra", path,
                            formats_for(FileUse::kWriteMixed), option_name("cells")));
}

LayerOptions LayerRequest::resolved(const std::set<Label>& present,
                                    const std::map<Label, std::string>& names) const {
  LayerOptions result = options;
  if (into.empty()) return result;
  naming(option_name("into"), [&] {
    const std::set<Label> called = labels_called(std::array{into}, present, names);
    if (called.size() > 1)
      throw Error(ErrorKind::kBadInput, fmt::format("several labels are called {}; give a number", into));
    result.into = *called.begin();
  });
  return result;
}

}  // namespace lumesh
