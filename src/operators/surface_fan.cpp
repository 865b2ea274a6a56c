#include "surface_fan.hpp"

#include <algorithm>
#include <limits>

#include "lumesh/geometry/triangle.hpp"

namespace lumesh::operators {

SurfaceFan::SurfaceFan(const TetMesh& mesh, VertexId v, const VertexBall& ball)
    : centre_(mesh.point(v)), patch_(ball.patches[0]) {
  for (const TetId t : ball.tets) {
    for (int f = 0; f < 4; ++f) {
      if (!mesh.patch(t, f).valid() || mesh.vertex(t, f) == v) continue;
      const FaceLink link = mesh.link(t, f);
      // Faces between labels are met from both sides; that of the lower label counts.
      if (!link.is_boundary() && mesh.label(link.tet()) < mesh.label(t)) continue;
      Cell<3> corners = mesh.face_corners(t, f);
      while (corners[0] != v.value) std::rotate(corners.begin(), corners.begin() + 1, corners.end());
      rim_.push_back({mesh.point(VertexId(corners[1])), mesh.point(VertexId(corners[2]))});
      edge_length_ += (rim_.back()[0] - centre_).norm();
    }
  }
  edge_length_ /= static_cast<double>(rim_.size());
}

Vec3 SurfaceFan::normal() const {
  Vec3 sum = Vec3::Zero();
  for (const auto& [p, q] : rim_) sum += triangle_area_normal(centre_, p, q);
  return sum.normalized();
}

bool SurfaceFan::fits(const Vec3& to, const InputSurface& surface, const AngleRules& rules) const {
  constexpr double kMinCosine = 0.7;  // Of a face's turn.
  const double deviation = rules.max_deviation * edge_length_;
  const auto is_near = [&](const Vec3& point) {
    return surface.nearest(patch_, point, deviation).triangle != TriangleTree::kNone;
  };
  double retreat = std::numeric_limits<double>::infinity();
  for (const auto& [p, q] : rim_) {
    if (triangle_normal(to, p, q).dot(triangle_normal(centre_, p, q)) < kMinCosine) return false;
    if (!is_near(0.5 * (to + p)) || !is_near(triangle_centre(to, p, q))) return false;
    retreat = std::min(retreat, (closest_point_on_triangle(centre_, to, p, q) - centre_).norm());
  }
  return retreat <= rules.max_retreat * edge_length_;
}

}  // namespace lumesh::operators
