#include "lumesh/image/topology.hpp"
#include "validity.hpp"

namespace lumesh::quality {

std::vector<VoxelTopology> voxel_topology(const LabelImage& image) {
  std::vector<VoxelTopology> result;
  for (const auto& label : lumesh::label_topology(image))
    result.push_back(
        {label.label, label.voxel_count, label.volume_mm3, label.component_count, label.euler_number});
  return result;
}

VoxelTopology union_voxel_topology(const LabelImage& image) {
  const auto all = lumesh::union_topology(image);
  return {all.label, all.voxel_count, all.volume_mm3, all.component_count, all.euler_number};
}

}  // namespace lumesh::quality
