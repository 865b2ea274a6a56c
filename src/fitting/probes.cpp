#include "lumesh/fitting/probes.hpp"

#include <algorithm>
#include <optional>

#include "lumesh/core/grid.hpp"
#include "lumesh/field/boundary_bricks.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::fitting {

namespace {

// Half diagonals of a voxel, 0.9 voxels for cubic ones: places between voxels are no farther from a boundary
// that keeps these apart.
constexpr double kAside = 1.04;

/// The centres of the faces between a voxel and the next ones along the axes.
void append_face_centres(const LabelImage& image, const Index3& voxel, std::vector<Probe>& out) {
  const ImageFrame& frame = image.frame();
  const Material own = image.at(voxel);
  for (int axis = 0; axis < 3; ++axis) {
    Index3 next = voxel;
    ++next[axis];
    if (!frame.contains(next) || image.at(next) == own) continue;
    Vec3 centre = voxel.cast<double>();
    centre[axis] += 0.5;
    out.push_back({frame.to_physical(centre), ascending(own, image.at(next))});
  }
}

/// From a voxel to the next one along each axis.
std::array<std::ptrdiff_t, 3> strides(const ImageFrame& frame) {
  const std::ptrdiff_t y = frame.size.x();
  return {1, y, y * frame.size.y()};
}

/// Whether eight voxels within the image have one label; the first is given.
bool all_alike(const LabelImage& image, const Index3& first) {
  const auto [x, y, z] = strides(image.frame());
  const LabelImage::Index* const v = &image.voxels()[image.frame().offset(first)];
  return v[0] == v[x] && v[0] == v[y] && v[0] == v[x + y] && v[0] == v[z] && v[0] == v[x + z] &&
         v[0] == v[y + z] && v[0] == v[x + y + z];
}

/// The corner between eight voxels, the first of which is given, once for each pair of materials that share a
/// face there. Voxels outside the image do not count.
void append_corner(const LabelImage& image, const Index3& first, std::vector<Probe>& out) {
  const ImageFrame& frame = image.frame();
  const bool inside = frame.contains(first) && frame.contains(first + Index3::Ones());
  if (inside && all_alike(image, first)) return;
  std::array<int, 8> around;
  for (int n = 0; n < 8; ++n) {
    const Index3 voxel = first + Index3(n & 1, n >> 1 & 1, n >> 2);
    around[static_cast<std::size_t>(n)] = frame.contains(voxel) ? static_cast<int>(image.at(voxel)) : -1;
  }
  const std::size_t before = out.size();
  for (std::size_t n = 0; n < 8; ++n) {
    for (std::size_t bit = 1; bit < 8; bit *= 2) {
      if ((n & bit) != 0 || around[n] < 0 || around[n | bit] < 0 || around[n] == around[n | bit]) continue;
      const Probe probe{frame.to_physical(first.cast<double>() + Vec3::Constant(0.5)),
                        ascending(static_cast<Material>(around[n]), static_cast<Material>(around[n | bit]))};
      const bool known = std::any_of(out.begin() + static_cast<std::ptrdiff_t>(before), out.end(),
                                     [&](const Probe& p) { return p.materials == probe.materials; });
      if (!known) out.push_back(probe);
    }
  }
}

/// The corners that a voxel begins; on the image's lower borders also those before it.
void append_corners(const LabelImage& image, const Index3& voxel, std::vector<Probe>& out) {
  const Index3 low = voxel - Index3((voxel.array() == 0).cast<int>());
  for_each_place(low, voxel, [&](const Index3& first) { append_corner(image, first, out); });
}

/// The boundary of two materials near a place between their voxels; none where that is not near, as at voxels
/// that noise explains better, or where a third material has taken its place.
std::optional<Vec3> boundary_beside(const LabelImage& image, const ImageDomain& domain,
                                    const std::array<Material, 2>& pair, const Vec3& near_mm) {
  constexpr double kNear = 0.1;  // Voxels.
  const double reach_mm = kAside * 0.5 * image.frame().spacing_mm.norm();
  const std::optional<Vec3> place = domain.project(near_mm, {pair[0], pair[1]}, reach_mm);
  if (!place || domain.beyond_cut(*place)) return std::nullopt;
  const bool is_theirs =
      domain.label_count() == 2 ||
      domain.materials_near(*place, kNear * domain.voxel_size_mm()).contains_all({pair[0], pair[1]});
  return is_theirs ? place : std::nullopt;
}

/// Puts probes from between the voxels onto the boundary that keeps these apart.
std::vector<Probe> on_boundary(const LabelImage& image, const ImageDomain& domain,
                               const std::vector<Probe>& between) {
  return parallel::collect<Probe>(between.size(), [&](std::size_t i, std::vector<Probe>& out) {
    const Probe& probe = between[i];
    if (const auto place = boundary_beside(image, domain, probe.materials, probe.position_mm))
      out.push_back({*place, probe.materials});
  });
}

}  // namespace

std::vector<Probe> boundary_probes(const LabelImage& image, const ImageDomain& domain) {
  const auto probes =
      parallel::collect<Probe>(brick_count(image), 64, [&](std::size_t b, std::vector<Probe>& out) {
        for_each_voxel_near_boundary(image, domain.field(), b, [&](const Index3& voxel) {
          append_face_centres(image, voxel, out);
          append_corners(image, voxel, out);
        });
      });
  return on_boundary(image, domain, probes);
}

std::vector<Probe> probes_near(const LabelImage& image, const ImageDomain& domain, const Vec3& centre_mm,
                               double radius_mm) {
  const ImageFrame& frame = image.frame();
  const Vec3 centre = frame.to_index(centre_mm);
  const Vec3 reach = radius_mm * frame.spacing_mm.cwiseInverse() + Vec3::Ones();
  const Index3 low = Eigen::Array3d((centre - reach).array().floor()).cast<int>().matrix().cwiseMax(0);
  const Index3 high = Eigen::Array3d((centre + reach).array().ceil())
                          .cast<int>()
                          .matrix()
                          .cwiseMin(frame.size - Index3::Ones());
  std::vector<Probe> probes;
  for_each_place(low, high, [&](const Index3& voxel) {
    append_face_centres(image, voxel, probes);
    append_corners(image, voxel, probes);
  });
  probes = on_boundary(image, domain, probes);
  std::erase_if(probes, [&](const Probe& p) { return (p.position_mm - centre_mm).norm() > radius_mm; });
  return probes;
}

}  // namespace lumesh::fitting
