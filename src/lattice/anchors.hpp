#pragma once
// Tips, edges and clefts of the labels that the surface passes by, and the vertices sent there.

#include <array>
#include <cstdint>
#include <numeric>
#include <vector>

#include "boundary_model.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// A point of the image's voxel boundary.
struct Probe {
  Vec3 position_mm;
  std::array<Material, 2> materials;  ///< On its two sides, ascending.
};

/// Corners and centres of voxel faces between labels (or a label and the background) where one of the two
/// voxels has at most 13 of the 27 voxels around of its own label: wherever the boundary is not flat. They
/// see whether the mesh reaches everywhere.
[[nodiscard]] std::vector<Probe> boundary_probes(const LabelImage& image, const ImageDomain& domain);

[[nodiscard]] TriangleTree boundary_tree(const WorkMesh& mesh, const BoundaryModel& boundary);

/// Places on the boundary that certain vertices shall reach.
class Anchors {
 public:
  Anchors(const ImageDomain& domain, const std::vector<Probe>& probes)
      : domain_(domain), probes_(probes), watched_(probes.size()) {
    std::iota(watched_.begin(), watched_.end(), 0U);
  }

  /// Sends the nearest free vertex to each probe further than 0.9 voxels from the surface, the furthest
  /// probes first, and at most one within 1.5 voxels. Vertices keep an anchor until they get another one.
  /// @return The vertices with a new anchor.
  std::vector<std::uint32_t> update(const WorkMesh& mesh, const BoundaryModel& boundary);

  [[nodiscard]] bool holds(std::uint32_t v) const { return v < is_set_.size() && is_set_[v] != 0; }
  [[nodiscard]] const Vec3& place_mm(std::uint32_t v) const { return place_[v]; }

  /// A probe further than 0.9 voxels from the surface, and the triangle nearest to it.
  struct Miss {
    double distance_mm;
    std::uint32_t probe;
    std::uint32_t triangle;
  };
  /// The furthest first; the tree is that of the boundary's triangles.
  [[nodiscard]] std::vector<Miss> misses(const TriangleTree& surface);

 private:
  const ImageDomain& domain_;
  const std::vector<Probe>& probes_;
  std::vector<std::uint32_t> watched_;  // probes worth a look: those not close to the surface the last time
  std::vector<std::uint8_t> is_set_;
  std::vector<Vec3> place_;
};

}  // namespace lumesh
