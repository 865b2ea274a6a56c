#include "lumesh/stages/vessel_ends.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/error.hpp"

namespace lumesh {
namespace {

/// Nothing where nothing is longer than wide.
Polylines lines_in(const LabelImage& image, const Context& context) {
  Context quiet;  // What it warns of, other stages say.
  if (context.cancelled()) return {};
  try {
    return extract_centerline(image, {}, quiet);
  } catch (const Error&) {
    return {};
  }
}

/// A vessel is a good deal longer than wide.
bool is_vessel(const Polylines& lines, const std::vector<std::uint32_t>& line) {
  constexpr double kRadii = 2;
  double length_mm = 0, radius_mm = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    radius_mm = std::max(radius_mm, lines.scalars.at("radius")[line[i]]);
    if (i > 0) length_mm += (lines.points[line[i]] - lines.points[line[i - 1]]).norm();
  }
  return length_mm > kRadii * radius_mm;
}

/// Whether a branch leaves another line there.
bool is_on_another(const Polylines& lines, const std::vector<std::uint32_t>& line, std::uint32_t tip) {
  const double near_mm = 0.5 * lines.scalars.at("radius")[tip];
  return std::any_of(lines.lines.begin(), lines.lines.end(), [&](const auto& other) {
    return &other != &line && std::any_of(other.begin(), other.end(), [&](std::uint32_t p) {
      return (lines.points[p] - lines.points[tip]).norm() < near_mm;
    });
  });
}

bool is_at_opening(const Vec3& place, double radius_mm, const Opening& opening) {
  const Vec3 off = place - opening.centre_mm;
  // Beyond it is the stump of a vessel that was cut.
  return off.dot(opening.normal) > -(radius_mm + opening.voxel_mm) &&
         off.norm() < 2 * (radius_mm + opening.radius_mm());
}

}  // namespace

std::vector<VesselEnd> vessel_ends(const Polylines& lines, double least_radius_mm,
                                   std::span<const Opening> openings) {
  std::vector<VesselEnd> ends;
  const auto look_at = [&](std::uint32_t tip) {
    const Vec3& place = lines.points[tip];
    const double radius_mm = lines.scalars.at("radius")[tip];
    const bool is_open = std::any_of(openings.begin(), openings.end(), [&](const Opening& opening) {
      return is_at_opening(place, radius_mm, opening);
    });
    if (!is_open && radius_mm >= least_radius_mm) ends.push_back({radius_mm, place});
  };
  for (const auto& line : lines.lines) {
    if (line.size() < 2 || line.front() == line.back() || !is_vessel(lines, line)) continue;
    for (const std::uint32_t tip : {line.front(), line.back()})
      if (!is_on_another(lines, line, tip)) look_at(tip);
  }
  std::stable_sort(ends.begin(), ends.end(),
                   [](const VesselEnd& a, const VesselEnd& b) { return a.radius_mm > b.radius_mm; });
  return ends;
}

std::vector<VesselEnd> vessel_ends(const LabelImage& image, std::span<const Opening> openings,
                                   Context& context) {
  return vessel_ends(lines_in(image, context), image.frame().spacing_mm.maxCoeff(), openings);
}

std::string dead_end_warning(std::span<const VesselEnd> ends) {
  if (ends.empty()) return "";
  const bool is_one = ends.size() == 1;
  return fmt::format(
      "{} inside the image and {} closed there, {} {:.3g} mm in radius; to open it: cut_at = [[{}]] in "
      "[input]",
      is_one ? "1 vessel ends" : fmt::format("{} vessels end", ends.size()), is_one ? "is" : "are",
      is_one ? "about" : "the widest", ends.front().radius_mm, cut_place_text(ends.front()));
}

std::string cut_place_text(const VesselEnd& end) {
  const Vec3 p = end.place_mm + Vec3::Zero();  // No -0.
  return fmt::format("{:.6g},{:.6g},{:.6g}", p.x(), p.y(), p.z());
}

std::string closed_vessel_warning(const LabelImage& image, std::span<const Opening> openings,
                                  Context& context) {
  if (!openings.empty()) return "";
  const std::vector<VesselEnd> ends = vessel_ends(image, openings, context);
  if (ends.empty()) return "";
  return kNoOpenings + fmt::format("{} {} inside: cut {} square with `cut_at` {} (lumesh info lists all)",
                                   ends.size(), ends.size() == 1 ? "ends" : "end",
                                   ends.size() == 1 ? "it" : "the widest", cut_place_text(ends.front()));
}

}  // namespace lumesh
