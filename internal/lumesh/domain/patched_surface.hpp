#pragma once
/// @file A closed surface in patches, without the distances that a SurfaceDomain measures.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lumesh/domain/surface_domain.hpp"

namespace lumesh {

namespace surfaces {
struct NamedRegions;
}

/// The patches and flat ends that the SurfaceDomain of the same surface has, in a tenth of its time.
class PatchedSurface {
 public:
  /// @throws Error{kBadInput}, Error{kUsage} as SurfaceDomain.
  explicit PatchedSurface(const SurfaceView& surface, const SurfaceDomainOptions& options = {});

  [[nodiscard]] std::span<const FlatEnd> flat_ends() const;
  /// Patches that sharp edges and the patches of the file divide the surface into, the largest first.
  [[nodiscard]] std::span<const Patch> patches() const;
  /// Lines on patches of the file that are hardly what they were meant for.
  [[nodiscard]] std::span<const std::string> patch_notes() const;
  [[nodiscard]] double resolution_mm() const;  ///< As of the domain.
  /// The surface, turned outwards, each triangle with the patch of its part; patches of one name are one.
  [[nodiscard]] MixedMesh mesh() const;

 private:
  std::shared_ptr<const surfaces::NamedRegions> regions_;
};

/// Triangles of each end of a closed surface that sharp edges divide into pieces, as they do fans of needles
/// over a ragged rim, though all corners are in one plane within 5 % of the radius. None on the stairs of
/// voxels, and none where equal points are several. @throws Error{kBadInput} as SurfaceDomain, but for
/// crossings.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> triangles_of_divided_ends(
    const SurfaceView& view, const SurfaceDomainOptions& options);

}  // namespace lumesh
