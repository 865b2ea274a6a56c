#pragma once
/// @file A domain sampled more finely than its image.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "lumesh/domain/image_domain.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::boundary {

/// Samples between the centres of the first and the last voxels, `refinement` to a voxel's edge.
class FineGrid {
 public:
  FineGrid(const LabelImage& image, const ImageDomain& domain, int refinement);

  /// Frame of the samples.
  [[nodiscard]] const ImageFrame& frame() const { return frame_; }
  /// Voxels whose centre has another material than their label.
  [[nodiscard]] std::size_t wrong_voxels() const { return wrong_voxels_; }

  /// Calls near(sample, point_mm) for samples near a boundary and far(sample, material) for the others, where
  /// the voxels around and the domain at their centres have one material. In parallel.
  template <class Near, class Far>
  void for_each(const Near& near, const Far& far) const {
    const auto rows = static_cast<std::size_t>(frame_.size.y()) * static_cast<std::size_t>(frame_.size.z());
    parallel::for_each_index(rows, 1, [&](std::size_t row) {
      const int j = static_cast<int>(row % static_cast<std::size_t>(frame_.size.y()));
      const int k = static_cast<int>(row / static_cast<std::size_t>(frame_.size.y()));
      for (int i = 0; i < frame_.size.x(); ++i) {
        const Index3 sample(i, j, k);
        const Material material = material_of_cell(sample);
        if (material == kMixed)
          near(sample, Vec3(frame_.to_physical(sample.cast<double>())));
        else
          far(sample, material);
      }
    });
  }

 private:
  static constexpr Material kMixed = 0xFFFFFFFFu;

  [[nodiscard]] Material material_of_cell(const Index3& sample) const {
    const Index3 cell = (sample / refinement_).cwiseMin((voxels_.size - Index3::Constant(2)).cwiseMax(0));
    return cells_[voxels_.offset(cell)];
  }

  ImageFrame voxels_, frame_;
  int refinement_;
  std::vector<Material> cells_;  // By the voxel with the lowest index at a corner.
  std::size_t wrong_voxels_ = 0;
};

/// The labels of a domain at the samples, in the compact indices of the image.
[[nodiscard]] LabelImage sampled_labels(const LabelImage& image, const ImageDomain& domain,
                                        const FineGrid& grid);

}  // namespace lumesh::boundary
