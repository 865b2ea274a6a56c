#pragma once
/// @file The boundary of an ImageDomain against the surface that its labels were made from.

#include <cstdint>
#include <vector>

#include "lumesh/domain/image_domain.hpp"
#include "lumesh/image/topology.hpp"
#include "shapes.hpp"

namespace lumesh::boundary {

/// Where the boundary runs beside a place of the exact surface.
struct WallSample {
  Vec3 point_mm = Vec3::Zero();  ///< On the exact surface.
  Vec3 normal = Vec3::Zero();    ///< Its unit normal, inwards.
  double offset_mm = 0;          ///< Of the boundary along the normal, > 0 outwards.
  double angle_deg = 0;          ///< Between the boundary's normal and the exact one.
  bool found = false;            ///< False if no boundary is within 1.6 voxels.
  bool near_border = false;      ///< Within 4 voxels of the image's border.
};

struct FieldFigures {
  std::size_t points = 0;
  double lost_percent = 0;  ///< Of places where no boundary was found.
  double mean_mm = 0;       ///< Mean offset.
  double roughness_mm = 0;  ///< R.m.s. of the offset less its mean.
  double aligned_mm = 0;    ///< The same with shift and tilt of the axis taken out; NaN but for tubes.
  double furthest_mm = 0;
  double normal_deg = 0;      ///< R.m.s.
  double radius_percent = 0;  ///< Error by the sections' area; NaN but for tubes.
  double radius_variation_percent =
      0;                            ///< R.m.s. along the axis, of pieces 4 voxels long; NaN but for tubes.
  double volume_percent = 0;        ///< Against the exact volume.
  double voxel_volume_percent = 0;  ///< Of the voxels, for comparison.
  double border_roughness_mm = 0;   ///< Near the border, about the mean elsewhere; NaN if nothing is there.
  double border_normal_deg = 0;
  std::size_t wrong_voxels = 0;   ///< Whose centre has not its label.
  LabelTopology voxels, samples;  ///< Of the voxels, and of the domain sampled three times as finely.
  double seconds = 0;             ///< For the domain.

  [[nodiscard]] bool same_topology() const {
    return voxels.component_count == samples.component_count && voxels.euler_number == samples.euler_number;
  }
};

[[nodiscard]] FieldFigures measure_field(const Shape& shape, const LabelImage& image, std::uint64_t seed);

/// Deviations of samples from a surface, as above; used of meshes as well.
struct Deviation {
  double mean_mm = 0, roughness_mm = 0, aligned_mm = 0, furthest_mm = 0, normal_deg = 0;
  double radius_percent = 0, radius_variation_percent = 0;
};
[[nodiscard]] Deviation deviation_of(const Shape& shape, const std::vector<WallSample>& samples);

}  // namespace lumesh::boundary
