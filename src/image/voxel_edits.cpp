#include "voxel_edits.hpp"

#include <algorithm>
#include <map>

#include "cavities.hpp"
#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/image/runs.hpp"
#include "lumesh/image/selection.hpp"

namespace lumesh {

namespace {

/// Calls use(place) for the voxels around one that are in the image: the 26 next ones, or more.
template <class Use>
void for_each_beside(const ImageFrame& frame, const Index3& place, const Use& use, int reach = 1) {
  for_each_place(place - Index3::Constant(reach), place + Index3::Constant(reach), [&](const Index3& beside) {
    if (beside != place && frame.contains(beside)) use(beside);
  });
}

/// Background in a box, of which runs in sets that are joined through corners; set 0 reaches the box's
/// border.
struct Hollows {
  image::RunImage runs;
  DisjointSets sets;

  Hollows(const LabelImage& image, const VoxelBox& box);
  std::uint32_t set_of(std::size_t run) { return sets.find(static_cast<std::uint32_t>(run + 1)); }
};

image::RunImage background_runs(const LabelImage& image, const VoxelBox& box) {
  const Index3 size = box.high - box.low;
  return image::make_runs(size, [&](std::size_t row, std::vector<image::Run>& runs) {
    const LabelImage::Index* const voxels =
        &image.voxels()[image.frame().offset(box.low + grid_row(size, row))];
    for (int i = 0; i < size.x();) {
      const int begin = i;
      while (i < size.x() && voxels[i] == 0) ++i;
      if (i > begin) runs.push_back({begin, i, 0});
      while (i < size.x() && voxels[i] != 0) ++i;
    }
  });
}

Hollows::Hollows(const LabelImage& image, const VoxelBox& box)
    : runs(background_runs(image, box)), sets(runs.runs.size() + 1) {
  const auto number = [&](const image::Run& run) {
    return static_cast<std::uint32_t>(&run - runs.runs.data() + 1);
  };
  for (const image::Run& run : runs.runs)
    if (run.begin == 0 || run.end == runs.size.x()) sets.merge(image::kOutsideSet, number(run));
  image::join_background(
      runs.size.y(), runs.size.z(), [&](int j, int k) { return runs.of_row(runs.row(j, k)); }, number, sets);
}

/// Faces of each label to every other one, but for those in the image's border.
using FacesBetween = std::map<std::pair<LabelImage::Index, LabelImage::Index>, std::size_t>;

template <class Use>
void for_each_label_face(const LabelImage& image, const Use& use) {
  const ImageFrame& frame = image.frame();
  for_each_place(Index3::Zero(), frame.size - Index3::Ones(), [&](const Index3& voxel) {
    for (int axis = 0; axis < 3; ++axis) {
      const Index3 next = voxel + Index3::Unit(axis);
      if (!frame.contains(next) || image.at(voxel) == image.at(next)) continue;
      use(voxel, next);
      use(next, voxel);
    }
  });
}

}  // namespace

std::vector<std::vector<Index3>> image::enclosed_pieces(const LabelImage& image) {
  std::vector<std::vector<Index3>> pieces;
  VoxelBox box = object_box(image);
  if (box.is_empty()) return pieces;
  box.low = (box.low - Index3::Ones()).cwiseMax(Index3::Zero());
  box.high = (box.high + Index3::Ones()).cwiseMin(image.frame().size);
  Hollows hollows(image, box);
  const std::uint32_t outside = hollows.sets.find(image::kOutsideSet);
  std::map<std::uint32_t, std::size_t> piece_of;
  image::for_each_run(hollows.runs, [&](std::uint32_t r, int j, int k) {
    const std::uint32_t set = hollows.set_of(r);
    if (set == outside) return;
    const auto [at, is_new] = piece_of.emplace(set, pieces.size());
    if (is_new) pieces.emplace_back();
    for (int i = hollows.runs.runs[r].begin; i < hollows.runs.runs[r].end; ++i)
      pieces[at->second].emplace_back(box.low + Index3(i, j, k));
  });
  return pieces;
}

LabelImage::Index image::label_around(const LabelImage& image, const std::vector<LabelImage::Index>& voxels,
                                      const Index3& place) {
  std::map<LabelImage::Index, int> counts;
  for_each_beside(
      image.frame(), place,
      [&](const Index3& beside) {
        const LabelImage::Index label = voxels[image.frame().offset(beside)];
        if (label != 0) ++counts[label];
      },
      2);
  LabelImage::Index best = 0;
  for (const auto& [label, count] : counts)
    if (best == 0 || count > counts[best]) best = label;
  return best;
}

void image::note_change(const LabelImage& image, const Index3& place, VoxelsChanged& changed) {
  if (changed.voxels++ == 0 || image.frame().offset(place) < image.frame().offset(changed.first))
    changed.first = place;
  changed.volume_mm3 = static_cast<double>(changed.voxels) * image.frame().voxel_volume_mm3();
}

std::vector<Cavity> find_cavities(const LabelImage& image) {
  std::vector<Cavity> cavities;
  for (const std::vector<Index3>& piece : image::enclosed_pieces(image))
    cavities.push_back({piece.size(), piece.front()});
  return cavities;
}

VoxelsChanged fill_cavities(LabelImage& image) {
  VoxelsChanged changed;
  for (const std::vector<Index3>& piece : image::enclosed_pieces(image)) {
    std::map<LabelImage::Index, std::size_t> counts;
    for (const Index3& voxel : piece)
      for_each_beside(image.frame(), voxel, [&](const Index3& beside) {
        if (image.at(beside) != 0) ++counts[image.at(beside)];
      });
    const auto most =
        std::ranges::max_element(counts, [](const auto& a, const auto& b) { return a.second < b.second; });
    const LabelImage::Index label = most->first;
    ++changed.places;
    for (const Index3& voxel : piece) {
      image.at(voxel) = label;
      image::note_change(image, voxel, changed);
    }
  }
  return changed;
}

void image::drop_component(const Index3& first, LabelImage& image, VoxelsChanged& changed) {
  std::vector<Index3> piece = {first};
  image.at(first) = 0;
  for (std::size_t i = 0; i < piece.size(); ++i) {
    note_change(image, piece[i], changed);
    for (int axis = 0; axis < 3; ++axis)
      for (const int way : {-1, 1}) {
        const Index3 beside = piece[i] + way * Index3::Unit(axis);
        if (!image.frame().contains(beside) || image.at(beside) == 0) continue;
        image.at(beside) = 0;
        piece.push_back(beside);
      }
  }
}

VoxelsChanged drop_small_components(LabelImage& image, std::size_t below) {
  VoxelsChanged changed;
  for (const VoxelComponent& small : small_components(image, below, ComponentScope::kUnion)) {
    ++changed.places;
    image::drop_component(small.first, image, changed);
  }
  return changed;
}

std::vector<WallHole> find_wall_holes(const LabelImage& image) {
  constexpr double kEnclosedShare = 0.9;
  if (image.values().size() < 3) return {};  // One label has no wall.
  FacesBetween faces;
  for_each_label_face(image, [&](const Index3& voxel, const Index3& beside) {
    if (image.at(voxel) != 0) ++faces[{image.at(voxel), image.at(beside)}];
  });
  std::vector<WallHole> holes;
  for (const auto& [pair, count] : faces) {
    const auto [inside, wall] = pair;
    std::size_t all = 0;
    for (const auto& [other, n] : faces) all += other.first == inside ? n : 0;
    if (wall == 0 || !faces.contains({inside, 0}) ||
        static_cast<double>(count) < kEnclosedShare * static_cast<double>(all))
      continue;
    std::map<std::size_t, std::pair<Index3, std::size_t>>
        bare;  // Voxels of the inside beside the background.
    for_each_label_face(image, [&, in = inside](const Index3& voxel, const Index3& beside) {
      if (image.at(voxel) == in && image.at(beside) == 0)
        ++bare.emplace(image.frame().offset(voxel), std::pair(voxel, std::size_t{0})).first->second.second;
    });
    while (!bare.empty()) {
      WallHole hole{image.values()[inside], image.values()[wall], 0, bare.begin()->second.first};
      std::vector<Index3> next = {hole.voxel};
      hole.faces += bare.begin()->second.second;
      bare.erase(bare.begin());
      while (!next.empty()) {
        const Index3 place = next.back();
        next.pop_back();
        for_each_beside(image.frame(), place, [&](const Index3& beside) {
          const auto found = bare.find(image.frame().offset(beside));
          if (found == bare.end()) return;
          hole.faces += found->second.second;
          next.push_back(beside);
          bare.erase(found);
        });
      }
      holes.push_back(hole);
    }
  }
  std::ranges::stable_sort(holes, [](const WallHole& a, const WallHole& b) { return a.faces > b.faces; });
  return holes;
}

}  // namespace lumesh
