#pragma once
// Where the surface and the boundary of the voxels are too far apart.

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "boundary_model.hpp"
#include "lumesh/image/label_image.hpp"
#include "surface_tree.hpp"

namespace lumesh {

/// A point of the image's voxel boundary.
struct Probe {
  Vec3 position_mm;
  std::array<Material, 2> materials;  ///< On its two sides, ascending.
};

[[nodiscard]] inline std::array<Material, 2> ascending(Material a, Material b) {
  return {std::min(a, b), std::max(a, b)};
}

/// Corners and centres of the voxel faces between labels, or a label and the background, on the kept side of
/// cut planes.
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
  double off_mm;  ///< How far apart the two are; for strays, the triangle and the nearest boundary; for a
                  ///< vertex, the limit, what it is beyond its own, and a tenth of a voxel.
  bool stray;     ///< The triangle is far from all of the image's boundary; the probe is what it faces or, if
                  ///< it faces nothing within three voxels, what is nearest.
  bool drawable;  ///< Whether a vertex may be sent to the probe: not where a stray faces nothing.
  std::optional<std::uint32_t> vertex = {};  ///< A stray that is one vertex of the triangle; the probe is
                                             ///< where it would be near enough.
};

/// Finds misses again and again while the surface moves; remembers a triangle close to each probe and looks
/// again only where triangles have moved.
class MissFinder {
 public:
  /// All that is given must stay.
  MissFinder(const LabelImage& image, const ImageDomain& domain, const std::vector<Probe>& probes)
      : image_(&image), domain_(&domain), probes_(&probes), close_(probes.size(), SurfaceTree::kNone) {}

  /// Probes further than `limit_mm` from the surface, but for corners of stairs over coarse triangles,
  /// triangles further than that from the voxels' boundary, and vertices further than 1.154 half diagonals of
  /// a voxel (one voxel for cubic ones) from the centres of their labels' boundary voxels, the furthest
  /// first. Between calls, of the same limit, triangles may change, new ones may follow and the last ones may
  /// go.
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
  void measure_moved_vertices(const WorkMesh& mesh, const BoundaryModel& boundary);
  [[nodiscard]] std::vector<Miss> missed_probes(const WorkMesh& mesh, const BoundaryModel& boundary,
                                                double limit_mm);
  [[nodiscard]] bool is_missed(const WorkMesh& mesh, const BoundaryModel& boundary, const SurfaceTree& tree,
                               const Probe& probe) const;
  [[nodiscard]] double longest_edge_at_mm(const WorkMesh& mesh, const BoundaryModel& boundary,
                                          const SurfaceTree& tree, const Vec3& point) const;
  [[nodiscard]] SurfaceTree tree_near(const WorkMesh& mesh, const BoundaryModel& boundary,
                                      const std::vector<std::uint32_t>& probes) const;
  void update_strays(const WorkMesh& mesh, const BoundaryModel& boundary, double limit_mm);
  void append_strays(const WorkMesh& mesh, const BoundaryModel& boundary, std::uint32_t triangle,
                     double limit_mm, std::vector<Miss>& out) const;
  /// A place of a triangle and the nearest one on the voxel faces.
  struct Furthest {
    double off_mm;
    Vec3 at, back;
  };
  void look_for_furthest(const std::array<Vec3, 3>& p, const std::array<Material, 2>& pair,
                         const std::optional<Vec3>& face_mm, Furthest& furthest) const;
  void append_far_vertices(const WorkMesh& mesh, const BoundaryModel& boundary, double limit_mm,
                           std::vector<Miss>& out) const;

  const LabelImage* image_;
  const ImageDomain* domain_;
  const std::vector<Probe>* probes_;
  std::vector<std::uint32_t> close_;  // per probe: a triangle within the limit, or none
  std::vector<Miss> strays_;          // by triangle
  std::vector<std::uint8_t> moved_;   // flag per triangle: not the same as in the last call
  std::vector<double> beyond_mm_;     // per vertex: how much too far it is from its labels' voxels
  // Of the last call.
  std::vector<BoundaryTriangle> triangles_;
  std::vector<Vec3> positions_;
  std::vector<MaterialSet> sets_;
};

}  // namespace lumesh
