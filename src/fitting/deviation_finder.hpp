#pragma once
// Finds where the surface and the domain's boundary are too far apart.

#include <cstdint>
#include <limits>
#include <vector>

#include "boundary_tree.hpp"
#include "deviation.hpp"
#include "lumesh/fitting/boundary_model.hpp"

namespace lumesh::fitting {

/// Finds deviations again and again while the surface moves; remembers a triangle close to each probe and
/// looks again only where triangles have moved.
class DeviationFinder {
 public:
  /// All that is given must stay.
  DeviationFinder(const ImageDomain& domain, const std::vector<Probe>& probes)
      : domain_(&domain), probes_(&probes), close_(probes.size(), BoundaryTree::kNone) {}

  /// Probes further than `limit_mm` from the surface and triangles further than that from their boundary, but
  /// for what flat triangles of their size cut off, the furthest first. Between calls, of the same limit,
  /// triangles may change, new ones may follow and the last ones may go.
  /// @param max_probes  Where more probes deviate, outlier triangles are not looked for.
  [[nodiscard]] std::vector<Deviation> find(const WorkMesh& mesh, const BoundaryModel& boundary,
                                            double limit_mm,
                                            std::size_t max_probes = std::numeric_limits<std::size_t>::max());
  /// Deviations of probes alone; the limit may be another one.
  [[nodiscard]] std::vector<Deviation> find_probe_deviations(const WorkMesh& mesh,
                                                             const BoundaryModel& boundary, double limit_mm);
  /// Distances from the surface of the probes that deviated in the last call, however large.
  [[nodiscard]] std::vector<double> deviating_probe_distances_mm(const WorkMesh& mesh,
                                                                 const BoundaryModel& boundary) const;

 private:
  void note_moved_triangles(const WorkMesh& mesh, const BoundaryModel& boundary);
  [[nodiscard]] std::vector<Deviation> probe_deviations(const WorkMesh& mesh, const BoundaryModel& boundary,
                                                        double limit_mm);
  [[nodiscard]] bool deviates(const WorkMesh& mesh, const BoundaryModel& boundary, const BoundaryTree& tree,
                              const Probe& probe, const BoundaryTree::Nearest& nearest) const;
  [[nodiscard]] double longest_edge_at_mm(const WorkMesh& mesh, const BoundaryModel& boundary,
                                          const BoundaryTree& tree, const Vec3& point,
                                          const BoundaryTree::Nearest& nearest) const;
  [[nodiscard]] BoundaryTree tree_near(const WorkMesh& mesh, const BoundaryModel& boundary,
                                       const std::vector<std::uint32_t>& probes) const;
  void update_outliers(const WorkMesh& mesh, const BoundaryModel& boundary, double limit_mm);
  void append_outliers(const WorkMesh& mesh, const BoundaryModel& boundary, std::uint32_t triangle,
                       double limit_mm, std::vector<Deviation>& out) const;

  const ImageDomain* domain_;
  const std::vector<Probe>* probes_;
  std::vector<std::uint32_t> close_;  // per probe: a triangle within the limit, or none
  std::vector<Deviation> outliers_;   // by triangle
  std::vector<std::uint8_t> moved_;   // flag per triangle: not the same as in the last call
  // The surface of the last call.
  std::vector<BoundaryTriangle> triangles_;
  std::vector<Vec3> positions_;
};

}  // namespace lumesh::fitting
