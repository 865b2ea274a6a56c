#include "lumesh/adapt/boundary.hpp"

#include <algorithm>
#include <utility>

#include "lumesh/domain/domain.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/operators/creases.hpp"
#include "lumesh/operators/settling.hpp"

namespace lumesh {
namespace {

/// Planes of openings that all of the mesh lies below, as below the border of an image; their normals point
/// away from it.
std::vector<CutPlane> openings_around(const TetMesh& mesh, const operators::PatchShapes& shapes) {
  // Of what the mesh extends along the normal: coarse walls bulge beyond planes that they meet at a small
  // angle.
  constexpr double kBulge = 0.005;
  std::vector<CutPlane> planes;
  const std::vector<Patch>& patches = mesh.info().patches;
  for (std::size_t p = 0; p < shapes.size(); ++p) {
    if (patches[p].kind != PatchKind::kOpening || shapes[p].freedom != operators::PatchFreedom::kPlane)
      continue;
    CutPlane plane{.point_mm = shapes[p].offset * shapes[p].normal, .normal = shapes[p].normal};
    double low = 0, high = 0;
    for (const Vec3& point : mesh.points()) {
      low = std::min(low, plane.height(point));
      high = std::max(high, plane.height(point));
    }
    if (-low < high) plane.normal = -plane.normal;
    if (std::min(-low, high) <= kBulge * (high - low)) planes.push_back(plane);
  }
  return planes;
}

operators::KeepWithin below(std::vector<CutPlane> planes) {
  if (planes.empty()) return {};
  return [planes = std::move(planes)](const Vec3& place) { return nearest_within(planes, place); };
}

/// How far points of one plane or cylinder may be off it, as a share of the diagonal: surfaces of which many
/// meshes are made have coordinates in single precision.
double tolerance_of(const TetMesh& mesh) {
  constexpr double kSingle = 5e-7;  // Four roundings.
  const Box3 box = bounding_box(mesh.points());
  const double largest = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
  return kSingle * std::max(1.0, largest / box.diagonal().norm());
}

}  // namespace

AdaptedBoundary::AdaptedBoundary(TetMesh& mesh, const BoundaryOptions& options, Context& context)
    : image_(options.image) {
  constexpr double kNoCreases = 180;
  // The boundary of an image is smooth: where a coarse mesh of it bends sharply, a facet is no plane.
  const bool may_have_creases = !options.is_frozen && !options.image;
  origins_ = context.phase("creases", [&] {
    return operators::cut_patches_at_creases(mesh, may_have_creases ? options.feature_angle_deg : kNoCreases);
  });
  shapes_ = context.phase("surfaces", [&] {
    return options.is_frozen
               ? operators::all_frozen(mesh)
               : operators::shapes_of_patches(mesh, tolerance_of(mesh), operators::SurfaceKeeps::kVolume);
  });
  for (std::size_t part = 0; part < origins_.size(); ++part)
    if (std::ranges::find(options.frozen_patches, origins_[part]) != options.frozen_patches.end())
      shapes_[part] = {};
  keep_within_ = image_ ? operators::within_cuts_of(*image_) : below(openings_around(mesh, shapes_));
  if (options.is_frozen || !options.image) return;
  patches_on_image_ =
      context.phase("surfaces", [&] { return operators::follow_image(mesh, options.image, shapes_); });
}

void AdaptedBoundary::restore_patches(TetMesh& mesh) const {
  operators::join_patches(mesh, origins_);
}

}  // namespace lumesh
