#include "surface_estimate.hpp"

#include <span>

#include "lumesh/parallel/sum.hpp"

namespace lumesh::pipeline {
namespace {

/// Voxels of the object, and its faces across each axis.
struct FaceCounts {
  double voxels = 0;
  Vec3 faces = Vec3::Zero();

  friend FaceCounts operator+(const FaceCounts& a, const FaceCounts& b) {
    return {a.voxels + b.voxels, a.faces + b.faces};
  }
};

/// In one slice, and between it and the next.
FaceCounts counts_of_slice(const LabelImage& image, int k) {
  const Index3& size = image.frame().size;
  const auto row = static_cast<std::size_t>(size.x()), slice = row * static_cast<std::size_t>(size.y());
  const std::span<const LabelImage::Index> voxels = image.voxels();
  FaceCounts counts;
  for (int j = 0; j < size.y(); ++j)
    for (int i = 0; i < size.x(); ++i) {
      const std::size_t at = static_cast<std::size_t>(k) * slice + static_cast<std::size_t>(j) * row +
                             static_cast<std::size_t>(i);
      const bool is_object = voxels[at] != 0;
      counts.voxels += is_object ? 1 : 0;
      const auto differs = [&](bool is_inside, std::size_t step) {
        return is_inside && (voxels[at + step] != 0) != is_object ? 1.0 : 0.0;
      };
      counts.faces += Vec3(differs(i + 1 < size.x(), 1), differs(j + 1 < size.y(), row),
                           differs(k + 1 < size.z(), slice));
    }
  return counts;
}

}  // namespace

OutsideSize outside_of(const LabelImage& image) {
  const ImageFrame& frame = image.frame();
  const auto counts =
      parallel::sum<FaceCounts>(static_cast<std::size_t>(frame.size.z()), 1,
                                [&](std::size_t k) { return counts_of_slice(image, static_cast<int>(k)); });
  const Vec3& spacing = frame.spacing_mm;
  const Vec3 face_mm2(spacing.y() * spacing.z(), spacing.z() * spacing.x(), spacing.x() * spacing.y());
  return {counts.faces.dot(face_mm2) * 2 / 3, counts.voxels * frame.voxel_volume_mm3()};
}

}  // namespace lumesh::pipeline
