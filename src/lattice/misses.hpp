#pragma once
// Where the surface and the domain's boundary are too far apart.

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "boundary_model.hpp"
#include "lumesh/image/label_image.hpp"
#include "surface_tree.hpp"

namespace lumesh {

/// A place of the domain's boundary.
struct Probe {
  Vec3 position_mm;
  std::array<Material, 2> materials;  ///< On its two sides, ascending.
};

[[nodiscard]] inline std::array<Material, 2> ascending(Material a, Material b) {
  return {std::min(a, b), std::max(a, b)};
}

/// The places of the boundary next to the corners and centres of voxel faces between labels, or a label and
/// the background, on the kept side of cut planes; where no boundary is within 0.9 voxels, none is kept.
[[nodiscard]] std::vector<Probe> boundary_probes(const LabelImage& image, const ImageDomain& domain);

/// Those within a radius of a place.
[[nodiscard]] std::vector<Probe> probes_near(const LabelImage& image, const ImageDomain& domain,
                                             const Vec3& centre_mm, double radius_mm);

/// A place of the image's boundary and the triangle that should come closer to it.
struct Miss {
  double distance_mm;
  Probe probe;
  std::uint32_t triangle;
  Vec3 place_mm;  ///< Of the probe; for strays, of the triangle's point that is furthest off.
  double off_mm;  ///< How far apart the two are; for strays, the triangle and the nearest boundary.
  bool stray;  ///< The triangle is far from its boundary; the probe is what it faces or, if it faces nothing
               ///< within three voxels, what is nearest.
  bool drawable;  ///< Whether a vertex may be sent to the probe: not where a stray faces nothing.
};

/// Finds misses again and again while the surface moves; remembers a triangle close to each probe and looks
/// again only where triangles have moved.
class MissFinder {
 public:
  /// All that is given must stay.
  MissFinder(const ImageDomain& domain, const std::vector<Probe>& probes)
      : domain_(&domain), probes_(&probes), close_(probes.size(), SurfaceTree::kNone) {}

  /// Probes further than `limit_mm` from the surface and triangles further than that from their boundary, but
  /// for what flat triangles of their size cut off, the furthest first. Between calls, of the same limit,
  /// triangles may change, new ones may follow and the last ones may go.
  /// @param most_probes  Where more are missed, these are all that is looked for.
  [[nodiscard]] std::vector<Miss> find(const WorkMesh& mesh, const BoundaryModel& boundary, double limit_mm,
                                       std::size_t most_probes = std::numeric_limits<std::size_t>::max());
  /// Only the probes; the limit may be another one.
  [[nodiscard]] std::vector<Miss> find_missed_probes(const WorkMesh& mesh, const BoundaryModel& boundary,
                                                     double limit_mm);
  /// For the probes that the last call missed: how far from the surface they are, however far that is.
  [[nodiscard]] std::vector<double> missed_distances_mm(const WorkMesh& mesh,
                                                        const BoundaryModel& boundary) const;

 private:
  void note_moved_triangles(const WorkMesh& mesh, const BoundaryModel& boundary);
  [[nodiscard]] std::vector<Miss> missed_probes(const WorkMesh& mesh, const BoundaryModel& boundary,
                                                double limit_mm);
  [[nodiscard]] bool is_missed(const WorkMesh& mesh, const BoundaryModel& boundary, const SurfaceTree& tree,
                               const Probe& probe, const SurfaceTree::Nearest& nearest) const;
  [[nodiscard]] double longest_edge_at_mm(const WorkMesh& mesh, const BoundaryModel& boundary,
                                          const SurfaceTree& tree, const Vec3& point,
                                          const SurfaceTree::Nearest& nearest) const;
  [[nodiscard]] SurfaceTree tree_near(const WorkMesh& mesh, const BoundaryModel& boundary,
                                      const std::vector<std::uint32_t>& probes) const;
  void update_strays(const WorkMesh& mesh, const BoundaryModel& boundary, double limit_mm);
  void append_strays(const WorkMesh& mesh, const BoundaryModel& boundary, std::uint32_t triangle,
                     double limit_mm, std::vector<Miss>& out) const;

  const ImageDomain* domain_;
  const std::vector<Probe>* probes_;
  std::vector<std::uint32_t> close_;  // per probe: a triangle within the limit, or none
  std::vector<Miss> strays_;          // by triangle
  std::vector<std::uint8_t> moved_;   // flag per triangle: not the same as in the last call
  // Of the last call.
  std::vector<BoundaryTriangle> triangles_;
  std::vector<Vec3> positions_;
};

}  // namespace lumesh
