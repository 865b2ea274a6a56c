#include "surface_rules.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "lumesh/geometry/triangle.hpp"

namespace lumesh::operators {
namespace {

constexpr double kMaxSlope = 0.21;   // 12 degrees: a full circle of 15 edges.
constexpr double kMaxHeight = 0.5;   // In the metric.
constexpr double kMinFacing = 0.05;  // Less is a fold, or nearly one.

/// Projects on each surface in turn until none moves the point; planes last, which are to stay exactly flat.
std::optional<Vec3> place_by_turns(const Vec3& start, std::span<const PatchId> patches,
                                   const PatchShapes& shapes) {
  constexpr int kMaxTurns = 60;
  constexpr double kArrived = 1e-14;  // Of the coordinates' size.
  const double arrived = kArrived * (1 + start.cwiseAbs().maxCoeff());
  Vec3 point = start;
  for (int turn = 0; turn < kMaxTurns; ++turn) {
    const Vec3 before = point;
    for (const PatchId patch : patches)
      if (const PatchShape& shape = shapes[patch.value]; shape.freedom == PatchFreedom::kCurved)
        point = shape.surface->closest(point).point;
    for (const PatchId patch : patches)
      if (const PatchShape& shape = shapes[patch.value]; shape.freedom == PatchFreedom::kPlane)
        point -= (shape.normal.dot(point) - shape.offset) * shape.normal;
    if ((point - before).cwiseAbs().maxCoeff() <= arrived) return point;
  }
  return std::nullopt;
}

/// Estimated for a circle's arc: an eighth of the chord's rise over the tangent planes, at both ends.
double height_of_arc(const SurfaceCorner& p, const SurfaceCorner& q) {
  const Vec3 chord = q.point - p.point;
  return (std::abs(p.normal.dot(chord)) * std::sqrt(p.metric.quadratic(p.normal)) +
          std::abs(q.normal.dot(chord)) * std::sqrt(q.metric.quadratic(q.normal))) /
         8;
}

const MeshCurve* curve_between(PatchId one, PatchId other, const PatchShapes& shapes) {
  for (const auto& [patch, curve] : shapes[one.value].curves)
    if (patch == other) return curve.get();
  return nullptr;
}

}  // namespace

bool is_any_frozen(std::span<const PatchId> patches, const PatchShapes& shapes) {
  return std::ranges::any_of(
      patches, [&](PatchId patch) { return shapes[patch.value].freedom == PatchFreedom::kFrozen; });
}

bool is_any_curved(std::span<const PatchId> patches, const PatchShapes& shapes) {
  return std::ranges::any_of(
      patches, [&](PatchId patch) { return shapes[patch.value].freedom == PatchFreedom::kCurved; });
}

std::optional<Vec3> place_on_patches(const Vec3& point, std::span<const PatchId> patches,
                                     const PatchShapes& shapes) {
  if (!is_any_curved(patches, shapes)) return point;
  if (patches.size() == 1) return shapes[patches[0].value].surface->closest(point).point;
  if (patches.size() == 2)
    if (const MeshCurve* curve = curve_between(patches[0], patches[1], shapes))
      return curve->closest(point).point;
  return place_by_turns(point, patches, shapes);
}

Vec3 patch_normal(const PatchShape& shape, const Vec3& point) {
  return shape.freedom == PatchFreedom::kCurved ? shape.surface->closest(point).normal : shape.normal;
}

Vec3 curve_tangent(const Vec3& point, PatchId one, PatchId other, const PatchShapes& shapes) {
  if (const MeshCurve* curve = curve_between(one, other, shapes)) return curve->closest(point).tangent;
  const Vec3 across = patch_normal(shapes[one.value], point).cross(patch_normal(shapes[other.value], point));
  constexpr double kParallel = 1e-6;
  return across.norm() > kParallel ? across.normalized() : Vec3(Vec3::Zero());
}

double arc_height(const TetMesh& mesh, TetId t, int i, int j, const PatchShapes& shapes) {
  for (int f = 0; f < 4; ++f) {
    const PatchId patch = mesh.patch(t, f);
    if (f == i || f == j || !patch.valid() || shapes[patch.value].freedom != PatchFreedom::kCurved) continue;
    const Surface& surface = *shapes[patch.value].surface;
    const auto corner = [&](int k) {
      return surface_corner(surface, mesh.corner(t, k), mesh.metric(mesh.vertex(t, k)));
    };
    return height_of_arc(corner(i), corner(j));
  }
  return 0;
}

SurfaceCorner surface_corner(const Surface& surface, const Vec3& point, const SymTensor& metric) {
  return {point, metric, surface.closest(point).normal};
}

void SurfaceDeviation::add(const SurfaceCorner& a, const SurfaceCorner& b, const SurfaceCorner& c) {
  const std::array<const SurfaceCorner*, 3> corners = {&a, &b, &c};
  const Vec3 normal = triangle_normal(a.point, b.point, c.point);
  for (int k = 0; k < 3; ++k) {
    const SurfaceCorner &from = *corners[k], &to = *corners[(k + 1) % 3];
    const Vec3 edge = to.point - from.point;
    slope = std::max(slope,
                     std::max(std::abs(from.normal.dot(edge)), std::abs(to.normal.dot(edge))) / edge.norm());
    height = std::max(height, height_of_arc(from, to));
    facing = std::min(facing, normal.dot(from.normal));
  }
}

void SurfaceDeviation::add(const Surface& surface, const TetMesh& mesh, const Cell<3>& corners) {
  const auto corner = [&](int k) {
    const VertexId v(corners[k]);
    return surface_corner(surface, mesh.point(v), mesh.metric(v));
  };
  add(corner(0), corner(1), corner(2));
}

bool SurfaceDeviation::is_small() const {
  return facing >= kMinFacing && slope <= kMaxSlope && height <= kMaxHeight;
}

bool SurfaceDeviation::may_follow(const SurfaceDeviation& before) const {
  return facing >= std::min(kMinFacing, before.facing) && slope <= std::max(kMaxSlope, before.slope) &&
         height <= std::max(kMaxHeight, before.height);
}

bool keeps_to_surface_across(const TetMesh& mesh, const EdgeRing& ring, VertexId a, VertexId b,
                             const PatchShapes& shapes) {
  if (!is_any_curved(ring.patches, shapes)) return true;
  const Surface& surface = *shapes[ring.patches[0].value].surface;
  const std::uint32_t first = ring.rim.front(), last = ring.rim.back();
  // Outside, the quadrilateral a, first, b, last goes round anticlockwise.
  SurfaceDeviation before, after;
  before.add(surface, mesh, {b.value, a.value, first});
  before.add(surface, mesh, {a.value, b.value, last});
  after.add(surface, mesh, {a.value, first, last});
  after.add(surface, mesh, {first, b.value, last});
  return after.may_follow(before);
}

}  // namespace lumesh::operators
