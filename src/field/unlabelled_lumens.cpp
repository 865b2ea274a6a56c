#include "unlabelled_lumens.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lumesh/core/squares.hpp"

namespace lumesh::field {

namespace {

constexpr std::size_t kMinLumen = 24;  // voxels; fewer are a speck

/// The box of the voxels of a border layer that have a face in it; beyond there is no change of label, so
/// that holes of the layer do not reach its edge, and all other background does.
VoxelBox box_of_changes(const PairFaces& outer_wall, int axis, int place) {
  VoxelBox box = VoxelBox::nothing();
  for (const Face& face : outer_wall.faces)
    if (face.axis != axis && face.voxel[axis] == place)
      box.add(face.voxel, face.voxel + Index3::Unit(face.axis) + Index3::Ones());
  return box;
}

/// Appends the voxels of background of a border layer from which no way in it leads to the box's edge.
void add_holes(const LabelImage& image, int axis, const VoxelBox& box, std::vector<Index3>& holes) {
  if (box.is_empty()) return;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const Index3 size = box.high - box.low;
  const auto columns = static_cast<std::size_t>(size[u]), count = columns * static_cast<std::size_t>(size[v]);
  const auto voxel = [&](std::size_t square) {
    Index3 at = box.low;
    at[u] += static_cast<int>(square % columns);
    at[v] += static_cast<int>(square / columns);
    return at;
  };
  const std::vector<std::uint32_t> part =
      connected_squares(columns, count, [&](std::size_t square) { return image.at(voxel(square)) == 0; });
  std::vector<std::uint8_t> reaches_edge(count + 1, 0);
  reaches_edge[0] = 1;  // The object.
  for (std::size_t square = 0; square < count; ++square) {
    const Index3 at = voxel(square);
    const bool is_at_edge =
        at[u] == box.low[u] || at[v] == box.low[v] || at[u] + 1 == box.high[u] || at[v] + 1 == box.high[v];
    if (is_at_edge) reaches_edge[part[square]] = 1;
  }
  for (std::size_t square = 0; square < count; ++square)
    if (reaches_edge[part[square]] == 0) holes.push_back(voxel(square));
}

/// Whether a voxel is in the image's first or last layer along an axis.
bool is_at_border(const ImageFrame& frame, const Index3& voxel) {
  return (voxel.array() == 0).any() || (voxel.array() == frame.size.array() - 1).any();
}

/// The search for background that leaves the image through holes alone.
class LumenSearch {
 public:
  LumenSearch(const LabelImage& image, const std::vector<Index3>& holes)
      : image_(image), is_hole_(image.voxels().size(), 0), reached_(is_hole_.size(), Reached::kNo) {
    for (const Index3& hole : holes) is_hole_[image.frame().offset(hole)] = 1;
  }

  /// Voxels that hang together with a hole by faces and have not been reached; none if one of them leaves the
  /// image elsewhere, which the search ends at.
  std::vector<Index3> behind(const Index3& hole) {
    std::vector<Index3> found;
    bool is_open = reach(hole, found);
    for (std::size_t i = 0; i < found.size() && !is_open; ++i) {
      const Index3 voxel = found[i];
      for (int axis = 0; axis < 3; ++axis)
        for (const int step : {-1, 1}) is_open = reach(voxel + step * Index3::Unit(axis), found) || is_open;
    }
    if (!is_open) return found;
    for (const Index3& voxel : found) reached_[image_.frame().offset(voxel)] = Reached::kOpen;
    return {};
  }

 private:
  enum class Reached : std::uint8_t { kNo, kYes, kOpen };

  /// @return Whether the voxel is, or hangs together with, one that leaves the image elsewhere.
  bool reach(const Index3& voxel, std::vector<Index3>& found) {
    const ImageFrame& frame = image_.frame();
    if (!frame.contains(voxel) || image_.at(voxel) != 0) return false;
    Reached& at = reached_[frame.offset(voxel)];
    if (at == Reached::kNo) {
      at = Reached::kYes;
      found.push_back(voxel);
    }
    return at == Reached::kOpen || (is_at_border(frame, voxel) && is_hole_[frame.offset(voxel)] == 0);
  }

  const LabelImage& image_;
  std::vector<std::uint8_t> is_hole_;
  std::vector<Reached> reached_;
};

/// Voxels of the background that leaves the image through these holes alone.
std::vector<Index3> voxels_of_lumens(const LabelImage& image, const std::vector<Index3>& holes) {
  LumenSearch search(image, holes);
  std::vector<Index3> voxels;
  for (const Index3& hole : holes) {
    const std::vector<Index3> lumen = search.behind(hole);
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
    for (const int place : {0, frame.size[axis] - 1})
      add_holes(image, axis, box_of_changes(outer_wall, axis, place), holes);
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
