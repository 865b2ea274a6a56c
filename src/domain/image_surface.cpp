#include "lumesh/domain/image_surface.hpp"

namespace lumesh {

SurfacePoint ImageSurface::closest(const Vec3& point) const {
  const SurfacePoint near = guide_->closest(point);
  const std::optional<SurfacePoint> found = boundary_near(near.point);
  return found ? SurfacePoint{found->point + shift_mm_ * found->normal, found->normal} : near;
}

std::optional<SurfacePoint> ImageSurface::boundary_near(const Vec3& point) const {
  const std::optional<Vec3> found = domain_->project(point, {inside_, outside_}, reach_mm_);
  if (!found) return std::nullopt;
  // The separation grows towards `inside`.
  return SurfacePoint{*found, -domain_->separation(*found, inside_, outside_).gradient.normalized()};
}

}  // namespace lumesh
