#pragma once
/// @file Segmentations of 3D Slicer whose segments overlap: the file has several layers, each a volume.

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "raw_image.hpp"

namespace lumesh::io {

/// A segment of a .seg.nrrd file: the voxels with this value in this volume.
struct Segment {
  std::string name;
  Label value = kBackground;
  std::size_t layer = 0;
};

/// Whether the volumes of a file are layers of segments, no frames.
[[nodiscard]] bool have_layers(const std::vector<Segment>& segments);

/// Names of the values. @param layer  Of this volume alone, where there are layers.
[[nodiscard]] std::map<Label, std::string> names_of(const std::vector<Segment>& segments,
                                                    std::optional<std::size_t> layer);

/// Makes one volume of all layers, in which each segment has a label of its own: its value, or a free number
/// where a layer before has that value. Voxels of several segments have the label of the last layer's. Warns
/// of what became what. @throws Error{kBadInput} for values that are no labels.
void join_layers(const std::filesystem::path& path, const std::vector<Segment>& segments,
                 const Context& context, RawImage& image);

}  // namespace lumesh::io
