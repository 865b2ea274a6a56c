#include "volumes.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/label_shapes.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh {
namespace {

using operators::PlaceOnPatch;

constexpr std::uint32_t kNoPatch = UINT32_MAX;

/// The vertices that may move, each inside one patch, and the patches' sizes.
struct MovableVertices {
  std::vector<std::uint32_t> patch;   // Of each vertex, or kNoPatch.
  std::vector<Vec3> normal;           // Of each vertex that has a patch.
  std::vector<double> area, largest;  // Of each patch, in mm^2, and how far it may move, in mm.
};

MovableVertices movable_vertices(const TetMesh& mesh, const PlaceOnPatch& place) {
  constexpr double kMax = 0.02;  // Of the edges: what is further off is no matter of facets.
  const BoundaryFaces faces = mesh.boundary_faces();
  const std::size_t patches = mesh.info().patches.size();
  MovableVertices found{std::vector<std::uint32_t>(mesh.vertex_count(), kNoPatch),
                        std::vector<Vec3>(mesh.vertex_count(), Vec3::Zero()), std::vector<double>(patches, 0),
                        std::vector<double>(patches, 0)};
  std::vector<double> counts(patches, 0);
  for (std::size_t i = 0; i < faces.triangles.size(); ++i) {
    const auto patch = static_cast<std::uint32_t>(faces.patches[i]);
    found.area[patch] += triangle_area(mesh.points(), faces.triangles[i]);
    counts[patch] += 1;
    for (const std::uint32_t v : faces.triangles[i])
      if (mesh.dimension(VertexId(v)) == VertexDimension::kSurface) found.patch[v] = patch;
  }
  for (std::size_t p = 0; p < patches; ++p)
    if (counts[p] > 0) found.largest[p] = kMax * std::sqrt(2 * found.area[p] / counts[p]);
  parallel::for_each_index(found.patch.size(), 64, [&](std::size_t v) {
    if (found.patch[v] == kNoPatch) return;
    if (const auto at = place(PatchId(found.patch[v]), mesh.points()[v]))
      found.normal[v] = at->normal;
    else
      found.patch[v] = kNoPatch;
  });
  return found;
}

/// By how much the volume of each label (rows, in the order of the map) grows for each mm that a patch
/// (columns) moves along its normals.
Eigen::MatrixXd growth_by_patch(const TetMesh& mesh, const std::map<Label, double>& labels,
                                const MovableVertices& movable) {
  constexpr std::size_t kBlock = 65536;
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(labels.size()),
                                                     static_cast<Eigen::Index>(movable.area.size()));
  return parallel::reduce(
      mesh.tet_count(), kBlock, none,
      [&](Eigen::MatrixXd& growth, std::size_t i) {
        const TetId t(static_cast<std::uint32_t>(i));
        for (int k = 0; k < 4; ++k) {
          const std::uint32_t v = mesh.vertex(t, k).value;
          if (movable.patch[v] == kNoPatch) continue;
          const Cell<3> across = mesh.face_corners(t, k);
          const Vec3 towards_v = -triangle_area_normal(mesh.points()[across[0]], mesh.points()[across[1]],
                                                       mesh.points()[across[2]]);
          const auto row = std::distance(labels.begin(), labels.find(mesh.label(t)));
          growth(row, movable.patch[v]) += towards_v.dot(movable.normal[v]) / 6;
        }
      },
      [](Eigen::MatrixXd a, const Eigen::MatrixXd& b) {
        a += b;
        return a;
      });
}

/// How far each patch is to move along its normals, in mm; none where all is well.
std::vector<double> offsets_for(const TetMesh& mesh, const std::map<Label, double>& wanted,
                                const std::map<Label, double>& volumes, const MovableVertices& movable) {
  const Eigen::MatrixXd growth = growth_by_patch(mesh, wanted, movable);
  Eigen::VectorXd missing(growth.rows()), weights(growth.cols());
  Eigen::Index row = 0;
  for (const auto& [label, volume] : wanted) missing[row++] = volume - volumes.at(label);
  for (Eigen::Index p = 0; p < weights.size(); ++p)
    weights[p] = movable.area[static_cast<std::size_t>(p)] > 0
                     ? 1 / std::sqrt(movable.area[static_cast<std::size_t>(p)])
                     : 0;
  const Eigen::VectorXd scaled =
      (growth * weights.asDiagonal()).eval().completeOrthogonalDecomposition().solve(missing);
  std::vector<double> offsets;
  for (Eigen::Index p = 0; p < weights.size(); ++p) {
    const double most = movable.largest[static_cast<std::size_t>(p)];
    offsets.push_back(std::clamp(weights[p] * scaled[p], -most, most));
  }
  return offsets;
}

/// Whether volumes of the same labels are far enough from those wanted to be worth a move.
bool is_restorable(const std::map<Label, double>& wanted, const std::map<Label, double>& volumes) {
  constexpr double kKept = 5e-4;
  const bool are_alike = std::equal(wanted.begin(), wanted.end(), volumes.begin(), volumes.end(),
                                    [](const auto& a, const auto& b) { return a.first == b.first; });
  return are_alike && std::ranges::any_of(wanted, [&](const auto& one) {
           return std::abs(volumes.at(one.first) - one.second) > kKept * one.second;
         });
}

}  // namespace

void restore_volumes(TetMesh& mesh, const std::map<Label, double>& wanted, const PlaceOnPatch& place,
                     const operators::SettlingRules& rules) {
  constexpr int kRounds = 2;  // What tetrahedra held back in the first is taken over by the others.
  for (int round = 0; round < kRounds; ++round) {
    const std::map<Label, double> volumes = volumes_of_labels(mesh);
    if (!is_restorable(wanted, volumes)) return;
    if (round == 0) metric::measure_qualities(mesh);
    const MovableVertices movable = movable_vertices(mesh, place);
    const std::vector<double> offsets = offsets_for(mesh, wanted, volumes, movable);
    std::vector<std::uint8_t> flags(movable.patch.size());
    std::transform(movable.patch.begin(), movable.patch.end(), flags.begin(),
                   [](std::uint32_t patch) { return patch != kNoPatch ? 1 : 0; });
    operators::settle(
        mesh,
        [&](PatchId patch, const Vec3& near) {
          auto at = place(patch, near);
          if (at) at->point = near + offsets[patch.value] * at->normal;
          return at;
        },
        {.lift = 0, .may_become = rules.may_become, .keep_within = rules.keep_within, .movable = flags});
  }
}

}  // namespace lumesh
