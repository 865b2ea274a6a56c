#include "unlabelled_lumens.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace lumesh::field {

namespace {

constexpr std::size_t kMinLumen = 24;  // voxels; fewer are a speck

enum class Reached : std::uint8_t { kNo, kYes, kOpen };

/// Voxels of background that hang together with the start by faces along the axes, and have not been reached;
/// none if one of them is open, which the search ends at.
template <class IsOpen>
std::vector<Index3> flooded(const LabelImage& image, const Index3& start, std::span<const int> axes,
                            std::vector<Reached>& reached, const IsOpen& is_open) {
  const ImageFrame& frame = image.frame();
  std::vector<Index3> found;
  bool any_open = false;
  const auto reach = [&](const Index3& voxel) {
    if (!frame.contains(voxel) || image.at(voxel) != 0) return;
    Reached& at = reached[frame.offset(voxel)];
    any_open = any_open || at == Reached::kOpen || is_open(voxel);
    if (at != Reached::kNo) return;
    at = Reached::kYes;
    found.push_back(voxel);
  };
  reach(start);
  for (std::size_t i = 0; i < found.size() && !any_open; ++i) {
    const Index3 voxel = found[i];
    for (const int axis : axes)
      for (const int step : {-1, 1}) reach(voxel + step * Index3::Unit(axis));
  }
  if (!any_open) return found;
  for (const Index3& voxel : found) reached[frame.offset(voxel)] = Reached::kOpen;
  return {};
}

/// One layer of an image.
LabelImage layer_of(const LabelImage& image, int axis, int place) {
  ImageFrame frame = image.frame();
  frame.size[axis] = 1;
  LabelImage layer(frame, image.values());
  for_each_place(Index3::Zero(), frame.size - Index3::Ones(), [&](const Index3& voxel) {
    layer.at(voxel) = image.at(voxel + place * Index3::Unit(axis));
  });
  return layer;
}

/// Appends the voxels of background of a border layer from which no way in it leads to the layer's edge.
void add_holes(const LabelImage& image, int axis, int place, std::vector<Index3>& holes) {
  const LabelImage layer = layer_of(image, axis, place);
  const std::array<int, 2> axes = {(axis + 1) % 3, (axis + 2) % 3};
  const Index3 last = layer.frame().size - Index3::Ones();
  std::vector<Reached> reached(layer.voxels().size(), Reached::kNo);
  for_each_place(Index3::Zero(), last, [&](const Index3& voxel) {
    const bool is_at_edge =
        std::ranges::any_of(axes, [&](int a) { return voxel[a] == 0 || voxel[a] == last[a]; });
    if (is_at_edge) (void)flooded(layer, voxel, axes, reached, [](const Index3& /*v*/) { return false; });
  });
  for_each_place(Index3::Zero(), last, [&](const Index3& voxel) {
    if (layer.at(voxel) == 0 && reached[layer.frame().offset(voxel)] == Reached::kNo)
      holes.push_back(voxel + place * Index3::Unit(axis));
  });
}

/// Whether a voxel is in the image's first or last layer along an axis.
bool is_at_border(const ImageFrame& frame, const Index3& voxel) {
  return (voxel.array() == 0).any() || (voxel.array() == frame.size.array() - 1).any();
}

/// Voxels of the background that hangs together with these holes and leaves the image through them alone.
std::vector<Index3> voxels_of_lumens(const LabelImage& image, const std::vector<Index3>& holes) {
  const ImageFrame& frame = image.frame();
  std::vector<std::uint8_t> is_hole(image.voxels().size(), 0);
  for (const Index3& hole : holes) is_hole[frame.offset(hole)] = 1;
  const auto is_open = [&](const Index3& voxel) {
    return is_at_border(frame, voxel) && is_hole[frame.offset(voxel)] == 0;
  };
  std::vector<Reached> reached(is_hole.size(), Reached::kNo);
  std::vector<Index3> voxels;
  for (const Index3& hole : holes) {
    const std::vector<Index3> lumen = flooded(image, hole, std::array<int, 3>{0, 1, 2}, reached, is_open);
    if (lumen.size() >= kMinLumen) voxels.insert(voxels.end(), lumen.begin(), lumen.end());
  }
  return voxels;
}

/// Appends a face, with what is known of where the boundary crosses it.
void add_face(const PairFaces& from, std::size_t number, PairFaces& to) {
  to.faces.push_back(from.faces[number]);
  if (!from.crossings.empty()) to.crossings.push_back(from.crossings[number]);
}

}  // namespace

std::optional<UnlabelledLumens> find_unlabelled_lumens(const LabelImage& image, const PairFaces& outer_wall) {
  const ImageFrame& frame = image.frame();
  std::vector<Index3> holes;
  for (int axis = 0; axis < 3; ++axis)
    for (const int place : {0, frame.size[axis] - 1}) add_holes(image, axis, place, holes);
  if (holes.empty()) return std::nullopt;
  const std::vector<Index3> lumens = voxels_of_lumens(image, holes);
  if (lumens.empty()) return std::nullopt;
  UnlabelledLumens result{LabelImage(frame, {0, 1}), image, {}, {}};
  for (const Index3& voxel : lumens) result.lumens.at(voxel) = result.filled.at(voxel) = 1;
  for (std::size_t f = 0; f < outer_wall.faces.size(); ++f) {
    const Face& face = outer_wall.faces[f];
    const bool is_of_lumen =
        result.lumens.at(face.voxel) != 0 || result.lumens.at(face.voxel + Index3::Unit(face.axis)) != 0;
    add_face(outer_wall, f, is_of_lumen ? result.faces_of_lumens : result.faces_of_filled);
  }
  if (result.faces_of_lumens.faces.empty() || result.faces_of_filled.faces.empty()) return std::nullopt;
  return result;
}

}  // namespace lumesh::field
