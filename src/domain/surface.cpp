#include "lumesh/domain/surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "lumesh/geometry/triangle.hpp"

namespace lumesh {
namespace {

/// Points and chords of curve pieces, as a tree takes them.
TriangleTree tree_of_chords(std::span<const CurvePiece> pieces) {
  std::vector<Vec3> ends;
  std::vector<std::array<std::uint32_t, 3>> chords;
  for (const CurvePiece& piece : pieces) {
    const auto first = static_cast<std::uint32_t>(ends.size());
    ends.push_back(piece.control[0]);
    ends.push_back(piece.control[3]);
    chords.push_back({first, first + 1, first + 1});
  }
  return {ends, chords};
}

/// Place, first and second derivative of a piece at t.
std::array<Vec3, 3> derivatives_of(const CurvePiece& piece, double t) {
  const auto& [a, b, c, d] = piece.control;
  const double s = 1 - t;
  return {s * s * s * a + 3 * s * s * t * b + 3 * s * t * t * c + t * t * t * d,
          3 * (s * s * (b - a) + 2 * s * t * (c - b) + t * t * (d - c)),
          6 * (s * (c - 2 * b + a) + t * (d - 2 * c + b))};
}

/// Weights of the corners of a triangle in a point of its plane.
Vec3 barycentric(const Vec3& p, const std::array<Vec3, 3>& corners) {
  const auto& [a, b, c] = corners;
  const Vec3 normal = triangle_area_normal(a, b, c);
  const double squared = normal.squaredNorm();
  if (!(squared > 0)) return {1, 0, 0};
  const double v = (p - a).cross(c - a).dot(normal) / squared;
  const double w = (b - a).cross(p - a).dot(normal) / squared;
  const double low_v = std::clamp(v, 0.0, 1.0), low_w = std::clamp(w, 0.0, 1 - low_v);
  return {1 - low_v - low_w, low_v, low_w};
}

/// The control point of an edge next to its first end, on the tangent plane there.
Vec3 control_towards(const Vec3& from, const Vec3& normal, const Vec3& to) {
  const Vec3 edge = to - from;
  return from + (edge - edge.dot(normal) * normal) / 3;
}

/// The normal in the middle of an edge: that of a parabola through both ends' normals.
Vec3 normal_between(const Vec3& a, const Vec3& normal_a, const Vec3& b, const Vec3& normal_b) {
  const Vec3 edge = b - a, sum = normal_a + normal_b;
  return (sum - 2 * edge.dot(sum) / edge.squaredNorm() * edge).normalized();
}

/// @param edges  Control points next to a towards b and c, next to b towards a and c, next to c likewise.
CubicPatch cubic_patch(const std::array<Vec3, 3>& corners, const std::array<Vec3, 3>& normals,
                       const std::array<Vec3, 6>& edges) {
  const auto& [a, b, c] = corners;
  Vec3 edge_mean = Vec3::Zero();
  for (const Vec3& control : edges) edge_mean += control / 6;
  const Vec3 center = 1.5 * edge_mean - 0.5 / 3 * (a + b + c);
  return {
      {a, b, c, 3 * edges[0], 3 * edges[1], 3 * edges[2], 3 * edges[3], 3 * edges[4], 3 * edges[5],
       6 * center},
      {normals[0], normals[1], normals[2], 2 * normal_between(a, normals[0], b, normals[1]),
       2 * normal_between(b, normals[1], c, normals[2]), 2 * normal_between(c, normals[2], a, normals[0])}};
}

SurfacePoint at(const CubicPatch& patch, const Vec3& weights) {
  const double a = weights[0], b = weights[1], c = weights[2];
  const std::array<double, 10> cubic = {a * a * a, b * b * b, c * c * c, a * a * b, a * a * c,
                                        b * b * a, b * b * c, c * c * a, c * c * b, a * b * c};
  const std::array<double, 6> quadratic = {a * a, b * b, c * c, a * b, b * c, c * a};
  SurfacePoint result;
  for (std::size_t i = 0; i < cubic.size(); ++i) result.point += cubic[i] * patch.control[i];
  for (std::size_t i = 0; i < quadratic.size(); ++i) result.normal += quadratic[i] * patch.normals[i];
  result.normal.normalize();
  return result;
}

}  // namespace

std::vector<Vec3> vertex_normals(std::span<const Vec3> points,
                                 std::span<const std::array<std::uint32_t, 3>> triangles) {
  std::vector<Vec3> normals(points.size(), Vec3::Zero());
  for (const auto& v : triangles) {
    const Vec3 normal = triangle_normal(points, v);
    for (int k = 0; k < 3; ++k) {
      const Vec3 left = points[v[(k + 1) % 3]] - points[v[k]], right = points[v[(k + 2) % 3]] - points[v[k]];
      normals[v[k]] += angle_between(left, right) * normal;
    }
  }
  for (Vec3& normal : normals) normal.normalize();  // Leaves a sum of zero as it is.
  return normals;
}

SurfacePoint over_triangle(const std::array<Vec3, 3>& corners, const std::array<Vec3, 3>& normals,
                           const Vec3& point) {
  std::array<Vec3, 6> edges;
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t side = 0; side < 2; ++side) {
      const std::size_t other = side == 0 ? (k == 0 ? 1 : 0) : (k == 2 ? 1 : 2);
      edges[2 * k + side] = control_towards(corners[k], normals[k], corners[other]);
    }
  return at(cubic_patch(corners, normals, edges), barycentric(point, corners));
}

SurfacePoint CylinderSurface::closest(const Vec3& point) const {
  const Vec3 from_axis = point - on_axis_;
  const Vec3 radial = from_axis - from_axis.dot(axis_) * axis_;
  const double distance = radial.norm();
  const Vec3 normal = distance > 0 ? Vec3(radial / distance) : axis_.unitOrthogonal();
  return {point + (radius_ - distance) * normal, outward_ * normal};
}

MeshCurve::MeshCurve(std::vector<CurvePiece> pieces)
    : pieces_(std::move(pieces)), chords_(tree_of_chords(pieces_)) {}

CurvePoint MeshCurve::closest(const Vec3& point) const {
  constexpr int kSteps = 3;
  const TriangleTree::Nearest nearest = chords_.nearest(point);
  const CurvePiece& piece = pieces_[nearest.triangle];
  const Vec3 chord = piece.control[3] - piece.control[0];
  double t = chord.dot(nearest.point - piece.control[0]) / chord.squaredNorm();
  for (int i = 0; i < kSteps; ++i) {  // Newton's for (place - point) . tangent = 0.
    const auto [place, first, second] = derivatives_of(piece, t);
    const double slope = first.squaredNorm() + (place - point).dot(second);
    if (slope > 0) t = std::clamp(t - (place - point).dot(first) / slope, 0.0, 1.0);
  }
  const auto [place, first, second] = derivatives_of(piece, t);
  return {place, first.normalized()};
}

MeshSurface::MeshSurface(std::span<const Vec3> points,
                         std::span<const std::array<std::uint32_t, 3>> triangles, std::span<const Rim> rims)
    : tree_(points, triangles) {
  const std::vector<Vec3> normals = vertex_normals(points, triangles);
  std::map<std::array<std::uint32_t, 2>, Vec3> rim_controls;  // Next to the first vertex, towards the second.
  for (const Rim& rim : rims) {
    rim_controls[{rim.from, rim.to}] = rim.curve.control[1];
    rim_controls[{rim.to, rim.from}] = rim.curve.control[2];
  }
  const auto towards = [&](std::uint32_t a, std::uint32_t b) -> Vec3 {
    if (const auto rim = rim_controls.find({a, b}); rim != rim_controls.end()) return rim->second;
    return control_towards(points[a], normals[a], points[b]);
  };
  patches_.reserve(triangles.size());
  for (const auto& [a, b, c] : triangles) {
    corners_.push_back({points[a], points[b], points[c]});
    patches_.push_back(cubic_patch(
        corners_.back(), {normals[a], normals[b], normals[c]},
        {towards(a, b), towards(a, c), towards(b, a), towards(b, c), towards(c, a), towards(c, b)}));
  }
}

SurfacePoint MeshSurface::closest(const Vec3& point) const {
  const TriangleTree::Nearest nearest = tree_.nearest(point);
  return at(patches_[nearest.triangle], barycentric(nearest.point, corners_[nearest.triangle]));
}

}  // namespace lumesh
