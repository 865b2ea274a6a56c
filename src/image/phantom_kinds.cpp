#include "phantom_kinds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lumesh/core/error.hpp"

namespace lumesh::image {

PhantomReference reference_of(PhantomKind kind) {
  constexpr double kBall = 20;
  switch (kind) {
    case PhantomKind::kCarotid:
      return {{512, 512, 508}, 1.0, 14, 4, 35, 0};
    case PhantomKind::kBifurcation:
      return {{176, 128, 160}, 0.15, 9, 6, 16, 0};
    case PhantomKind::kLayered:
      return {{96, 96, 96}, 1.0, kBall, 0, 0, 0};
    case PhantomKind::kSphere:
      return {{64, 64, 64}, 1.0, kBall, 0, 0, 0};
    case PhantomKind::kTorus:
      return {{96, 96, 48}, 1.0, 11, 0, 0, 28};
  }
  throw Error(ErrorKind::kUsage, "unknown kind of phantom");
}

namespace {

using std::numbers::pi;

/// Millimetres per voxel of the reference image, after fitting that image into this one.
double scale_of(const PhantomSpec& spec) {
  const Vec3 extent = spec.size.cast<double>().cwiseProduct(spec.spacing_mm);
  return extent.cwiseQuotient(reference_of(spec.kind).size.cast<double>()).minCoeff();
}

Vec3 centre_of(const PhantomSpec& spec) {
  return 0.5 * (spec.size - Index3::Ones()).cast<double>().cwiseProduct(spec.spacing_mm);
}

/// A vessel in voxels of the reference image. Straight ends run along an axis of the image, so that the
/// vessel meets the border at a right angle.
struct VesselPlan {
  std::vector<Vec3> controls;
  double start_taper = 0;  ///< 0: radius_mm, 1: end_radius_mm.
  double end_taper = 1;
  Vec3 attach_near =
      Vec3::Zero();  ///< Begins at the parent's axis point nearest to this; unused for the parent.
};

struct VesselTreePlan {
  VesselPlan parent;
  std::vector<VesselPlan> branches;
  Vec3 sac_near = Vec3::Zero();        ///< The sac sits at the parent's axis point nearest to this
  Vec3 sac_direction = Vec3::UnitZ();  ///< and is shifted this way
  double sac_shift = 1;                ///< by this many sac radii.
};

/// Parent: up from the bottom, forward (-y) along the cavernous part, round the front bend, back and up to
/// its end.
VesselTreePlan carotid_plan() {
  const Vec3 end(250, 262, 400);
  VesselTreePlan plan;
  plan.parent = {{{250, 300, -120},
                  {250, 300, -60},
                  {250, 300, 0},
                  {250, 300, 60},
                  {250, 300, 110},
                  {250, 292, 170},
                  {250, 240, 212},
                  {250, 180, 215},
                  {250, 120, 222},
                  {250, 78, 262},
                  {250, 92, 318},
                  {250, 150, 340},
                  {250, 215, 340},
                  {250, 258, 362},
                  end,
                  end,
                  end},
                 0.0,
                 0.4,
                 Vec3::Zero()};
  plan.branches.push_back({{{300, 260, 428},
                            {350, 252, 436},
                            {395, 258, 448},
                            {440, 262, 450},
                            {490, 262, 450},
                            {540, 262, 450},
                            {590, 262, 450}},
                           0.5,
                           0.9,
                           end});
  plan.branches.push_back({{{206, 256, 422},
                            {178, 232, 434},
                            {168, 202, 438},
                            {168, 190, 455},
                            {168, 190, 482},
                            {168, 190, 510},
                            {168, 190, 540},
                            {168, 190, 570},
                            {168, 190, 600}},
                           0.6,
                           0.95,
                           end});
  plan.branches.push_back({{{200, 84, 292},
                            {150, 96, 300},
                            {105, 104, 318},
                            {70, 106, 320},
                            {20, 106, 320},
                            {-30, 106, 320},
                            {-80, 106, 320}},
                           0.8,
                           1.0,
                           {250, 88, 290}});
  plan.sac_near = {250, 190, 214};
  plan.sac_direction = Vec3(1, 0, -0.3).normalized();
  plan.sac_shift = 0.857;
  return plan;
}

VesselTreePlan bifurcation_plan() {
  const Vec3 apex(88, 62, 66);
  VesselTreePlan plan;
  plan.parent = {{{84, 70, -60}, {84, 70, -30}, {84, 70, 0}, {84, 70, 20}, {86, 66, 44}, apex, apex, apex},
                 0.0,
                 0.2,
                 Vec3::Zero()};
  plan.branches.push_back(
      {{{64, 60, 77}, {46, 56, 88}, {26, 54, 94}, {4, 54, 94}, {-18, 54, 94}, {-40, 54, 94}},
       0.35,
       0.8,
       apex});
  plan.branches.push_back(
      {{{112, 64, 76}, {131, 68, 86}, {150, 70, 90}, {172, 70, 90}, {194, 70, 90}, {216, 70, 90}},
       0.5,
       1.0,
       apex});
  plan.sac_near = apex;
  plan.sac_direction = Vec3(0, 0.12, 1).normalized();
  plan.sac_shift = 1.0;
  return plan;
}

std::size_t nearest_point(const std::vector<AxisPoint>& axis, const Vec3& p) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < axis.size(); ++i)
    if ((axis[i].centre - p).squaredNorm() < (axis[nearest].centre - p).squaredNorm()) nearest = i;
  return nearest;
}

/// Points of the axis with a radius that changes evenly over the part inside the image.
std::vector<AxisPoint> taper(const std::vector<Vec3>& points, double start_radius, double end_radius,
                             const PhantomSpec& spec) {
  const Vec3 border = 0.5 * spec.spacing_mm;
  const Vec3 high = spec.size.cast<double>().cwiseProduct(spec.spacing_mm) - border;
  std::vector<double> length = {0};
  for (std::size_t i = 1; i < points.size(); ++i) {
    const bool inside =
        ((points[i] + border).array() >= 0).all() && (points[i].array() <= high.array()).all();
    length.push_back(length.back() + (inside ? (points[i] - points[i - 1]).norm() : 0.0));
  }
  std::vector<AxisPoint> axis;
  for (std::size_t i = 0; i < points.size(); ++i)
    axis.push_back({points[i], start_radius + (end_radius - start_radius) * length[i] / length.back()});
  return axis;
}

class VesselTreeBuilder {
 public:
  VesselTreeBuilder(const PhantomSpec& spec, const VesselTreePlan& plan)
      : spec_(spec),
        plan_(plan),
        scale_(scale_of(spec)),
        step_mm_(0.5 * std::min(scale_, spec.spacing_mm.minCoeff())) {
    // Half a voxel keeps the facets of a bend of radius 40 within a thousandth; a cap on the count keeps
    // queries quick.
    step_mm_ = std::max(step_mm_, scale_ / 8);
  }

  PhantomGeometry build() {
    PhantomGeometry geometry;
    geometry.vessels.push_back({make_axis(plan_.parent, nullptr), 0});
    const std::vector<AxisPoint> parent = geometry.vessels[0].axis;
    for (const VesselPlan& branch : plan_.branches) {
      const std::size_t at = nearest_point(parent, to_local(branch.attach_near));
      geometry.vessels.push_back({make_axis(branch, &parent[at].centre), at});
    }
    const AxisPoint& foot = parent[nearest_point(parent, to_local(plan_.sac_near))];
    geometry.sac = AxisPoint{foot.centre + plan_.sac_direction * (plan_.sac_shift * spec_.sac_radius_mm),
                             spec_.sac_radius_mm};
    std::vector<std::vector<AxisPoint>> axes;
    for (const Vessel& vessel : geometry.vessels) axes.push_back(vessel.axis);
    const auto body = std::make_shared<Union>(
        std::vector<ShapePointer>{std::make_shared<TubeTree>(axes),
                                  std::make_shared<Ball>(geometry.sac->centre, geometry.sac->radius)});
    geometry.materials.push_back({{1, 1, 1}, body, 0, nullptr, 0, std::nullopt});
    return geometry;
  }

 private:
  [[nodiscard]] Vec3 to_local(const Vec3& voxel) const {
    const Vec3 middle = 0.5 * (reference_of(spec_.kind).size - Index3::Ones()).cast<double>();
    return centre_of(spec_) + scale_ * (voxel - middle);
  }
  [[nodiscard]] double radius(double fraction) const {
    return spec_.radius_mm + fraction * (spec_.end_radius_mm - spec_.radius_mm);
  }

  /// Samples the plan; a branch starts at its parent's axis. Ends go on straight to beyond any border.
  [[nodiscard]] std::vector<AxisPoint> make_axis(const VesselPlan& plan, const Vec3* start) const {
    std::vector<Vec3> controls;
    if (start != nullptr) controls.assign(3, *start);
    for (const Vec3& control : plan.controls) controls.push_back(to_local(control));
    std::vector<Vec3> points = sample_spline(controls, step_mm_);
    const double far = spec_.size.cast<double>().cwiseProduct(spec_.spacing_mm).norm();
    const auto go_on = [&](const Vec3& from, const Vec3& towards) {
      return std::vector<Vec3>{from + (towards - from).normalized() * far};
    };
    if (start == nullptr)
      points.insert(points.begin(), go_on(points.front(), 2 * points.front() - points[1]).front());
    if (start != nullptr)
      points.push_back(go_on(points.back(), 2 * points.back() - points[points.size() - 2]).front());
    // The long straight ends are cut at many points so that a taper ends where the image does.
    return taper(subdivide(points), radius(plan.start_taper), radius(plan.end_taper), spec_);
  }
  [[nodiscard]] std::vector<Vec3> subdivide(const std::vector<Vec3>& points) const {
    std::vector<Vec3> fine = {points.front()};
    for (std::size_t i = 1; i < points.size(); ++i) {
      const int parts =
          std::max(1, static_cast<int>(std::ceil((points[i] - points[i - 1]).norm() / (8 * scale_))));
      for (int part = 1; part <= parts; ++part)
        fine.push_back(points[i - 1] + (points[i] - points[i - 1]) * (static_cast<double>(part) / parts));
    }
    return fine;
  }

  const PhantomSpec& spec_;
  const VesselTreePlan& plan_;
  double scale_;
  double step_mm_;
};

double ball_volume(double radius) {
  return 4.0 / 3.0 * pi * radius * radius * radius;
}

/// The nearest position between two voxels, so that a flat face there does not gain or lose a layer of
/// voxels.
Vec3 snap_to_voxel_face(const Vec3& p, const Vec3& spacing_mm) {
  const Vec3 faces = (p.cwiseQuotient(spacing_mm).array() - 0.5).round() + 0.5;
  return faces.cwiseProduct(spacing_mm);
}

/// A ball with a wall, and a block with rounded edges whose top face runs through the ball's centre: there
/// wall, block and background meet at 180, 90 and 90 degrees. The block is given in radii of the wall's outer
/// surface.
PhantomGeometry layered_geometry(const PhantomSpec& spec) {
  const double outer = spec.radius_mm + spec.wall_mm;
  const double rounding = 0.25 * outer;
  Vec3 ball_centre = centre_of(spec) + Vec3(0, 0, 0.2 * outer);
  const Vec3 block_high = snap_to_voxel_face(ball_centre + Vec3(1.55, 1.55, 0) * outer, spec.spacing_mm);
  const Vec3 block_low = snap_to_voxel_face(ball_centre - Vec3(1.55, 1.55, 1.4) * outer, spec.spacing_mm);
  ball_centre.z() = block_high.z();
  const Vec3 inner = 0.5 * (block_high - block_low) - Vec3::Constant(rounding);
  const auto ball = std::make_shared<Ball>(ball_centre, spec.radius_mm);
  const auto block = std::make_shared<RoundedBox>(0.5 * (block_low + block_high), inner, rounding);
  const Vec3 w = 2 * inner;
  const double block_volume = w.prod() + 2 * rounding * (w.x() * w.y() + w.y() * w.z() + w.z() * w.x()) +
                              pi * rounding * rounding * w.sum() + ball_volume(rounding);
  PhantomGeometry geometry;
  geometry.materials = {
      {{1, 1, 1}, ball, 0, nullptr, 0, ball_volume(spec.radius_mm)},
      {{2, 1, 2}, ball, spec.wall_mm, ball, 0, ball_volume(outer) - ball_volume(spec.radius_mm)},
      {{3, 1, 1}, block, 0, ball, spec.wall_mm, block_volume - 0.5 * ball_volume(outer)},
  };
  return geometry;
}

PhantomGeometry torus_geometry(const PhantomSpec& spec) {
  const Vec3 centre = centre_of(spec);
  const double ring = spec.ring_radius_mm;
  PhantomGeometry geometry;
  geometry.materials.push_back({{1, 1, 0},
                                std::make_shared<Torus>(centre, ring, spec.radius_mm),
                                0,
                                nullptr,
                                0,
                                2 * pi * pi * ring * spec.radius_mm * spec.radius_mm});
  constexpr int kPoints = 256;
  for (int i = 0; i <= kPoints; ++i) {
    const double turn = 2 * pi * (i % kPoints) / kPoints;
    geometry.closed_axis.push_back({centre + ring * Vec3(std::cos(turn), std::sin(turn), 0), spec.radius_mm});
  }
  return geometry;
}

[[noreturn]] void throw_out_of_range(const PhantomSpec& spec, std::string_view field, double value,
                                     double low, double high) {
  throw Error(
      ErrorKind::kUsage,
      fmt::format(
          "phantom {}: {} is {:.4g} mm but must lie in {:.4g} to {:.4g} mm for this image and its other "
          "radii; change it or the image's extent",
          phantom_kind_name(spec.kind), field, value, low, high));
}

void check_range(const PhantomSpec& spec, std::string_view field, double value, double low, double high) {
  constexpr double kSlack = 1e-9;
  if (!(value >= low * (1 - kSlack) && value <= high * (1 + kSlack)))
    throw_out_of_range(spec, field, value, low, high);
}

}  // namespace

void fill_defaults(PhantomSpec& spec) {
  const PhantomReference reference = reference_of(spec.kind);
  if ((spec.size.array() == 0).all()) spec.size = reference.size;
  if ((spec.spacing_mm.array() == 0).all()) spec.spacing_mm = Vec3::Constant(reference.spacing_mm);
  const double scale = scale_of(spec);
  const auto fill = [scale](double& value, double voxels) {
    if (value == 0) value = voxels * scale;
  };
  fill(spec.radius_mm, reference.radius);
  if (spec.end_radius_mm == 0 && reference.end_radius > 0)
    spec.end_radius_mm = spec.radius_mm * reference.end_radius / reference.radius;
  fill(spec.sac_radius_mm, reference.sac_radius);
  fill(spec.ring_radius_mm, reference.ring_radius);
  if (spec.wall_mm == 0 && spec.kind == PhantomKind::kLayered)
    spec.wall_mm = kUsualWall * spec.spacing_mm.maxCoeff();
}

void check_radii(const PhantomSpec& spec) {
  const double voxel = spec.spacing_mm.maxCoeff();
  const double scale = scale_of(spec);
  const double clearance = (3 + spec.noise_voxels) * voxel;
  const Vec3 extent = spec.size.cast<double>().cwiseProduct(spec.spacing_mm);
  switch (spec.kind) {
    case PhantomKind::kCarotid:
    case PhantomKind::kBifurcation: {
      const PhantomReference reference = reference_of(spec.kind);
      check_range(spec, "radius", spec.radius_mm, voxel, 1.4 * reference.radius * scale);
      check_range(spec, "end radius", spec.end_radius_mm, 0.75 * voxel, spec.radius_mm);
      check_range(spec, "sac radius", spec.sac_radius_mm, 1.5 * spec.radius_mm,
                  1.5 * reference.sac_radius * scale);
      break;
    }
    case PhantomKind::kLayered: {
      // Thinner than the diagonal of a voxel, the wall's voxels would let inside and outside touch.
      const double thinnest = 1.75 * voxel * (1 + spec.noise_voxels * WaveNoise::kSlope);
      check_range(spec, "wall", spec.wall_mm, thinnest, spec.radius_mm);
      const double room = std::min({extent.x() / 3.1, extent.y() / 3.1, extent.z() / 2.4});
      check_range(spec, "radius", spec.radius_mm, 3 * voxel, room - clearance - spec.wall_mm);
      break;
    }
    case PhantomKind::kSphere:
      check_range(spec, "radius", spec.radius_mm, voxel, 0.5 * extent.minCoeff() - clearance);
      break;
    case PhantomKind::kTorus: {
      check_range(spec, "radius", spec.radius_mm, voxel, 0.5 * extent.z() - clearance);
      check_range(spec, "ring radius", spec.ring_radius_mm, spec.radius_mm + clearance,
                  0.5 * extent.head<2>().minCoeff() - spec.radius_mm - clearance);
      break;
    }
  }
}

PhantomGeometry make_geometry(const PhantomSpec& resolved) {
  switch (resolved.kind) {
    case PhantomKind::kCarotid:
      return VesselTreeBuilder(resolved, carotid_plan()).build();
    case PhantomKind::kBifurcation:
      return VesselTreeBuilder(resolved, bifurcation_plan()).build();
    case PhantomKind::kLayered:
      return layered_geometry(resolved);
    case PhantomKind::kTorus:
      return torus_geometry(resolved);
    case PhantomKind::kSphere:
      break;
  }
  PhantomGeometry geometry;
  geometry.materials.push_back({{1, 1, 1},
                                std::make_shared<Ball>(centre_of(resolved), resolved.radius_mm),
                                0,
                                nullptr,
                                0,
                                ball_volume(resolved.radius_mm)});
  return geometry;
}

}  // namespace lumesh::image
