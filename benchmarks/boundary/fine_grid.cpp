#include "fine_grid.hpp"

namespace lumesh::boundary {

FineGrid::FineGrid(const LabelImage& image, const ImageDomain& domain, int refinement)
    : voxels_(image.frame()),
      frame_(image.frame()),
      refinement_(refinement),
      cells_(voxels_.voxel_count(), kMixed) {
  frame_.size = ((voxels_.size - Index3::Ones()) * refinement + Index3::Ones()).eval();
  frame_.spacing_mm = voxels_.spacing_mm / refinement;
  const auto voxel_of = [&](std::size_t at) {
    const auto x = static_cast<std::size_t>(voxels_.size.x()), y = static_cast<std::size_t>(voxels_.size.y());
    return Index3(static_cast<int>(at % x), static_cast<int>(at / x % y), static_cast<int>(at / x / y));
  };
  std::vector<Material> centres(voxels_.voxel_count());
  parallel::for_each_index(centres.size(), [&](std::size_t at) {
    centres[at] = domain.material_at(voxels_.to_physical(voxel_of(at).cast<double>()));
  });
  for (std::size_t at = 0; at < centres.size(); ++at)
    wrong_voxels_ += centres[at] != image.voxels()[at] ? 1 : 0;
  const auto material_around = [&](const Index3& cell) {
    const Material first = image.at(cell);
    for (int k = -1; k <= 2; ++k)
      for (int j = -1; j <= 2; ++j)
        for (int i = -1; i <= 2; ++i) {
          const Index3 v = (cell + Index3(i, j, k)).cwiseMax(0).cwiseMin(voxels_.size - Index3::Ones());
          if (image.at(v) != first || centres[voxels_.offset(v)] != first) return kMixed;
        }
    return first;
  };
  parallel::for_each_index(cells_.size(),
                           [&](std::size_t at) { cells_[at] = material_around(voxel_of(at)); });
}

LabelImage sampled_labels(const LabelImage& image, const ImageDomain& domain, const FineGrid& grid) {
  LabelImage samples(grid.frame(), image.values());
  grid.for_each(
      [&](const Index3& sample, const Vec3& point) {
        const Material material = domain.material_at(point);
        samples.at(sample) = static_cast<LabelImage::Index>(material < domain.label_count() ? material : 0);
      },
      [&](const Index3& sample, Material material) {
        samples.at(sample) = static_cast<LabelImage::Index>(material);
      });
  return samples;
}

}  // namespace lumesh::boundary
