#include "lumesh/image/topology.hpp"

#include <algorithm>

#include "cavities.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/image/runs.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh {

namespace {

using image::for_each_run;
using image::Run;
using image::RunImage;

std::vector<Run> overlaps(std::span<const Run> a, std::span<const Run> b) {
  std::vector<Run> shared;
  image::for_each_overlap(a, b, [&](std::size_t, std::size_t, const Run& run) { shared.push_back(run); });
  return shared;
}

/// Euler number of every label. Along i, n voxels in a row have n vertices and n - 1 edges, so every maximal
/// run counts one, every run of squares between two rows minus one, and every run of cubes between four rows
/// one.
std::vector<std::int64_t> euler_numbers(const RunImage& runs, std::size_t label_count) {
  using Counts = std::vector<std::int64_t>;
  const int slices_per_block = std::max(1, runs.size.z() / 32);
  const auto count_slices = [&](std::size_t begin, std::size_t end) {
    Counts euler(label_count, 0);
    for (int k = static_cast<int>(begin); k < static_cast<int>(end); ++k) {
      std::vector<Run> up;  // between slices k and k + 1, in row j and in the row before
      std::vector<Run> up_before;
      for (int j = 0; j < runs.size.y(); ++j) {
        const std::span<const Run> here = runs.of_row(runs.row(j, k));
        for (const Run& run : here) ++euler[run.label];
        if (j > 0)
          image::for_each_overlap(runs.of_row(runs.row(j - 1, k)), here,
                                  [&](std::size_t, std::size_t, const Run& run) { --euler[run.label]; });
        if (k + 1 >= runs.size.z()) continue;
        up = overlaps(here, runs.of_row(runs.row(j, k + 1)));
        for (const Run& run : up) --euler[run.label];
        image::for_each_overlap(std::span<const Run>(up_before), std::span<const Run>(up),
                                [&](std::size_t, std::size_t, const Run& run) { ++euler[run.label]; });
        std::swap(up, up_before);
      }
    }
    return euler;
  };
  return parallel::reduce_blocks(static_cast<std::size_t>(runs.size.z()),
                                 static_cast<std::size_t>(slices_per_block), Counts(label_count, 0),
                                 count_slices, parallel::AddEach());
}

std::vector<LabelTopology> describe(const RunImage& runs, std::size_t label_count, double voxel_volume_mm3) {
  std::vector<LabelTopology> result(label_count);
  for (LabelTopology& entry : result) entry.box = VoxelBox::nothing();
  DisjointSets sets = image::connected(runs);
  for_each_run(runs, [&](std::uint32_t r, int j, int k) {
    const Run& run = runs.runs[r];
    LabelTopology& entry = result[run.label];
    entry.voxel_count += static_cast<std::size_t>(run.end - run.begin);
    entry.component_count += sets.find(r) == r ? 1 : 0;
    entry.box.add({run.begin, j, k}, {run.end, j + 1, k + 1});
  });
  const std::vector<std::int64_t> euler = euler_numbers(runs, label_count);
  for (std::size_t i = 0; i < label_count; ++i) {
    result[i].euler_number = euler[i];
    result[i].volume_mm3 = static_cast<double>(result[i].voxel_count) * voxel_volume_mm3;
  }
  parallel::for_each_index(label_count, 1, [&](std::size_t i) {
    if (result[i].voxel_count > 0)
      result[i].cavity_count = image::count_cavities(runs, static_cast<LabelImage::Index>(i), result[i].box);
  });
  return result;
}

image::RunLabels run_labels(ComponentScope scope) {
  return scope == ComponentScope::kEachLabel ? image::RunLabels::kEach : image::RunLabels::kUnion;
}

struct Component {
  VoxelComponent shown;
  LabelImage::Index run_label = 0;
  std::uint32_t root = 0;
};

/// All components in the order of voxel_components().
std::vector<Component> list_components(const LabelImage& image, const RunImage& runs, DisjointSets& sets) {
  std::vector<Component> components;
  std::vector<std::uint32_t> of_root(runs.runs.size());
  for_each_run(runs, [&](std::uint32_t r, int j, int k) {
    const Run& run = runs.runs[r];
    const std::uint32_t root = sets.find(r);
    if (root == r) {  // roots come first in memory, so this is also the component's first voxel
      of_root[r] = static_cast<std::uint32_t>(components.size());
      const Index3 first(run.begin, j, k);
      components.push_back({{image.label_at(first), 0, VoxelBox::nothing(), first}, run.label, r});
    }
    VoxelComponent& shown = components[of_root[root]].shown;
    shown.voxel_count += static_cast<std::size_t>(run.end - run.begin);
    shown.box.add({run.begin, j, k}, {run.end, j + 1, k + 1});
  });
  std::ranges::stable_sort(components, [](const Component& a, const Component& b) {
    if (a.run_label != b.run_label) return a.run_label < b.run_label;
    return a.shown.voxel_count > b.shown.voxel_count;
  });
  return components;
}

/// Turns the runs that `is_kept(root)` refuses into background. @return Number of their voxels.
template <class IsKept>
std::size_t keep_runs(LabelImage& image, const RunImage& runs, DisjointSets& sets, const IsKept& is_kept) {
  std::size_t removed = 0;
  for_each_run(runs, [&](std::uint32_t r, int j, int k) {
    if (is_kept(sets.find(r))) return;
    const Run& run = runs.runs[r];
    auto* row = image.voxels().data() + image.frame().offset({0, j, k});
    std::fill(row + run.begin, row + run.end, LabelImage::Index{0});
    removed += static_cast<std::size_t>(run.end - run.begin);
  });
  return removed;
}

}  // namespace

std::vector<LabelTopology> label_topology(const LabelImage& image) {
  const RunImage runs = image::find_runs(image, image::RunLabels::kEach);
  std::vector<LabelTopology> all = describe(runs, image.values().size(), image.frame().voxel_volume_mm3());
  for (std::size_t i = 0; i < all.size(); ++i) all[i].label = image.values()[i];
  std::erase_if(all, [](const LabelTopology& entry) { return entry.voxel_count == 0; });
  return all;
}

LabelTopology union_topology(const LabelImage& image) {
  const RunImage runs = image::find_runs(image, image::RunLabels::kUnion);
  LabelTopology all = describe(runs, 2, image.frame().voxel_volume_mm3())[1];
  all.label = 1;
  if (all.voxel_count == 0) all.box = {};
  return all;
}

std::vector<VoxelComponent> voxel_components(const LabelImage& image, ComponentScope scope) {
  const RunImage runs = image::find_runs(image, run_labels(scope));
  DisjointSets sets = image::connected(runs);
  std::vector<VoxelComponent> result;
  for (const Component& component : list_components(image, runs, sets)) result.push_back(component.shown);
  return result;
}

std::vector<VoxelComponent> small_components(const LabelImage& image, std::size_t below,
                                             ComponentScope scope) {
  std::vector<VoxelComponent> all = voxel_components(image, scope);
  std::erase_if(all, [&](const VoxelComponent& component) { return component.voxel_count >= below; });
  return all;
}

std::size_t keep_largest_component(LabelImage& image, ComponentScope scope) {
  const RunImage runs = image::find_runs(image, run_labels(scope));
  DisjointSets sets = image::connected(runs);
  std::vector<char> kept(runs.runs.size(), 0);
  LabelImage::Index last = 0;
  for (const Component& component : list_components(image, runs, sets)) {
    if (component.run_label != last) kept[component.root] = 1;  // the first of its label is the largest
    last = component.run_label;
  }
  return keep_runs(image, runs, sets, [&](std::uint32_t root) { return kept[root] != 0; });
}

std::size_t keep_component_of(LabelImage& image, const Index3& voxel, ComponentScope scope) {
  const RunImage runs = image::find_runs(image, run_labels(scope));
  DisjointSets sets = image::connected(runs);
  const std::span<const Run> row = runs.of_row(runs.row(voxel.y(), voxel.z()));
  const auto own = std::ranges::find_if(row, [&](const Run& run) { return voxel.x() < run.end; });
  LUMESH_ASSERT(own != row.end() && own->begin <= voxel.x());
  const std::uint32_t root = sets.find(static_cast<std::uint32_t>(&*own - runs.runs.data()));
  return keep_runs(image, runs, sets, [&](std::uint32_t r) { return r == root; });
}

}  // namespace lumesh
