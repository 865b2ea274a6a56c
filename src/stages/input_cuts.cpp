#include "lumesh/stages/input_cuts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <span>

#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/domain/local_volumes.hpp"
#include "lumesh/domain/vessel_cut.hpp"
#include "lumesh/field/label_field.hpp"
#include "lumesh/geometry/cut_part.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/vessels/axis_sections.hpp"
#include "lumesh/vessels/opening_sections.hpp"
#include "lumesh/vessels/vessel_axes.hpp"

namespace lumesh {
namespace {

/// The nearest voxel of the object, if one is near.
std::optional<Index3> object_voxel_near(const LabelImage& image, const Vec3& place_mm) {
  constexpr int kReach = 3;
  const ImageFrame& frame = image.frame();
  const Vec3 at = frame.to_index(place_mm);
  if (!(at.array().abs() < 1e6).all()) return std::nullopt;
  const Index3 middle = at.array().round().cast<int>();
  std::optional<Index3> nearest;
  double nearest_mm = std::numeric_limits<double>::infinity();
  for (int k = -kReach; k <= kReach; ++k)
    for (int j = -kReach; j <= kReach; ++j)
      for (int i = -kReach; i <= kReach; ++i) {
        const Index3 v = middle + Index3(i, j, k);
        if (!frame.contains(v) || image.at(v) == 0) continue;
        const double off_mm = (frame.to_physical(v.cast<double>()) - place_mm).norm();
        if (off_mm < nearest_mm) nearest = v, nearest_mm = off_mm;
      }
  return nearest;
}

/// The axes of the piece that a voxel belongs to.
Polylines axes_of_piece(LabelImage image, const Index3& voxel) {
  keep_component_of(image, voxel, ComponentScope::kUnion);
  Context quiet;
  return extract_centerline(image, {}, quiet);
}

/// The direction of axes by sections of an image that planes cut.
AxisAtPlace axes_by_voxels(const LabelImage& image, const std::vector<CutPlane>& planes) {
  return [&image, &planes](const AxisPlace& at) {
    const SectionOf section_of = [&](const CutPlane& plane, double reach_mm) {
      return section_of_voxels(image, planes, plane, reach_mm);
    };
    const ImageFrame& frame = image.frame();
    return axis_by_sections(section_of, at.across, at.radius_mm, frame.thickness_along_mm(at.across.normal),
                            deviation_of_centre_mm(at.radius_mm, frame.spacing_mm.maxCoeff()));
  };
}

CutPlane cut_at(LabelImage& image, const Vec3& place, const std::vector<CutPlane>& before,
                const Context& context) {
  const std::optional<Index3> voxel = object_voxel_near(image, place);
  if (!voxel)
    throw Error(ErrorKind::kBadInput, "no vessel runs at " + place_text(place) + ": all is background there");
  const AxisPlace found =
      square_axis_at(axes_of_piece(image, *voxel), place, before, axes_by_voxels(image, before));
  const CutVessel cut =
      cut_off_vessel(image, found.across, found.section_radius_mm, kMaxWideningAtPlaces, CutPart::kSmaller);
  const std::string doubt = doubt_about_cut(found, cut.section_mm2);
  if (!doubt.empty()) context.warn(doubt);
  return cut.plane;
}

/// How far before an end a cut square to the axis leaves the image's border: where the vessel is cut off
/// obliquely, its opening reaches back along its wall. The section across the axis is the opening's
/// projected.
EndShape shape_of_end(const ImageFrame& frame, std::span<const BorderSection> sections, const Vec3& end,
                      const Vec3& outward, double radius_mm) {
  constexpr double kAround = 1.5;  // Radii: what is farther from the axis is another vessel's.
  const double voxel_mm = frame.spacing_mm.maxCoeff();
  EndShape shape;
  for (const BorderSection& section : sections) {
    const bool is_at_end = std::ranges::any_of(
        section.centres_mm, [&](const Vec3& p) { return (p - end).norm() < radius_mm + voxel_mm; });
    if (!is_at_end) continue;
    for (const Vec3& p : section.centres_mm) {
      const Vec3 off = p - end;
      const double before_mm = -off.dot(outward);
      if ((off + before_mm * outward).norm() < kAround * radius_mm + voxel_mm)
        shape.depth_mm = std::max(shape.depth_mm, before_mm);
    }
    shape.section_mm2 =
        std::max(shape.section_mm2, section.area_mm2() * std::abs(section.normal.dot(outward)));
  }
  if (shape.depth_mm > 0) shape.depth_mm += 1.5 * frame.thickness_along_mm(outward);
  return shape;
}

/// Cuts the ends of the piece that a voxel belongs to.
/// @return  Where these are; of none that is narrower than a voxel.
std::vector<Vec3> clip_piece(LabelImage& image, const Index3& voxel, const LocalLength& length,
                             std::vector<CutPlane>& planes, Context& context) {
  const Polylines lines = axes_of_piece(image, voxel);
  const double voxel_mm = image.frame().spacing_mm.maxCoeff();
  const auto is_wide = [&](std::uint32_t tip) { return lines.scalars.at("radius")[tip] >= voxel_mm; };
  const auto cut = [&](const AxisPlace& at) {
    const CutVessel made =
        cut_off_vessel(image, at.across, at.section_radius_mm, kMaxWideningAtEnds, CutPart::kAbove);
    const std::string doubt = doubt_about_cut(at, made.section_mm2);
    if (!doubt.empty()) context.warn(doubt);
    planes.push_back(made.plane);
  };
  const std::vector<BorderSection> sections = border_sections(image, planes);
  const auto shape_of = [&](const Vec3& end, const Vec3& outward, double radius_mm) {
    return shape_of_end(image.frame(), sections, end, outward, radius_mm);
  };
  return cut_ends(lines, {length, is_wide, shape_of, axes_by_voxels(image, planes), cut}, planes, context);
}

/// Ends without an axis of their own are those that several vessels share, and those of small pieces.
void warn_of_sections_that_stay(const LabelImage& image, std::span<const CutPlane> planes,
                                std::span<const Vec3> tried, const Context& context) {
  for (const BorderSection& section : border_sections(image, planes)) {
    const Vec3 centre = section.centre_mm();
    const double near_mm = 2 * section.reach_mm();
    const bool is_known =
        std::ranges::any_of(tried, [&](const Vec3& end) { return (end - centre).norm() < near_mm; });
    if (section.is_wide() && !is_known)
      context.warn(
          fmt::format("{}: the section of {:.3g} mm² at {} stays: no axis of a vessel ends there; cut it "
                      "with `cut_plane`",
                      option_name("clip_ends"), section.area_mm2(), place_text(centre)));
  }
}

void clip_ends(LabelImage& image, const LocalLength& length, std::vector<CutPlane>& planes,
               Context& context) {
  constexpr std::size_t kMinVoxels = 50, kMaxPieces = 20;  // Each costs as much as the whole image.
  std::vector<Vec3> tried;
  std::size_t pieces = 0;
  for (const VoxelComponent& piece : voxel_components(image, ComponentScope::kUnion)) {  // Largest first.
    if (pieces > 0 && (piece.voxel_count < kMinVoxels || pieces == kMaxPieces)) break;
    try {
      const std::vector<Vec3> ends = clip_piece(image, piece.first, length, planes, context);
      tried.insert(tried.end(), ends.begin(), ends.end());
    } catch (const Error& error) {  // Nothing of it is longer than wide.
      if (error.kind() != ErrorKind::kBadInput || pieces == 0) throw;
    }
    ++pieces;
  }
  warn_of_sections_that_stay(image, planes, tried, context);
}

/// A plane that every voxel of the object lies before is a mistake.
void warn_of_planes_beyond(const LabelImage& image, std::span<const CutPlane> planes,
                           const Context& context) {
  const auto kept = [&](std::span<const CutPlane> by) {
    const std::vector<double> counts = count_kept_voxels(image, by);
    return std::accumulate(counts.begin(), counts.end(), 0.0);
  };
  if (planes.empty()) return;
  const double all = kept({});
  for (const CutPlane& plane : planes)
    if (kept({&plane, 1}) == all) context.warn(line_on_plane_beyond(plane));
}

}  // namespace

std::string line_on_plane_beyond(const CutPlane& plane) {
  return fmt::format("{}: the plane through {} with the normal {} cuts nothing off: all lies before it",
                     option_name("cut_planes"), place_text(plane.point_mm),
                     coordinates_text(plane.normal, 3));
}

std::string refusal_of_cut(const LabelImage& image, const Polylines& lines, std::span<const CutPlane> before,
                           const Vec3& place_mm) {
  try {
    const std::vector<CutPlane> planes(before.begin(), before.end());
    const AxisPlace found = square_axis_at(lines, place_mm, before, axes_by_voxels(image, planes));
    LabelImage cut = image;
    static_cast<void>(
        cut_off_vessel(cut, found.across, found.section_radius_mm, kMaxWideningAtPlaces, CutPart::kSmaller));
    return "";
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kBadInput) throw;
    return error.what();
  }
}

std::vector<CutPlane> cut_off(LabelImage& image, const InputCuts& cuts, Context& context) {
  std::vector<CutPlane> planes = cuts.planes;
  warn_of_planes_beyond(image, planes, context);
  for (const Vec3& place : cuts.places_mm) planes.push_back(cut_at(image, place, planes, context));
  if (cuts.ends) clip_ends(image, *cuts.ends, planes, context);
  return planes;
}

LabelImage read_cut_image(const std::string& path, const ImageSelection& selection, const InputCuts& cuts,
                          std::vector<CutPlane>& planes, Context& context) {
  LabelImage image = context.phase("read", [&] { return read_selected_image(path, selection, context); });
  planes = naming(path, [&] { return context.phase("cuts", [&] { return cut_off(image, cuts, context); }); });
  return image;
}

std::shared_ptr<const ImageDomain> extended_domain(LabelImage& image, std::vector<CutPlane>& planes,
                                                   const ImageDomain& domain,
                                                   std::span<const Opening> openings,
                                                   const ExtensionOptions& options, Context& context) {
  if (openings.empty())
    throw Error(ErrorKind::kBadInput, option_name("extend") +
                                          ": no vessel leaves the image; cut them with `cut_at` or "
                                          "`clip_ends`, which makes openings");
  for (const std::string& doubt :
       doubts_about_sections(image, domain.cut_planes(), openings, domain.field().fidelity()))
    context.warn(doubt);
  for (const std::string& doubt : doubts_about_shapes(image, domain, openings)) context.warn(doubt);
  if (const std::string doubt = doubt_about_volumes(image, domain); !doubt.empty()) context.warn(doubt);
  ExtendedImage extended =
      context.phase("extensions", [&] { return extend_openings(image, domain, openings, options); });
  for (const std::string& note : extended.notes) context.warn(note);
  image = std::move(extended.image);
  planes.assign(extended.domain->cut_planes().begin(), extended.domain->cut_planes().end());
  return extended.domain;
}

std::shared_ptr<const ImageDomain> domain_of_cut(LabelImage& image, std::vector<CutPlane>& planes,
                                                 const InputCuts& cuts, const LabelFieldOptions& field,
                                                 Context& context) {
  auto domain = context.phase("domain", [&] {
    return std::make_shared<const ImageDomain>(image, ImageDomainOptions{field, planes});
  });
  if (!cuts.extension.is_wanted()) return domain;
  const std::vector<Opening> openings = context.phase("openings", [&] { return find_openings(*domain); });
  return extended_domain(image, planes, *domain, openings, cuts.extension, context);
}

}  // namespace lumesh
