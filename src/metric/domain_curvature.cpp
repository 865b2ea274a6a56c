// Curvature as the domain knows it, where a mesh's own boundary may be coarse or rough.
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "lumesh/core/assert.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/metric/curvature_metric.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::metric {

namespace {

/// A vertex and the materials whose boundary it lies on.
using Place = std::array<std::uint32_t, 3>;

/// All that is no opening and no plane of symmetry; ascending.
std::vector<Place> boundary_places(const TetMesh& mesh, const Domain& domain) {
  const BoundaryFaces faces = mesh.boundary_faces();
  std::vector<Place> places;
  for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
    if (is_plane(mesh.info().patches[static_cast<std::size_t>(faces.patches[f])].kind)) continue;
    const auto& [inside, outside] = faces.tets[f];
    const Material in = domain.material_of(mesh.label(inside)).value_or(0);
    const Material out = outside.valid() ? domain.material_of(mesh.label(outside)).value_or(0) : 0;
    if (in == out) continue;
    for (const std::uint32_t v : faces.triangles[f]) places.push_back({v, in, out});
  }
  parallel::sort_unique(places);
  return places;
}

/// Curvature of the level surface of the separation through the place; none where it has no normal.
std::optional<SurfaceCurvature> curvature_at(const Domain& domain, const Vec3& place, const Place& of) {
  const double step = domain.resolution_mm();
  const auto normal_at = [&](const Vec3& x) -> Vec3 {
    return domain.separation(x, of[1], of[2]).gradient.normalized();
  };
  Mat3 frame;
  frame.col(2) = normal_at(place);
  if (!(frame.col(2).norm() > 0.5)) return std::nullopt;
  frame.col(0) = frame.col(2).unitOrthogonal();
  frame.col(1) = frame.col(2).cross(frame.col(0));
  Eigen::Matrix2d change;
  for (int i = 0; i < 2; ++i) {
    const Vec3 aside = step * frame.col(i);
    change.col(i) =
        frame.leftCols<2>().transpose() * (normal_at(place + aside) - normal_at(place - aside)) / (2 * step);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver((change + change.transpose()) / 2);
  SurfaceCurvature found;
  found.axes.leftCols<2>() = frame.leftCols<2>() * solver.eigenvectors();
  found.axes.col(2) = frame.col(2);
  found.curvatures = {solver.eigenvalues()[0], solver.eigenvalues()[1]};
  return found;
}

}  // namespace

std::vector<SymTensor> metric_from_curvature(const TetMesh& mesh, const Domain& domain,
                                             const CurvatureOptions& options) {
  options.validate();
  LUMESH_ASSERT(mesh.is_compact());
  const double largest = options.largest_of(mesh.points());
  const std::vector<Place> places = boundary_places(mesh, domain);
  std::vector<std::optional<SurfaceCurvature>> curvatures(places.size());
  constexpr double kReach = 3;  // Resolutions: as far as the fields of images tell.
  parallel::for_each_index(places.size(), 64, [&](std::size_t i) {
    const auto closest = domain.project(mesh.points()[places[i][0]], {places[i][1], places[i][2]},
                                        kReach * domain.resolution_mm());
    if (closest) curvatures[i] = curvature_at(domain, *closest, places[i]);
  });
  const auto found = [](const auto& curvature) { return curvature.has_value(); };
  if (std::ranges::none_of(curvatures, found))
    throw Error(ErrorKind::kBadInput,
                "the mesh's boundary is not near its own; give the one the mesh was made of");
  const double flat = 1 / (largest * largest);
  std::vector<SymTensor> metric(mesh.vertex_count(), SymTensor::diagonal(flat, flat, flat));
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!curvatures[i]) continue;
    SymTensor& tensor = metric[places[i][0]];
    tensor = intersection(tensor, metric_of_curvature(*curvatures[i], options, largest));
  }
  return metric;
}

}  // namespace lumesh::metric
