#include "lumesh/vessels/axis_sections.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/triangle.hpp"

namespace lumesh {
namespace {

/// Area, centre and second moments of a section, as sums over its parts.
struct SectionMoments {
  double area = 0;
  Vec2 first = Vec2::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();

  [[nodiscard]] Vec2 centre() const { return first / area; }
  [[nodiscard]] double length_over_width() const {
    const Eigen::Matrix2d about = second / area - centre() * centre().transpose();
    const double mean = 0.5 * about.trace();
    const double off = std::hypot(0.5 * (about(0, 0) - about(1, 1)), about(0, 1));
    return std::sqrt((mean + off) / std::max(mean - off, 1e-12 * mean));
  }
};

struct PlaneAxes {
  explicit PlaneAxes(const CutPlane& plane)
      : point(plane.point_mm), u(plane.normal.unitOrthogonal()), v(plane.normal.cross(u)) {}
  [[nodiscard]] Vec2 flat(const Vec3& x) const { return {u.dot(x - point), v.dot(x - point)}; }

  Vec3 point, u, v;
};

VesselSection endless_section(const Vec3& centre_mm) {
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  return {centre_mm, kEndless, kEndless};
}

VesselSection section_of_moments(const PlaneAxes& axes, const SectionMoments& sum) {
  const Vec2 centre = sum.centre();
  return {axes.point + centre.x() * axes.u + centre.y() * axes.v, sum.area, sum.length_over_width()};
}

/// The curve that a plane cuts out of a surface, in pieces of one triangle each.
class SurfaceSections {
 public:
  SurfaceSections(const MixedMesh& mesh, const CutPlane& plane, double reach_mm)
      : mesh_(mesh), axes_(plane), plane_(plane), reach_mm_(reach_mm) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) add(t);
  }

  /// The smallest closed curve around the plane's point.
  [[nodiscard]] std::optional<VesselSection> around_point() const {
    DisjointSets joined(edges_.size());
    for (const Piece& piece : pieces_) joined.merge(piece.ends[0], piece.ends[1]);
    struct Curve {
      SectionMoments sum;
      double turn = 0;
      double reach_mm = 0;
      bool is_of_end = false;
      std::map<std::uint32_t, int> ends;
    };
    std::map<std::uint32_t, Curve> curves;
    for (const Piece& piece : pieces_) {
      Curve& curve = curves[joined.find(piece.ends[0])];
      add_to(curve.sum, piece.from, piece.to);
      const double across = piece.from.x() * piece.to.y() - piece.from.y() * piece.to.x();
      curve.turn += std::atan2(across, piece.from.dot(piece.to));
      curve.is_of_end = curve.is_of_end || piece.is_of_end;
      curve.reach_mm = std::max(curve.reach_mm, piece.from.norm());
      for (const std::uint32_t end : piece.ends) ++curve.ends[end];
    }
    const Curve* best = nullptr;
    for (const auto& [first, curve] : curves) {
      if (std::abs(curve.turn) < std::numbers::pi) continue;
      if (best == nullptr || std::abs(curve.sum.area) < std::abs(best->sum.area)) best = &curve;
    }
    if (best == nullptr || best->is_of_end || best->sum.area == 0) return std::nullopt;
    if (best->reach_mm > reach_mm_) return endless_section(plane_.point_mm);
    if (std::ranges::any_of(best->ends, [](const auto& end) { return end.second != 2; })) return std::nullopt;
    SectionMoments sum = best->sum;
    if (sum.area < 0) sum = {-sum.area, -sum.first, -sum.second};
    return section_of_moments(axes_, sum);
  }

 private:
  struct Piece {
    Vec2 from, to;
    std::array<std::uint32_t, 2> ends;  // Numbers of the edges that it goes from and to.
    bool is_of_end = false;
  };

  void add(std::size_t t) {
    const Cell<3>& corners = mesh_.triangles[t];
    std::array<double, 3> height;
    for (std::size_t i = 0; i < 3; ++i) height[i] = plane_.height(mesh_.points[corners[i]]);
    const auto is_above = [&](std::size_t i) { return height[i % 3] >= 0; };
    if (is_above(0) == is_above(1) && is_above(1) == is_above(2)) return;
    Piece piece;
    for (std::size_t i = 0; i < 3; ++i) {
      if (is_above(i) == is_above(i + 1)) continue;
      const auto [low, high] = std::minmax(corners[i], corners[(i + 1) % 3]);
      const double below = plane_.height(mesh_.points[low]), above = plane_.height(mesh_.points[high]);
      const Vec3 x = mesh_.points[low] + below / (below - above) * (mesh_.points[high] - mesh_.points[low]);
      const auto number =
          edges_.try_emplace({low, high}, static_cast<std::uint32_t>(edges_.size())).first->second;
      (is_above(i) ? piece.from : piece.to) = axes_.flat(x);
      piece.ends[is_above(i) ? 0 : 1] = number;
    }
    const auto patch = static_cast<std::size_t>(mesh_.triangle_patches[t]);
    piece.is_of_end =
        patch < mesh_.info.patches.size() && mesh_.info.patches[patch].kind == PatchKind::kOpening;
    pieces_.push_back(piece);
  }

  /// Moments of the triangle between the plane's point and a piece.
  static void add_to(SectionMoments& sum, const Vec2& p, const Vec2& q) {
    const double area = 0.5 * (p.x() * q.y() - p.y() * q.x());
    sum.area += area;
    sum.first += area / 3 * (p + q);
    sum.second +=
        area / 12 * (2 * (p * p.transpose() + q * q.transpose()) + p * q.transpose() + q * p.transpose());
  }

  const MixedMesh& mesh_;
  PlaneAxes axes_;
  const CutPlane& plane_;
  double reach_mm_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edges_;
  std::vector<Piece> pieces_;
};

/// The voxel of the object in a plane's layer that is nearest to the plane's point, at most two away.
std::optional<Index3> voxel_of_plane(const LabelImage& image, const CutPlane& plane, double layer_mm) {
  const ImageFrame& frame = image.frame();
  const Vec3 at = frame.to_index(plane.point_mm);
  if (!(at.array().abs() < 1e6).all()) return std::nullopt;
  const Index3 middle = at.array().round().cast<int>(), reach = Index3::Constant(2);
  std::optional<Index3> nearest;
  double nearest_mm = std::numeric_limits<double>::infinity();
  for_each_place(middle - reach, middle + reach, [&](const Index3& v) {
    if (!frame.contains(v) || image.at(v) == 0) return;
    const Vec3 x = frame.to_physical(v.cast<double>());
    const double off_mm = (x - plane.point_mm).norm();
    if (std::abs(plane.height(x)) <= 0.5 * layer_mm && off_mm < nearest_mm) nearest = v, nearest_mm = off_mm;
  });
  return nearest;
}

bool is_at_border(const ImageFrame& frame, const Index3& v) {
  return (v.array() == 0).any() || (v.array() == (frame.size - Index3::Ones()).array()).any();
}

/// Sections parallel to a plane at even heights over it, as far as they are those of one vessel.
struct SectionRow {
  std::vector<double> heights_mm;
  std::vector<Vec3> centres_mm;
  double middle_mm2 = 0;   // Area of the section at height 0.
  bool is_joined = false;  // Ends where vessels join.

  [[nodiscard]] double length_mm() const { return heights_mm.back() - heights_mm.front(); }
};

/// Whether sections are parallel to the first, or turn with the vessel, by up to a radian.
enum class Planes : std::uint8_t { kParallel, kTurning };

class SectionWalk {
 public:
  SectionWalk(const SectionOf& section_of, const CutPlane& plane, double radius_mm, double step_mm,
              double chance_mm, Planes planes)
      : section_of_(section_of),
        plane_(plane),
        planes_(planes),
        reach_mm_(kReach * radius_mm),
        step_mm_(step_mm),
        max_length_(kMaxLength + kDeviations * chance_mm / radius_mm) {}

  [[nodiscard]] SectionRow run(int back, int ahead) {
    const auto middle = section_of_(plane_, reach_mm_);
    if (!middle) return row_;
    walk(*middle, -1, back);
    std::ranges::reverse(row_.heights_mm);
    std::ranges::reverse(row_.centres_mm);
    add(*middle, 0);
    row_.middle_mm2 = middle->area_mm2;
    walk(*middle, 1, ahead);
    return row_;
  }

 private:
  static constexpr double kReach = 5;  // Radii of the ball that fits: oval vessels are wide.
  static constexpr double kMaxLength = 1.25,
                          kDeviations = 3;    // Lengths over widths from one to the middle one.
  static constexpr double kMinCosine = 0.54;  // Of a radian.

  void add(const VesselSection& section, double height_mm) {
    row_.heights_mm.push_back(height_mm);
    row_.centres_mm.push_back(section.centre_mm);
  }

  [[nodiscard]] CutPlane plane_beyond(const Vec3& at, const Vec3& last_step, double height_mm) const {
    if (planes_ == Planes::kParallel) {
      const Vec3 guess = at + last_step;
      return {guess + (height_mm - plane_.height(guess)) * plane_.normal, plane_.normal};
    }
    const Vec3 along =
        last_step.isZero() ? Vec3(std::copysign(1, height_mm) * plane_.normal) : last_step.normalized();
    return {at + step_mm_ * along, along};
  }

  void walk(const VesselSection& middle, int sign, int count) {
    constexpr double kMaxArea = 1.5;  // From one section to the middle one.
    Vec3 at = middle.centre_mm, last_step = Vec3::Zero();
    for (int i = 1; i <= count; ++i) {
      const double height_mm = sign * i * step_mm_;
      const CutPlane plane = plane_beyond(at, last_step, height_mm);
      if (std::abs(plane.normal.dot(plane_.normal)) < kMinCosine) return;
      const auto found = section_of_(plane, reach_mm_);
      if (!found) return;
      const auto differs = [](double a, double b, double most) { return a > most * b || b > most * a; };
      // Where the vessel bends, sections parallel to the middle one are oblique.
      const double max_length = max_length_ * (found->centre_mm - at).norm() / step_mm_;
      if (differs(found->length_over_width, middle.length_over_width, max_length)) row_.is_joined = true;
      if (row_.is_joined || differs(found->area_mm2, middle.area_mm2, kMaxArea)) return;
      add(*found, height_mm);
      last_step = found->centre_mm - at;
      at = found->centre_mm;
    }
  }

  const SectionOf& section_of_;
  const CutPlane& plane_;
  Planes planes_;
  double reach_mm_, step_mm_, max_length_;
  SectionRow row_;
};

/// Slope of the centres at height 0 by least squares in powers of the height up to the second. The curvature
/// is shrunk by what chance explains of its square, three times over, as errors of neighbouring sections are
/// alike: a straight vessel of few voxels would lean. The error's part of the curvature has the share that is
/// kept, not its square, as it includes what the shrinking takes off a vessel that does bend.
struct FittedSlope {
  Vec3 slope = Vec3::Zero();
  double error = 0;  // Standard deviation of a component.
};

FittedSlope fitted_slope(const SectionRow& row, double chance_mm) {
  const auto count = static_cast<double>(row.heights_mm.size());
  double mean = 0, linear = 0, square = 0;
  for (const double h : row.heights_mm) mean += h / count;
  for (const double h : row.heights_mm) linear += (h - mean) * (h - mean);
  // Even steps: the parabola is orthogonal to the line.
  const auto bend_at = [&](double h) { return (h - mean) * (h - mean) - linear / count; };
  for (const double h : row.heights_mm) square += bend_at(h) * bend_at(h);
  Vec3 centre = Vec3::Zero(), slope = Vec3::Zero(), bend = Vec3::Zero();
  for (std::size_t i = 0; i < row.heights_mm.size(); ++i) {
    centre += row.centres_mm[i] / count;
    slope += (row.heights_mm[i] - mean) / linear * row.centres_mm[i];
    bend += bend_at(row.heights_mm[i]) / square * row.centres_mm[i];
  }
  double rest = 0;
  for (std::size_t i = 0; i < row.heights_mm.size(); ++i) {
    const double h = row.heights_mm[i];
    rest += (row.centres_mm[i] - centre - (h - mean) * slope - bend_at(h) * bend).squaredNorm();
  }
  const double variance = std::max(chance_mm * chance_mm, rest / (2 * (count - 3)));
  constexpr double kByChance = 6;  // Three times both parts of the curvature.
  const double of_bend = bend.squaredNorm() > 0 ? kByChance * variance / square / bend.squaredNorm() : 1;
  const double kept = std::max(0.0, 1 - of_bend);
  return {slope - 2 * mean * kept * bend,
          std::sqrt(variance * (1 / linear + 4 * mean * mean * kept / square))};
}

/// The direction square to which sections around a point have their centres.
/// @param plane  With a unit normal, to begin with.
AxisDirection settled_direction(const SectionOf& section_of, CutPlane plane, double radius_mm, double step_mm,
                                double chance_mm, Planes planes) {
  constexpr int kTurns = 6;
  constexpr double kBack = 2, kAhead = 1, kLeast = 1;  // Radii.
  constexpr int kLeastBack = 6, kLeastAhead = 3;       // Steps, for vessels of few voxels.
  constexpr std::size_t kLeastSections = 4;
  constexpr double kSettled = 0.003;  // Slope.
  // Radii of the section's circle: sections of a ball halve within 1.15 of its radii around the middle.
  constexpr double kLeastOfVessel = 1.4;
  using Doubt = AxisDirection::Doubt;
  const auto steps = [&](double radii) { return static_cast<int>(std::lround(radii * radius_mm / step_mm)); };
  const int back = std::max(kLeastBack, steps(kBack)), ahead = std::max(kLeastAhead, steps(kAhead));
  AxisDirection found;
  for (int turn = 0; turn < kTurns; ++turn) {
    const SectionRow row =
        SectionWalk(section_of, plane, radius_mm, step_mm, chance_mm, planes).run(back, ahead);
    if (row.heights_mm.size() < kLeastSections || row.length_mm() < kLeast * radius_mm) {
      if (planes == Planes::kTurning && turn > 0)
        return found;  // The first plane alone is too near to an end.
      return {row.is_joined ? Doubt::kJoined : Doubt::kShort};
    }
    const FittedSlope fit = fitted_slope(row, chance_mm);
    const double off = (fit.slope.normalized() - plane.normal).norm();
    const bool is_of_vessel = row.length_mm() >= kLeastOfVessel * circle_radius(row.middle_mm2);
    plane.normal = fit.slope.normalized();
    const double error = planes == Planes::kTurning ? fit.error : std::max(fit.error, off);
    found = {Doubt::kNone, plane.normal, error, is_of_vessel ? row.middle_mm2 : 0};
    if (off < kSettled) break;
  }
  return found;
}

}  // namespace

std::optional<VesselSection> section_of_voxels(const LabelImage& image, std::span<const CutPlane> cuts,
                                               const CutPlane& plane, double reach_mm) {
  const ImageFrame& frame = image.frame();
  const double layer_mm = frame.thickness_along_mm(plane.normal);
  const std::optional<Index3> first = voxel_of_plane(image, plane, layer_mm);
  if (!first) return std::nullopt;
  const PlaneAxes axes(plane);
  SectionMoments sum;
  std::vector<Index3> found = {*first};
  std::set<std::size_t> is_found = {frame.offset(*first)};
  for (std::size_t s = 0; s < found.size(); ++s) {
    const Index3 at = found[s];
    const Vec3 x = frame.to_physical(at.cast<double>());
    const Vec2 flat = axes.flat(x);
    const double layers = std::abs(plane.height(x)) / layer_mm;
    const auto is_beyond = [&](const CutPlane& cut) { return cut.beyond_mm(x) > 0; };
    if (layers < 0.75 && (is_at_border(frame, at) || std::ranges::any_of(cuts, is_beyond)))
      return std::nullopt;
    if (flat.norm() > reach_mm) return endless_section(plane.point_mm);
    const double area = (1 - layers) * frame.voxel_volume_mm3() / layer_mm;
    sum.area += area;
    sum.first += area * flat;
    sum.second += area * flat * flat.transpose();
    for (int axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1}) {
        const Index3 v = at + step * Index3::Unit(axis);
        if (!frame.contains(v) || image.at(v) == 0 || is_found.contains(frame.offset(v))) continue;
        if (std::abs(plane.height(frame.to_physical(v.cast<double>()))) >= layer_mm) continue;
        is_found.insert(frame.offset(v));
        found.push_back(v);
      }
  }
  return section_of_moments(axes, sum);
}

std::optional<VesselSection> section_of_surface(const MixedMesh& mesh, const CutPlane& plane,
                                                double reach_mm) {
  return SurfaceSections(mesh, plane, reach_mm).around_point();
}

AxisDirection axis_by_sections(const SectionOf& section_of, const CutPlane& guess, double radius_mm,
                               double layer_mm, double chance_mm) {
  constexpr double kStep = 0.25;     // Radii.
  constexpr double kMaxError = 0.1;  // Of the ones that turn: chance in vessels of 1.5 voxels.
  const CutPlane plane{guess.point_mm, guess.normal.normalized()};
  const double step_mm = std::max(kStep * radius_mm, layer_mm);
  const auto by = [&](Planes planes) {
    return settled_direction(section_of, plane, radius_mm, step_mm, chance_mm, planes);
  };
  const AxisDirection parallel = by(Planes::kParallel);
  if (axis_of_both(plane.normal, parallel)) return parallel;
  const AxisDirection turning = by(Planes::kTurning);
  return turning.doubt == AxisDirection::Doubt::kNone && turning.error < kMaxError ? turning : parallel;
}

std::optional<Vec3> axis_before_end(const MixedMesh& mesh, const Vec3& centre_mm, const Vec3& normal,
                                    double radius_mm) {
  constexpr double kFirst = 0.1, kStep = 0.25, kDepth = 2, kLeast = 1;  // Radii.
  constexpr double kMaxError = 0.1;                                     // Slope.
  const SectionOf section_of = [&](const CutPlane& plane, double reach_mm) {
    return section_of_surface(mesh, plane, reach_mm);
  };
  const CutPlane first{centre_mm - kFirst * radius_mm * normal, normal};
  const SectionRow row = SectionWalk(section_of, first, radius_mm, kStep * radius_mm, 0, Planes::kParallel)
                             .run(static_cast<int>(std::lround(kDepth / kStep)), 0);
  if (row.heights_mm.empty() || row.heights_mm.front() > -kLeast * radius_mm) return std::nullopt;
  const FittedSlope fit = fitted_slope(row, 0);
  return fit.error > kMaxError ? std::nullopt : std::optional<Vec3>(fit.slope.normalized());
}

std::optional<Vec3> axis_of_both(const Vec3& by_line, const AxisDirection& by_sections) {
  constexpr double kErrorOfLine = 0.04, kMaxError = 0.05, kMaxOff = 3;  // The last in standard deviations.
  using Doubt = AxisDirection::Doubt;
  if (by_sections.doubt == Doubt::kShort) return by_line;
  if (by_sections.doubt == Doubt::kJoined) return std::nullopt;
  const double off = (by_line - by_sections.unit).norm();
  if (off > kMaxOff * std::hypot(kErrorOfLine, by_sections.error))
    return by_sections.error > kMaxError ? std::nullopt : std::optional(by_sections.unit);
  const double of_line = by_sections.error * by_sections.error, of_sections = kErrorOfLine * kErrorOfLine;
  return Vec3(of_line * by_line + of_sections * by_sections.unit).normalized();
}

}  // namespace lumesh
