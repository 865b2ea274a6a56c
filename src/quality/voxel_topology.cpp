#include "lumesh/image/topology.hpp"
#include "validity.hpp"

namespace lumesh::quality {

namespace {

VoxelTopology to_voxel_topology(const LabelTopology& of_image) {
  return {of_image.label,           of_image.voxel_count,  of_image.volume_mm3,
          of_image.component_count, of_image.euler_number, of_image.cavity_count};
}

}  // namespace

std::vector<VoxelTopology> voxel_topology(const LabelImage& image) {
  std::vector<VoxelTopology> result;
  for (const LabelTopology& label : label_topology(image)) result.push_back(to_voxel_topology(label));
  return result;
}

VoxelTopology union_voxel_topology(const LabelImage& image) {
  return to_voxel_topology(union_topology(image));
}

}  // namespace lumesh::quality
