#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "lumesh/core/even_places.hpp"
#include "phantom_impl.hpp"

namespace lumesh {

using image::AxisPoint;
using image::PhantomGeometry;
using image::Vessel;

namespace {

using std::numbers::pi;

constexpr double kInletSpeed = 0.25;  ///< Mean over the cross-section, m/s.
constexpr double kSacSpeed = 0.05;    ///< At the rim of the vortex in the sac, m/s.

/// The longest part of a path inside the image, with its ends on the outer faces.
std::vector<AxisPoint> clip(const std::vector<AxisPoint>& axis, const Phantom::Impl& impl) {
  const auto crossing = [&](const AxisPoint& a, const AxisPoint& b) {
    const double da = impl.box_distance(a.centre);
    const double db = impl.box_distance(b.centre);
    const double t = da / (da - db);
    return AxisPoint{a.centre + t * (b.centre - a.centre), a.radius + t * (b.radius - a.radius)};
  };
  std::vector<AxisPoint> kept;
  for (std::size_t i = 0; i < axis.size(); ++i) {
    const bool inside = impl.box_distance(axis[i].centre) <= 0;
    const bool before = i > 0 && impl.box_distance(axis[i - 1].centre) <= 0;
    if (i > 0 && inside != before) kept.push_back(crossing(axis[i - 1], axis[i]));
    if (inside) kept.push_back(axis[i]);
  }
  return kept;
}

/// Points at equal gaps of about `step_mm`, ends kept.
std::vector<AxisPoint> resample(const std::vector<AxisPoint>& axis, double step_mm) {
  std::vector<double> length = {0};
  for (std::size_t i = 1; i < axis.size(); ++i)
    length.push_back(length.back() + (axis[i].centre - axis[i - 1].centre).norm());
  const auto steps = static_cast<std::size_t>(std::max(1.0, std::round(length.back() / step_mm)));
  std::vector<AxisPoint> even;
  for (const PolylinePlace& at : even_places(length, steps, steps + 1)) {
    const AxisPoint &first = axis[at.leg], &second = axis[at.leg + 1];
    even.push_back({at.between(first.centre, second.centre), at.between(first.radius, second.radius)});
  }
  return even;
}

/// Moving mean over half a radius to both sides, which rounds the corner at a junction; straight ends stay.
std::vector<AxisPoint> round_corners(const std::vector<AxisPoint>& path, double step_mm) {
  std::vector<AxisPoint> smooth = path;
  const auto count = static_cast<int>(path.size());
  for (int i = 0; i < count; ++i) {
    const int wanted = static_cast<int>(0.5 * path[static_cast<std::size_t>(i)].radius / step_mm);
    const int reach = std::min({wanted, i, count - 1 - i});
    AxisPoint sum;
    for (int n = i - reach; n <= i + reach; ++n) {
      sum.centre += path[static_cast<std::size_t>(n)].centre;
      sum.radius += path[static_cast<std::size_t>(n)].radius;
    }
    smooth[static_cast<std::size_t>(i)] = {sum.centre / (2 * reach + 1), sum.radius / (2 * reach + 1)};
  }
  return smooth;
}

/// Axes across a path that turn as little as possible along it.
struct PathFrame {
  Vec3 tangent;
  Vec3 first;
  Vec3 second;
};

std::vector<PathFrame> transport_frames(const std::vector<AxisPoint>& path) {
  std::vector<PathFrame> frames;
  Vec3 across = Vec3::UnitX();
  for (std::size_t i = 0; i < path.size(); ++i) {
    const std::size_t before = i > 0 ? i - 1 : 0;
    const std::size_t after = std::min(i + 1, path.size() - 1);
    const Vec3 tangent = (path[after].centre - path[before].centre).normalized();
    if (i == 0 && std::abs(tangent.x()) > 0.9) across = Vec3::UnitY();
    across = (across - across.dot(tangent) * tangent).normalized();
    frames.push_back({tangent, across, tangent.cross(across)});
  }
  return frames;
}

/// Share of the inlet's flow that leaves through each branch; entry 0 (the parent) is 0.
std::vector<double> flow_shares(const PhantomGeometry& geometry, const Phantom::Impl& impl) {
  std::vector<double> shares = {0};
  double total = 0;
  for (std::size_t b = 1; b < geometry.vessels.size(); ++b) {
    const double radius = clip(geometry.vessels[b].axis, impl).back().radius;
    shares.push_back(radius * radius * radius);
    total += shares.back();
  }
  for (double& share : shares) share /= total;
  return shares;
}

/// A path from the inlet to one outlet and the flow (as a share of the inlet's) at each of its points.
struct OutletPath {
  std::vector<AxisPoint> points;
  std::vector<double> flow;
};

OutletPath outlet_path(const PhantomGeometry& geometry, std::size_t branch, const std::vector<double>& shares,
                       const Phantom::Impl& impl) {
  const Vessel& parent = geometry.vessels.front();
  const Vessel& outlet = geometry.vessels[branch];
  const double step_mm = 2 * impl.frame.spacing_mm.minCoeff();
  std::vector<AxisPoint> joined(parent.axis.begin(),
                                parent.axis.begin() + static_cast<std::ptrdiff_t>(outlet.joins_parent_at));
  joined.insert(joined.end(), outlet.axis.begin(), outlet.axis.end());
  OutletPath path;
  path.points = round_corners(resample(clip(joined, impl), step_mm), step_mm);
  const auto nearest = [&](const Vec3& p) {
    return std::ranges::min_element(path.points,
                                    [&](const AxisPoint& a, const AxisPoint& b) {
                                      return (a.centre - p).squaredNorm() < (b.centre - p).squaredNorm();
                                    }) -
           path.points.begin();
  };
  path.flow.assign(path.points.size(), 1.0);
  for (std::size_t b = 1; b < geometry.vessels.size(); ++b) {
    const Vessel& other = geometry.vessels[b];
    if (b == branch || other.joins_parent_at > outlet.joins_parent_at) continue;
    const auto from = nearest(parent.axis[other.joins_parent_at].centre);
    for (auto i = static_cast<std::size_t>(from); i < path.flow.size(); ++i) path.flow[i] -= shares[b];
  }
  const auto own = nearest(outlet.axis.front().centre);
  std::fill(path.flow.begin() + own, path.flow.end(), shares[branch]);
  return path;
}

/// One streamline at a fixed share of the radius and a fixed angle around the path.
PhantomStreamline follow(const OutletPath& path, const std::vector<PathFrame>& frames, double share,
                         double angle, double inlet_flow, const Phantom::Impl& impl) {
  PhantomStreamline line;
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    const AxisPoint& at = path.points[i];
    const Vec3 across = std::cos(angle) * frames[i].first + std::sin(angle) * frames[i].second;
    const double mean_speed = inlet_flow * path.flow[i] / (pi * at.radius * at.radius);
    line.points_mm.push_back(impl.to_physical(at.centre + share * at.radius * across));
    line.velocity_m_s.push_back(impl.frame.direction *
                                (2 * mean_speed * (1 - share * share) * frames[i].tangent));
  }
  return line;
}

/// A circle in the sac that the flow past its neck drives.
PhantomStreamline sac_circle(const PhantomGeometry& geometry, double share, const Phantom::Impl& impl) {
  constexpr int kPoints = 48;
  const AxisPoint& sac = *geometry.sac;
  const std::vector<AxisPoint>& parent = geometry.vessels.front().axis;
  std::size_t foot = 1;
  for (std::size_t i = 1; i + 1 < parent.size(); ++i)
    if ((parent[i].centre - sac.centre).norm() < (parent[foot].centre - sac.centre).norm()) foot = i;
  const Vec3 to_neck = (parent[foot].centre - sac.centre).normalized();
  const Vec3 along = parent[foot].centre - parent[foot - 1].centre;
  const Vec3 flow = (along - along.dot(to_neck) * to_neck).normalized();
  PhantomStreamline line;
  for (int i = 0; i <= kPoints; ++i) {
    const double turn = 2 * pi * (i % kPoints) / kPoints;
    line.points_mm.push_back(impl.to_physical(
        sac.centre + share * sac.radius * (std::cos(turn) * to_neck + std::sin(turn) * flow)));
    line.velocity_m_s.push_back(impl.frame.direction *
                                (kSacSpeed * share * (std::cos(turn) * flow - std::sin(turn) * to_neck)));
  }
  return line;
}

}  // namespace

std::vector<PhantomCurve> Phantom::centerline() const {
  std::vector<PhantomCurve> curves;
  const auto add = [&](const std::vector<AxisPoint>& axis, int branch) {
    PhantomCurve curve;
    curve.branch = branch;
    for (const AxisPoint& point : axis) {
      curve.points_mm.push_back(impl_->to_physical(point.centre));
      curve.radius_mm.push_back(point.radius);
    }
    curves.push_back(std::move(curve));
  };
  const double step_mm = 2 * impl_->frame.spacing_mm.minCoeff();
  const std::vector<Vessel>& vessels = impl_->geometry.vessels;
  for (std::size_t v = 0; v < vessels.size(); ++v)
    add(resample(clip(vessels[v].axis, *impl_), step_mm), static_cast<int>(v));
  if (!impl_->geometry.closed_axis.empty()) add(impl_->geometry.closed_axis, 0);
  return curves;
}

std::vector<PhantomStreamline> Phantom::velocity_streamlines() const {
  const PhantomGeometry& geometry = impl_->geometry;
  std::vector<PhantomStreamline> lines;
  if (geometry.vessels.empty()) return lines;
  const std::vector<double> shares = flow_shares(geometry, *impl_);
  const double inlet_radius = clip(geometry.vessels.front().axis, *impl_).front().radius;
  const double inlet_flow = kInletSpeed * pi * inlet_radius * inlet_radius;
  for (std::size_t branch = 1; branch < geometry.vessels.size(); ++branch) {
    const OutletPath path = outlet_path(geometry, branch, shares, *impl_);
    const std::vector<PathFrame> frames = transport_frames(path.points);
    lines.push_back(follow(path, frames, 0, 0, inlet_flow, *impl_));
    for (const double share : {0.4, 0.75})
      for (int spoke = 0; spoke < 6; ++spoke)
        lines.push_back(follow(path, frames, share, spoke * pi / 3, inlet_flow, *impl_));
  }
  for (const double share : {0.25, 0.5, 0.75}) lines.push_back(sac_circle(geometry, share, *impl_));
  return lines;
}

}  // namespace lumesh
