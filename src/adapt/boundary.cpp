#include "lumesh/adapt/boundary.hpp"

#include <algorithm>

#include "lumesh/operators/creases.hpp"
#include "lumesh/operators/settling.hpp"

namespace lumesh {
namespace {

/// Half-spaces between planes of openings that hold all of the mesh, as the border of an image does.
struct HalfSpaces {
  struct HalfSpace {
    Vec3 outward;
    double offset;
  };
  std::vector<HalfSpace> all;

  [[nodiscard]] Vec3 nearest_within(Vec3 place) const {
    for (const HalfSpace& one : all)
      place -= std::max(0.0, one.outward.dot(place) - one.offset) * one.outward;
    return place;
  }
};

HalfSpaces within_openings_of(const TetMesh& mesh, const operators::PatchShapes& shapes) {
  // Of what the mesh extends along the normal: coarse walls bulge beyond planes that they meet at a small
  // angle.
  constexpr double kBulge = 0.005;
  HalfSpaces spaces;
  const std::vector<Patch>& patches = mesh.info().patches;
  for (std::size_t p = 0; p < shapes.size(); ++p) {
    if (patches[p].kind != PatchKind::kOpening || shapes[p].freedom != operators::PatchFreedom::kPlane)
      continue;
    const Vec3& normal = shapes[p].normal;
    double low = 0, high = 0;
    for (const Vec3& point : mesh.points()) {
      const double height = normal.dot(point) - shapes[p].offset;
      low = std::min(low, height);
      high = std::max(high, height);
    }
    const double bulge = kBulge * (high - low);
    if (high <= bulge)
      spaces.all.push_back({normal, shapes[p].offset});
    else if (-low <= bulge)
      spaces.all.push_back({-normal, -shapes[p].offset});
  }
  return spaces;
}

}  // namespace

AdaptedBoundary::AdaptedBoundary(TetMesh& mesh, const BoundaryOptions& options, Context& context)
    : image_(options.image) {
  constexpr double kNoCreases = 180, kTolerance = 1e-10;
  origins_ = context.phase("creases", [&] {
    return operators::cut_patches_at_creases(mesh,
                                             options.is_frozen ? kNoCreases : options.feature_angle_deg);
  });
  shapes_ = context.phase("surfaces", [&] {
    return options.is_frozen
               ? operators::all_frozen(mesh)
               : operators::shapes_of_patches(mesh, kTolerance, operators::SurfaceKeeps::kVolume);
  });
  for (std::size_t part = 0; part < origins_.size(); ++part)
    if (std::find(options.frozen_patches.begin(), options.frozen_patches.end(), origins_[part]) !=
        options.frozen_patches.end())
      shapes_[part] = {};
  if (options.is_frozen) return;
  if (!options.image) {
    if (HalfSpaces spaces = within_openings_of(mesh, shapes_); !spaces.all.empty())
      keep_within_ = [spaces = std::move(spaces)](const Vec3& place) { return spaces.nearest_within(place); };
    return;
  }
  patches_on_image_ =
      context.phase("surfaces", [&] { return operators::follow_image(mesh, options.image, shapes_); });
}

operators::KeepWithin AdaptedBoundary::keep_within() const {
  return image_ ? operators::within_cuts_of(*image_) : keep_within_;
}

void AdaptedBoundary::restore_patches(TetMesh& mesh) const {
  operators::join_patches(mesh, origins_);
}

}  // namespace lumesh
