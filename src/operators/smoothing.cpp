#include "lumesh/operators/smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "apply.hpp"
#include "surface_rules.hpp"

namespace lumesh::operators {
namespace {

/// Deviation of a length from 1: sinh^2(ln L), which is (ln L)^2 near 1 and needs no logarithm.
double length_deviation(double length) {
  const double x = 0.5 * (length - 1 / length);
  return x * x;
}

/// Solves H x = b for positive definite H by Cholesky; none if H is not.
std::optional<Vec3> solve_positive(const SymTensor& h, const Vec3& b) {
  if (!(h.xx > 0)) return std::nullopt;
  const double l11 = std::sqrt(h.xx), l21 = h.xy / l11, l31 = h.xz / l11;
  const double d2 = h.yy - l21 * l21;
  if (!(d2 > 0)) return std::nullopt;
  const double l22 = std::sqrt(d2), l32 = (h.yz - l31 * l21) / l22;
  const double d3 = h.zz - l31 * l31 - l32 * l32;
  if (!(d3 > 0)) return std::nullopt;
  const double l33 = std::sqrt(d3);
  const double y1 = b[0] / l11, y2 = (b[1] - l21 * y1) / l22, y3 = (b[2] - l31 * y1 - l32 * y2) / l33;
  const double x3 = y3 / l33, x2 = (y2 - l32 * x3) / l22;
  return Vec3((y1 - l21 * x2 - l31 * x3) / l11, x2, x3);
}

/// Where a vertex may go: everywhere, in a plane, along a line, or nowhere.
struct Freedom {
  int dimensions = 3;
  Vec3 direction = Vec3::Zero();  ///< Normal of the plane, or along the line.

  [[nodiscard]] Vec3 project(const Vec3& step) const {
    if (dimensions == 3) return step;
    const Vec3 along = direction.dot(step) * direction;
    return dimensions == 2 ? Vec3(step - along) : along;
  }
};

/// Freedom of a vertex at `point` of these patches: within their tangent planes.
Freedom freedom_of(const Vec3& point, const std::vector<PatchId>& patches, const PatchShapes& shapes) {
  if (is_any_frozen(patches, shapes)) return {0, {}};
  if (patches.size() == 2 && is_any_curved(patches, shapes)) {
    const Vec3 tangent = curve_tangent(point, patches[0], patches[1], shapes);
    return {tangent.squaredNorm() > 0 ? 1 : 0, tangent};
  }
  Freedom freedom;
  for (const PatchId patch : patches) {
    const Vec3 normal = patch_normal(shapes[patch.value], point);
    if (freedom.dimensions == 3) {
      freedom = {2, normal};
      continue;
    }
    // The second plane leaves a line; a third one would leave a point unless it holds the line.
    constexpr double kParallel = 1e-6;
    if (freedom.dimensions == 2) {
      const Vec3 line = freedom.direction.cross(normal);
      if (line.norm() > kParallel) freedom = {1, line.normalized()};
    } else if (std::abs(freedom.direction.dot(normal)) > kParallel) {
      return {0, {}};
    }
  }
  return freedom;
}

/// True if the faces of curved patches around v keep to their surface when it goes to `to`.
bool keeps_to_surface_at(const TetMesh& mesh, VertexId v, const Vec3& to, const SymTensor& metric,
                         const VertexBall& ball, const PatchShapes& shapes) {
  if (!is_any_curved(ball.patches, shapes)) return true;
  SurfaceDeviation before, after;
  for (const TetId t : ball.tets) {
    for (int f = 0; f < 4; ++f) {
      const PatchId patch = mesh.patch(t, f);
      if (!patch.valid() || shapes[patch.value].freedom != PatchFreedom::kCurved) continue;
      const Cell<3> corners = mesh.face_corners(t, f);
      if (std::ranges::find(corners, v.value) == corners.end()) continue;
      const Surface& surface = *shapes[patch.value].surface;
      before.add(surface, mesh, corners);
      const auto corner = [&](int k) {
        const VertexId w(corners[k]);
        return w == v ? surface_corner(surface, to, metric)
                      : surface_corner(surface, mesh.point(w), mesh.metric(w));
      };
      after.add(corner(0), corner(1), corner(2));
    }
  }
  return after.may_follow(before);
}

SymTensor symmetric_product(const Vec3& u, const Vec3& v) {  // u v^T + v u^T
  return {2 * u[0] * v[0], u[0] * v[1] + u[1] * v[0], u[0] * v[2] + u[2] * v[0],
          2 * u[1] * v[1], u[1] * v[2] + u[2] * v[1], 2 * u[2] * v[2]};
}

/// The sum that smoothing lessens.
struct Objective : ShapeSums {
  void add_edge(const TetMesh& mesh, VertexId v, const Vec3& x, VertexId w, double weight) {
    const Vec3 edge = x - mesh.point(w);
    const double length = metric::edge_length(x, mesh.metric(v), mesh.point(w), mesh.metric(w));
    const SymTensor m = 0.5 * (mesh.metric(v) + mesh.metric(w));
    const Vec3 direction = (1 / m.quadratic(edge)) * m.times(edge);  // Gradient of ln L.
    const double inverse = 1 / length;
    value += weight * length_deviation(length);
    gradient += (0.5 * weight * (length - inverse) * (length + inverse)) * direction;
    const double slope = 0.5 * (length + inverse);
    hessian = hessian + (weight * slope * slope) * symmetric_product(direction, direction);
  }
};

/// Newton's step within the freedom, shortened to `max_step` in the metric; along the metric's gradient where
/// the Hessian is not positive.
Vec3 step_of(const Objective& objective, const Freedom& freedom, const SymTensor& metric, double max_step) {
  const auto within = [&](const SymTensor& h) {
    if (freedom.dimensions == 3) return h;
    const Vec3& d = freedom.direction;
    const SymTensor dd = 0.5 * symmetric_product(d, d);
    if (freedom.dimensions == 1) {  // Only what it does along d counts.
      const double scale = h.quadratic(d);
      return scale * SymTensor::diagonal(1, 1, 1);
    }
    const Mat3 project = Mat3::Identity() - dd.matrix();
    return SymTensor::from(project * h.matrix() * project) + h.trace() * dd;
  };
  const Vec3 slope = freedom.project(-objective.gradient);
  std::optional<Vec3> step = solve_positive(within(objective.hessian), slope);
  double limit = max_step;
  if (!step) {
    step = solve_positive(within(metric), slope);
    limit = 0.5 * max_step;
    if (!step) return Vec3::Zero();
    *step *= 1e6;  // Its length says nothing; the limit does.
  }
  *step = freedom.project(*step);
  const double length = std::sqrt(metric.quadratic(*step));
  return length > limit ? Vec3(limit / length * *step) : *step;
}

/// Moves the vertex of the ball, unless the sum were not below `below` or a tetrahedron below the floor.
bool move_if_better(auto& site, VertexId v, const Vec3& to, double below, double floor,
                    const SmoothingRules& rules) {
  TetMesh& mesh = site.mesh;
  VertexBall& ball = site.scratch.ball;
  std::vector<float>& qualities = site.scratch.qualities;
  TetId hint = mesh.metric_hint(v);
  const metric::MetricPair pair = site.subject.field.at(to, hint);
  double sum = 0;
  for (const std::uint32_t w : ball.neighbours) {
    const VertexId n(w);
    sum += rules.length_weight *
           length_deviation(metric::edge_length(to, pair.metric, mesh.point(n), mesh.metric(n)));
  }
  if (!(sum < below)) return false;
  constexpr double kNoticed = 0.1;  // Shorter moves open no way to reconnect that was closed before.
  qualities.clear();
  const double floor_cubed = 0.999 * metric::cube(floor);  // Stored qualities are rounded.
  for (const double cubed : site.scratch.shapes.ratios_cubed_at(to, pair.log)) {
    if (!(cubed >= floor_cubed) || !(cubed > 0)) return false;
    const double quality = metric::cube_root(cubed);
    qualities.push_back(static_cast<float>(quality));
    sum += 1 / quality;
    if (!(sum < below)) return false;
  }
  for (const TetId t : ball.tets) {
    const auto [x, y, z] = kTetFaces[mesh.index_of(t, v)];
    if (orient3d(mesh.corner(t, x), mesh.corner(t, z), mesh.corner(t, y), to) <= 0) return false;
  }
  if (!keeps_to_surface_at(mesh, v, to, pair.metric, ball, site.subject.shapes)) return false;
  const double moved = std::sqrt(mesh.metric(v).quadratic(to - mesh.point(v)));
  mesh.set_point(v, to);
  mesh.set_metric(v, pair.metric, pair.log);
  mesh.set_metric_hint(v, hint);
  for (std::size_t i = 0; i < ball.tets.size(); ++i) mesh.set_quality(ball.tets[i], qualities[i]);
  if (moved < kNoticed) return true;
  site.scratch.builder.note_change(ball.neighbours);
  mesh.set_change_epoch(v, site.scratch.builder.epoch);
  return true;
}

}  // namespace

Outcome VertexSmoothing::operator()(auto& site, VertexId v) const {
  TetMesh& mesh = site.mesh;
  VertexBall& ball = site.scratch.ball;
  if (mesh.dimension(v) == VertexDimension::kCorner) return Outcome::kRejected;
  if (!gather_ball(mesh, v, site.lock, ball)) return Outcome::kContended;
  const Vec3 old = mesh.point(v);
  const Freedom freedom = freedom_of(old, ball.patches, site.subject.shapes);
  if (freedom.dimensions == 0) return Outcome::kRejected;

  StarShapes& shapes = site.scratch.shapes;
  shapes.gather(mesh, v, ball.tets);
  Objective before{shapes.sums_at(old, mesh.log_metric(v))};
  float worst = 1;
  for (const TetId t : ball.tets) worst = std::min(worst, mesh.quality(t));
  for (const std::uint32_t w : ball.neighbours)
    before.add_edge(mesh, v, old, VertexId(w), rules.length_weight);

  Vec3 step = step_of(before, freedom, mesh.metric(v), rules.max_step);
  if (!(mesh.metric(v).quadratic(step) > rules.min_step * rules.min_step)) return Outcome::kRejected;
  const double floor = std::min<double>(worst, rules.quality_floor);
  for (int i = 0; i < rules.halvings; ++i, step *= 0.5) {
    const auto place = place_on_patches(old + step, ball.patches, site.subject.shapes);
    if (place && move_if_better(site, v, *place, before.value, floor, rules)) return Outcome::kApplied;
  }
  return Outcome::kRejected;
}

template struct OperatorCode<VertexSmoothing>;

}  // namespace lumesh::operators
