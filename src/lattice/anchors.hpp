#pragma once
// Vertices sent to places of the boundary that the surface passes by.

#include <cstdint>
#include <vector>

#include "misses.hpp"

namespace lumesh {

/// Places on the boundary that certain vertices shall reach.
class Anchors {
 public:
  explicit Anchors(const ImageDomain& domain) : domain_(domain) {}

  /// Sends the nearest free vertex to each missed probe, but to one of those within 1.5 voxels of each other
  /// only. Vertices keep an anchor until they get another one.
  /// @return The vertices with a new anchor.
  std::vector<std::uint32_t> set(const WorkMesh& mesh, const BoundaryModel& boundary,
                                 const std::vector<Miss>& misses);

  [[nodiscard]] bool holds(std::uint32_t v) const { return v < is_set_.size() && is_set_[v] != 0; }
  [[nodiscard]] const Vec3& place_mm(std::uint32_t v) const { return place_[v]; }

 private:
  const ImageDomain& domain_;
  std::vector<std::uint8_t> is_set_;
  std::vector<Vec3> place_;
};

}  // namespace lumesh
