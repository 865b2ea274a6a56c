#include <cmath>

#include "lumesh/image/topology.hpp"
#include "lumesh/parallel/loops.hpp"
#include "on_planes.hpp"
#include "validity.hpp"

namespace lumesh::quality {

std::vector<VoxelTopology> voxel_topology(const LabelImage& image) {
  std::vector<VoxelTopology> result;
  for (const auto& label : lumesh::label_topology(image))
    result.push_back(
        {label.label, label.voxel_count, label.volume_mm3, label.component_count, label.euler_number});
  return result;
}

std::vector<double> kept_volumes_mm3(const LabelImage& image, std::span<const Plane> planes) {
  const ImageFrame& frame = image.frame();
  const CutPlanes cuts(planes, std::cbrt(frame.voxel_volume_mm3()));
  using Volumes = std::vector<double>;
  const auto slice_volumes = [&](int k) {
    Volumes volumes(image.values().size());
    for (int j = 0; j < frame.size.y(); ++j) {
      for (int i = 0; i < frame.size.x(); ++i) {
        const LabelImage::Index label = image.at({i, j, k});
        if (label != 0)
          volumes[label] +=
              frame.voxel_volume_mm3() * cuts.kept_share(frame, frame.to_physical(Vec3(i, j, k)));
      }
    }
    return volumes;
  };
  return parallel::reduce_blocks(
      static_cast<std::size_t>(frame.size.z()), 1, Volumes(image.values().size()),
      [&](std::size_t k, std::size_t) { return slice_volumes(static_cast<int>(k)); },
      [](Volumes a, const Volumes& b) {
        for (std::size_t l = 0; l < a.size(); ++l) a[l] += b[l];
        return a;
      });
}

VoxelTopology union_voxel_topology(const LabelImage& image) {
  const auto all = lumesh::union_topology(image);
  return {all.label, all.voxel_count, all.volume_mm3, all.component_count, all.euler_number};
}

}  // namespace lumesh::quality
