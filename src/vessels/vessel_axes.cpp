#include "lumesh/vessels/vessel_axes.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <numbers>
#include <optional>
#include <utility>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/geometry/cut_part.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/surface/shells.hpp"

namespace lumesh {
namespace {

/// A vessel is a good deal longer than wide.
bool is_vessel(const Polylines& lines, const std::vector<std::uint32_t>& line) {
  constexpr double kRadii = 2;
  double radius_mm = 0;
  for (const std::uint32_t p : line) radius_mm = std::max(radius_mm, lines.scalars.at("radius")[p]);
  return length_mm(lines, line) > kRadii * radius_mm;
}

/// Whether a branch leaves another line there.
bool is_on_another(const Polylines& lines, const std::vector<std::uint32_t>& line, std::uint32_t tip) {
  const double near_mm = 0.5 * lines.scalars.at("radius")[tip];
  return std::ranges::any_of(lines.lines, [&](const auto& other) {
    return &other != &line && std::ranges::any_of(other, [&](std::uint32_t p) {
      return (lines.points[p] - lines.points[tip]).norm() < near_mm;
    });
  });
}

template <class Extract>
Polylines axes_or_none(const Extract& extract) {
  Context quiet;
  try {
    return extract(quiet);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kBadInput) throw;
    return {};
  }
}

/// Appends lines; numbers of branches go on.
void append_lines(const Polylines& lines, Polylines& all) {
  const auto first = static_cast<std::uint32_t>(all.points.size());
  const auto branches = static_cast<double>(all.lines.size());
  all.points.insert(all.points.end(), lines.points.begin(), lines.points.end());
  for (std::vector<std::uint32_t> line : lines.lines) {
    for (std::uint32_t& point : line) point += first;
    all.lines.push_back(std::move(line));
  }
  for (const auto& [name, values] : lines.scalars)
    for (const double value : values)
      all.scalars[name].push_back(name == "branch" ? value + branches : value);
}

/// A piece of an image within the box around it, which ends at the image's border where the piece does.
LabelImage piece_alone(const LabelImage& image, const VoxelComponent& piece) {
  const ImageFrame& whole = image.frame();
  const Index3 low = (piece.box.low - Index3::Ones()).cwiseMax(0);
  const Index3 high = (piece.box.high + Index3::Ones()).cwiseMin(whole.size);
  ImageFrame frame = whole;
  frame.size = high - low;
  frame.origin_mm = whole.to_physical(low.cast<double>());
  LabelImage alone(frame, image.values());
  for (int k = low.z(); k < high.z(); ++k)
    for (int j = low.y(); j < high.y(); ++j)
      for (int i = low.x(); i < high.x(); ++i) alone.at(Index3(i, j, k) - low) = image.at({i, j, k});
  keep_component_of(alone, piece.first - low, ComponentScope::kUnion);
  return alone;
}

/// The triangles of the boundary of each vessel that stands alone, with the cavities in it.
std::vector<MixedMesh> pieces_of(const MixedMesh& mesh) {
  TriangleMesh turned{mesh.points, {}, {}};
  for_each_patch_triangle(mesh.view(), [&](const Cell<3>& triangle, std::int32_t patch) {
    const auto number = static_cast<std::size_t>(patch);
    if (number < mesh.info.patches.size() && mesh.info.patches[number].kind == PatchKind::kInterface) return;
    turned.triangles.push_back(triangle);
    turned.patches.push_back(patch);
  });
  const surfaces::Parts parts = surfaces::turn_alike(turned);
  const std::vector<surfaces::Shell> shells = surfaces::shells_of(turned.points, turned.triangles, parts);
  std::vector<Box3> boxes(parts.count);
  for (std::size_t t = 0; t < turned.triangles.size(); ++t)
    for (const std::uint32_t v : turned.triangles[t]) boxes[parts.of_triangle[t]].extend(turned.points[v]);
  std::vector<MixedMesh> pieces;
  for (std::uint32_t outer = 0; outer < parts.count; ++outer) {
    if (shells[outer].depth % 2 != 0) continue;
    MixedMesh& piece = pieces.emplace_back();
    piece.points = turned.points;
    piece.info = mesh.info;
    for (std::size_t t = 0; t < turned.triangles.size(); ++t) {
      const std::uint32_t part = parts.of_triangle[t];
      const bool is_cavity =
          shells[part].depth == shells[outer].depth + 1 && boxes[outer].contains(boxes[part]);
      if (part != outer && !is_cavity) continue;
      piece.triangles.push_back(turned.triangles[t]);
      piece.triangle_patches.push_back(turned.patches[t]);
    }
  }
  return pieces;
}

/// Lines of all pieces; a line tells of those without one.
template <class Piece, class Extract>
Polylines lines_of_pieces(const std::vector<Piece>& pieces, const Extract& extract, Context& context) {
  Polylines all;
  std::size_t without = 0;
  for (const Piece& piece : pieces) {
    const Polylines lines = axes_or_none([&](Context& quiet) {
      quiet.stop_by(context.stop_token());
      return extract(piece, quiet);
    });
    if (lines.lines.empty()) ++without;
    append_lines(lines, all);
  }
  if (without > 0 && !all.lines.empty())
    context.warn(fmt::format("{} of {} that stand alone, not longer than wide, without an axis", without,
                             counted(pieces.size(), "piece")));
  return all;
}

/// Direction of a line at one of its points, over two radii; without its ends, which bend into the corners of
/// oblique tips. Before these it is that of the parabola over the next two radii.
Vec3 direction_at(const Polylines& lines, const std::vector<std::uint32_t>& line, std::size_t at) {
  constexpr std::size_t kTip = 2, kHalf = 4;  // Points are a quarter of a radius apart.
  constexpr double kMinCosine = 0.97;         // 14 degrees: a line turns more at a fork.
  const std::size_t first = std::min(kTip, (line.size() - 1) / 3), last = line.size() - 1 - first;
  const std::size_t half = std::min(kHalf, (last - first) / 2);
  const std::size_t middle = std::clamp(at, first + half, last - half);
  // Least squares in c k^2 + b k + a, of which c; b is the chord's.
  const auto reach = static_cast<double>(std::max<std::size_t>(1, half));
  const double mean = reach * (reach + 1) / 3;  // Of the k^2.
  Vec3 bend = Vec3::Zero();
  double squares = 0;
  for (std::size_t i = middle - half; i <= middle + half; ++i) {
    const double k = static_cast<double>(i) - static_cast<double>(middle);
    bend += (k * k - mean) * lines.points[line[i]];
    squares += (k * k - mean) * (k * k - mean);
  }
  const double beyond = static_cast<double>(at) - static_cast<double>(middle);
  const Vec3 chord = (lines.points[line[middle + half]] - lines.points[line[middle - half]]) / (2 * reach);
  const Vec3 there = squares > 0 ? Vec3(chord + 2 * beyond / squares * bend) : chord;
  return there.normalized().dot(chord.normalized()) < kMinCosine ? chord : there;
}

/// The vessel that the place is the fewest radii off.
AxisPlace nearest_axis(const Polylines& lines, const Vec3& place_mm) {
  AxisPlace nearest;
  for (const auto& line : lines.lines) {
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const Vec3 &a = lines.points[line[i]], &b = lines.points[line[i + 1]];
      const double along = share_along_segment(place_mm, a, b);
      const Vec3 foot = a + along * (b - a);
      const std::size_t at = along < 0.5 ? i : i + 1;
      const double radius_mm = lines.scalars.at("radius")[line[at]];
      const double off_radii = (place_mm - foot).norm() / radius_mm;
      if (off_radii < nearest.off_radii)
        nearest = {off_radii, radius_mm, {foot, direction_at(lines, line, at)}, radius_mm};
    }
  }
  return nearest;
}

/// The place on a line so far from its end; none where it is not as long.
std::optional<Vec3> place_up(const Polylines& lines, const std::vector<std::uint32_t>& from_end,
                             const LocalLength& length) {
  const std::vector<double>& radius = lines.scalars.at("radius");
  const std::vector<double> lengths_mm = lengths_along(lines, from_end);
  double lacking_mm = length.in_mm(radius[from_end[0]]);
  for (std::size_t i = 1; i < from_end.size(); ++i) {
    const Vec3 &before = lines.points[from_end[i - 1]], &at = lines.points[from_end[i]];
    const double beyond_mm = lengths_mm[i] - length.in_mm(radius[from_end[i]]);
    if (beyond_mm >= 0) return before + lacking_mm / (lacking_mm + beyond_mm) * (at - before);
    lacking_mm = -beyond_mm;
  }
  return std::nullopt;
}

/// The plane there with its normal towards the end that is cut off.
CutPlane towards_end(const AxisPlace& place, const Vec3& end) {
  CutPlane plane = place.across;
  plane.normal.normalize();
  if (plane.height(end) < 0) plane.normal = -plane.normal;
  return plane;
}

/// Has sections up to half as wide again as a vessel's pass.
void allow_sections_of(double vessel_mm2, double max_widening, AxisPlace& place) {
  constexpr double kMaxOfVessel = 1.5;  // A fork begins with less than two vessels.
  place.vessel_mm2 = vessel_mm2;
  place.section_radius_mm =
      std::max(place.radius_mm, circle_radius(kMaxOfVessel / max_widening * vessel_mm2));
}

/// Turns the plane at a place square to the axis there, by its line and by sections. @return  Whether the
/// direction can be told; the plane stays where not.
bool turn_square(AxisPlace& place, const AxisDirection& by_sections) {
  const std::optional<Vec3> axis = axis_of_both(place.across.normal, by_sections);
  if (axis) place.across.normal = *axis;
  return axis.has_value();
}

void turn_square_or_throw(AxisPlace& place, const AxisAtPlace& axis_at_place) {
  if (!turn_square(place, axis_at_place(place)))
    throw Error(ErrorKind::kBadInput,
                "the direction of its axis cannot be told at " + place_text(place.across.point_mm) +
                    ", where vessels join, bend sharply or are thin; cut it with `cut_plane`");
}

/// Cuts off one end after the other.
class EndCutting {
 public:
  EndCutting(const Polylines& lines, const EndCuts& how, const std::vector<CutPlane>& before)
      : lines_(lines), how_(how), before_(before) {}

  /// Cuts a line's first end off. @return  What to say of the cut, or nothing.
  /// @throws Error{kBadInput} if it cannot be.
  std::string cut(const std::vector<std::uint32_t>& from_end) const {
    const Vec3& end = lines_.points[from_end.front()];
    AxisPlace found = place_before(from_end, how_.length);
    const double asked_mm = found.across.height(end);
    double min_mm = shape_at(end, found).depth_mm;
    if (min_mm > asked_mm) found = place_before(from_end, {min_mm});
    turn_square_or_throw(found, how_.axis_at_place);
    const EndShape shape = shape_at(end, found);
    if (shape.depth_mm > std::max(min_mm, asked_mm)) {  // It reaches farther back along that direction.
      min_mm = shape.depth_mm;
      found = place_before(from_end, {min_mm});
      turn_square_or_throw(found, how_.axis_at_place);
    }
    allow_sections_of(shape.section_mm2, kMaxWideningAtEnds, found);
    how_.cut(found);
    if (min_mm <= asked_mm) return "";
    return fmt::format("is cut {:.3g} mm before it, not {:.3g} mm: the vessel is cut off obliquely there",
                       min_mm, asked_mm);
  }

 private:
  /// The place so far before the end, its plane's normal towards the end.
  [[nodiscard]] AxisPlace place_before(const std::vector<std::uint32_t>& from_end,
                                       const LocalLength& from_tip) const {
    const std::optional<Vec3> place = place_up(lines_, from_end, from_tip);
    if (!place) throw Error(ErrorKind::kBadInput, "its vessel is not as long");
    AxisPlace found = axis_at(lines_, *place, before_);
    found.across = towards_end(found, lines_.points[from_end.front()]);
    return found;
  }
  [[nodiscard]] EndShape shape_at(const Vec3& end, const AxisPlace& place) const {
    return how_.shape_of(end, place.across.normal, place.radius_mm);
  }

  const Polylines& lines_;
  const EndCuts& how_;
  const std::vector<CutPlane>& before_;
};

}  // namespace

std::vector<std::vector<std::uint32_t>> lines_from_ends(const Polylines& lines) {
  std::vector<std::vector<std::uint32_t>> from_ends;
  for (const auto& line : lines.lines) {
    if (line.size() < 2 || line.front() == line.back() || !is_vessel(lines, line)) continue;
    const std::vector<std::uint32_t> reversed(line.rbegin(), line.rend());
    for (const auto* from_tip : {&line, &reversed})
      if (!is_on_another(lines, line, from_tip->front())) from_ends.push_back(*from_tip);
  }
  return from_ends;
}

std::vector<double> lengths_along(const Polylines& lines, std::span<const std::uint32_t> line) {
  std::vector<double> lengths_mm(line.size(), 0);
  for (std::size_t i = 1; i < line.size(); ++i)
    lengths_mm[i] = lengths_mm[i - 1] + (lines.points[line[i]] - lines.points[line[i - 1]]).norm();
  return lengths_mm;
}

Polylines axes_if_any(const LabelImage& image, std::span<const CutPlane> cuts) {
  return axes_or_none([&](Context& quiet) { return extract_centerline(image, cuts, {}, quiet); });
}

Polylines axes_of_vessels(const LabelImage& image, std::span<const CutPlane> cuts,
                          const CenterlineOptions& options, Context& context) {
  constexpr std::size_t kSpeck = 64;  // Voxels.
  std::vector<VoxelComponent> pieces = voxel_components(image, ComponentScope::kUnion);
  if (pieces.size() > 1) {
    std::erase_if(pieces, [](const VoxelComponent& piece) { return piece.voxel_count < kSpeck; });
    Polylines all = lines_of_pieces(
        pieces,
        [&](const VoxelComponent& piece, Context& quiet) {
          return extract_centerline(piece_alone(image, piece), cuts, options, quiet);
        },
        context);
    if (!all.lines.empty()) return all;
  }
  return extract_centerline(image, cuts, options, context);
}

Polylines axes_of_vessels(const MixedMesh& mesh, const CenterlineOptions& options, Context& context) {
  const std::vector<MixedMesh> pieces = pieces_of(mesh);
  if (pieces.size() > 1) {
    Polylines all = lines_of_pieces(
        pieces,
        [&](const MixedMesh& piece, Context& quiet) {
          return extract_centerline(piece.view(), options, quiet);
        },
        context);
    if (!all.lines.empty()) return all;
  }
  return extract_centerline(mesh.view(), options, context);
}

AxisPlace axis_at(const Polylines& lines, const Vec3& place, std::span<const CutPlane> before) {
  const AxisPlace found = nearest_axis(lines, place);
  if (found.off_radii > 2)
    throw Error(
        ErrorKind::kBadInput,
        fmt::format(
            "no vessel runs at {}: the nearest axis is {:.2g} radii away; lumesh centerline writes the axes",
            place_text(place), found.off_radii));
  const Vec3& foot = found.across.point_mm;
  const bool is_gone = std::ranges::any_of(before, [&](const CutPlane& plane) {
    return plane.is_bounded() && (plane.beyond_mm(foot) > 0 || plane.beyond_mm(place) > 0);
  });
  if (is_gone)
    throw Error(ErrorKind::kBadInput, "the vessel at " + place_text(place) + " is cut off already");
  return found;
}

AxisPlace square_axis_at(const Polylines& lines, const Vec3& place, std::span<const CutPlane> before,
                         const AxisAtPlace& axis_at_place) {
  AxisPlace found = axis_at(lines, place, before);
  found.across.normal.normalize();
  const AxisDirection by_sections = axis_at_place(found);
  found.is_doubtful = !turn_square(found, by_sections);
  allow_sections_of(by_sections.section_mm2, kMaxWideningAtPlaces, found);
  return found;
}

std::vector<Vec3> cut_ends(const Polylines& lines, const EndCuts& how, const std::vector<CutPlane>& before,
                           const Context& context) {
  const EndCutting cutting(lines, how, before);
  std::vector<Vec3> ends;
  for (const std::vector<std::uint32_t>& from_end : lines_from_ends(lines)) {
    if (!how.is_end(from_end.front())) continue;
    ends.push_back(lines.points[from_end.front()]);
    const std::string end =
        fmt::format("{}: the end at {} ", option_name("clip_ends"), place_text(ends.back()));
    try {
      const std::string note = cutting.cut(from_end);
      if (!note.empty()) context.warn(end + note);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kBadInput) throw;
      context.warn(end + "stays: " + error.what());
    }
  }
  return ends;
}

std::string doubt_about_cut(const AxisPlace& place, double section_mm2) {
  constexpr double kWide = 1.5;
  const double of_vessel = std::max(std::numbers::pi * place.radius_mm * place.radius_mm, place.vessel_mm2);
  const double radius_mm = circle_radius(of_vessel);
  const std::string cut = "the cut at " + place_text(place.across.point_mm);
  if (section_mm2 > kWide * of_vessel)
    return section_text(cut, section_mm2, of_vessel, radius_mm) + "look whether it forks or bulges there";
  if (!place.is_doubtful) return "";
  return cut +
         " may be oblique: the direction of the axis cannot be told there, where vessels join, bend "
         "sharply or are thin; cut elsewhere, or with `cut_plane`";
}

}  // namespace lumesh
