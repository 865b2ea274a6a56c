#include "segment_layers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <set>
#include <type_traits>
#include <utility>

#include "file_fault.hpp"
#include "lumesh/core/counted.hpp"
#include "lumesh/core/enumerated.hpp"

namespace lumesh::io {
namespace {

/// Layer and value.
using SegmentKey = std::pair<std::size_t, Label>;

template <class Voxel>
Label label_of(const std::filesystem::path& path, Voxel value) {
  if constexpr (std::is_integral_v<Voxel>)
    if (std::in_range<Label>(value) && value >= 0) return static_cast<Label>(value);
  fail(path,
       fmt::format("has the value {} in a layer of segments; labels are from 0 to 2^31 - 1: save it again",
                   value));
}

/// The segments that have voxels, whether the file names them or not.
template <class Voxel>
std::set<SegmentKey> keys_of(const std::filesystem::path& path, std::span<const Voxel> voxels,
                             std::size_t voxels_each) {
  std::set<SegmentKey> keys;
  for (std::size_t i = 0; i < voxels.size(); ++i)
    if (voxels[i] != 0 && (i == 0 || voxels[i] != voxels[i - 1] || i % voxels_each == 0))
      keys.emplace(i / voxels_each, label_of(path, voxels[i]));
  return keys;
}

std::map<SegmentKey, Label> labels_of_keys(const std::set<SegmentKey>& keys) {
  Label highest = 0;
  for (const SegmentKey& key : keys) highest = std::max(highest, key.second);
  std::map<SegmentKey, Label> labels;
  std::set<Label> taken;
  for (const SegmentKey& key : keys) {
    const bool is_free = taken.insert(key.second).second;
    labels[key] = is_free ? key.second : ++highest;
  }
  return labels;
}

/// Labels of the joined segments, and their losses.
struct JoinedSegments {
  std::map<SegmentKey, Label> labels;
  std::map<SegmentKey, std::size_t> hidden;  ///< Voxels that a later layer has, too.
};

template <class Voxel>
JoinedSegments join(const std::filesystem::path& path, std::span<const Voxel> voxels, std::size_t layers,
                    Label* joined) {
  const std::size_t each = voxels.size() / layers;
  JoinedSegments made{labels_of_keys(keys_of(path, voxels, each)), {}};
  for (std::size_t v = 0; v < each; ++v) {
    SegmentKey last = {0, kBackground};
    for (std::size_t layer = 0; layer < layers; ++layer) {
      const Voxel value = voxels[layer * each + v];
      if (value == 0) continue;
      if (last.second != kBackground) ++made.hidden[last];
      last = {layer, static_cast<Label>(value)};
    }
    joined[v] = last.second == kBackground ? kBackground : made.labels.at(last);
  }
  return made;
}

std::string text_of(const JoinedSegments& made, const std::map<SegmentKey, std::string>& names,
                    std::size_t layers) {
  std::vector<std::string> parts;
  for (const auto& [key, label] : made.labels) {
    const auto name = names.find(key);
    const auto hidden = made.hidden.find(key);
    parts.push_back(fmt::format(
        "{} of layer {} is label {}{}",
        name == names.end() ? fmt::format("value {}", key.second) : "\"" + name->second + "\"", key.first,
        label,
        hidden == made.hidden.end()
            ? ""
            : fmt::format(" without {} that a later layer has, too", counted(hidden->second, "voxel"))));
  }
  constexpr std::size_t kMostTold = 12;
  return fmt::format(
      "has {} layers of segments, which become one image of labels: {}; `frame` takes one layer", layers,
      enumerated(parts, kMostTold));
}

}  // namespace

bool have_layers(const std::vector<Segment>& segments) {
  return std::ranges::any_of(segments, [](const Segment& s) { return s.layer > 0; });
}

std::map<Label, std::string> names_of(const std::vector<Segment>& segments,
                                      std::optional<std::size_t> layer) {
  const bool is_one_layer = layer && have_layers(segments);
  std::map<Label, std::string> names;
  for (const Segment& segment : segments)
    if (!is_one_layer || segment.layer == *layer) names[segment.value] = segment.name;
  return names;
}

void join_layers(const std::filesystem::path& path, const std::vector<Segment>& segments,
                 const Context& context, RawImage& image) {
  const std::size_t layers = image.volumes, voxels = image.frame.voxel_count();
  auto joined = std::make_unique_for_overwrite<std::byte[]>(voxels * sizeof(Label));
  const JoinedSegments made = visit_voxels(
      image, [&](auto values) { return join(path, values, layers, reinterpret_cast<Label*>(joined.get())); });
  std::map<SegmentKey, std::string> names;
  for (const Segment& segment : segments) names[{segment.layer, segment.value}] = segment.name;
  image.label_names.clear();
  for (const auto& [key, label] : made.labels)
    if (const auto name = names.find(key); name != names.end()) image.label_names[label] = name->second;
  image.voxels = std::move(joined);
  image.type = VoxelType::kInt32;
  image.volumes = 1;
  context.warn(path.string() + ": " + text_of(made, names, layers));
}

}  // namespace lumesh::io
