#include "lumesh/vessels/opening_sections.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "layer_squares.hpp"
#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/core/squares.hpp"
#include "section_changes.hpp"
#include "section_waists.hpp"
#include "shared_outlines.hpp"
#include "side_cuts.hpp"

namespace lumesh {
namespace {

constexpr double kAlike = 0.999;   // Cosine between normals of one direction.
constexpr double kFewFaces = 3.5;  // Of voxels: too few to tell the section of a vessel.

/// The sections on one side: the first or last layer along an axis, but what planes cut off of it.
void add_sections(const LabelImage& image, std::span<const CutPlane> cuts, int axis, bool is_last,
                  std::vector<BorderSection>& sections) {
  constexpr double kRounding = 1e-6;  // Voxels: these faces are in planes themselves.
  const ImageFrame& frame = image.frame();
  const LayerSquares grid(frame, axis, is_last);
  const std::size_t columns = grid.columns, count = grid.count;
  const int second = grid.layer_count() > 1 ? 1 : 0;
  const std::vector<std::uint32_t> part = connected_squares(
                                       columns, count,
                                       [&](std::size_t face) { return image.at(grid.voxel(face, 0)); }),
                                   next = connected_squares(columns, count, [&](std::size_t face) {
                                     return image.at(grid.voxel(face, second));
                                   });
  std::map<std::uint32_t, std::size_t> next_sizes;
  for (const std::uint32_t n : next) ++next_sizes[n];
  const auto edges_of = [&](std::size_t face) {
    const std::size_t column = face % columns;
    return static_cast<std::size_t>(column > 0 && part[face - 1] != part[face]) +
           static_cast<std::size_t>(column + 1 < columns && part[face + 1] != part[face]) +
           static_cast<std::size_t>(face >= columns && part[face - columns] != part[face]) +
           static_cast<std::size_t>(face + columns < count && part[face + columns] != part[face]);
  };
  std::map<std::uint32_t, BorderSection> by_part;
  for (std::size_t face = 0; face < count; ++face) {
    if (part[face] == 0) continue;
    const Index3 at = grid.voxel(face, 0);
    Vec3 index = at.cast<double>();
    index[axis] += is_last ? 0.5 : -0.5;
    const Vec3 centre_mm = frame.to_physical(index);
    const bool is_cut_off = std::ranges::any_of(cuts, [&](const CutPlane& cut) {
      return cut.beyond_mm(centre_mm) > kRounding * frame.spacing_mm.minCoeff();
    });
    if (is_cut_off) continue;
    BorderSection& section = by_part[part[face]];
    section.label = image.label_at(at);
    section.edge_count += edges_of(face);
    if (image.at(at) == image.at(grid.voxel(face, second)))
      section.next_parts.emplace(next[face], next_sizes[next[face]]);
    section.centres_mm.push_back(centre_mm);
    section.face_mm2 = frame.spacing_mm[grid.u] * frame.spacing_mm[grid.v];
    section.axis = axis, section.is_last = is_last;
    section.normal = frame.direction.col(axis) * (is_last ? 1 : -1);
  }
  for (auto& entry : by_part) sections.push_back(std::move(entry.second));
}

/// The opening that holds most faces of a section; none if none holds any.
std::optional<std::size_t> opening_of(const BorderSection& section, std::span<const Opening> openings) {
  std::optional<std::size_t> best;
  std::size_t most = 0;
  for (std::size_t i = 0; i < openings.size(); ++i) {
    const Opening& o = openings[i];
    if (o.label != section.label || !o.squares || o.normal.dot(section.normal) < kAlike) continue;
    const auto held = static_cast<std::size_t>(
        std::ranges::count_if(section.centres_mm, [&](const Vec3& p) { return o.squares->hold(p); }));
    if (held <= most) continue;
    most = held;
    best = i;
  }
  return best;
}

/// Figures of one opening by its voxels.
struct Voxels {
  double area_mm2 = 0, face_mm2 = 0;
  std::map<std::uint32_t, std::size_t> next_parts;  ///< Sections behind, one of which may be that of several.
  std::size_t edge_count = 0;                       ///< Edges around the faces.
  std::size_t sections = 0;                         ///< Of some faces.

  void add(const BorderSection& section) {
    area_mm2 += section.area_mm2();
    face_mm2 = section.face_mm2;
    next_parts.insert(section.next_parts.begin(), section.next_parts.end());
    edge_count += section.edge_count;
    if (section.is_wide()) ++sections;
  }
  /// Area in the next layer.
  [[nodiscard]] double next_area_mm2() const {
    double faces = 0;
    for (const auto& [part, count] : next_parts) faces += static_cast<double>(count);
    return face_mm2 * faces;
  }
  /// Whether voxels of a vessel with a section of this area can hardly be these ones.
  [[nodiscard]] bool contradict(double section_mm2) const {
    constexpr double kShare = 0.1, kVoxels = 0.7;
    // The other bound is the nearer one where the outline is short and the section changes little.
    constexpr double kLeastShare = 0.05, kChange = 0.1;
    const double change = std::abs(next_area_mm2() - area_mm2);
    return std::abs(section_mm2 - area_mm2) >
           std::min(kShare * area_mm2 + kVoxels * std::sqrt(area_mm2 * face_mm2),
                    kLeastShare * area_mm2 + chance_mm2(1) + kChange * change);
  }

  /// Whether the section grows by more than a quarter within a voxel: it is that of a wall along the border.
  [[nodiscard]] bool is_along_wall() const {
    constexpr double kGrowth = 0.25;
    return next_area_mm2() - area_mm2 > kGrowth * area_mm2 + chance_mm2(2);
  }
  /// By how much areas of sections, or their difference, are off by chance at most.
  [[nodiscard]] double chance_mm2(int sections_of_voxels) const {
    constexpr double kDeviations = 2.5;
    return kDeviations * std::sqrt(sections_of_voxels) * deviation_mm2();
  }
  [[nodiscard]] double deviation_mm2() const {
    return face_mm2 * deviation_of_count(static_cast<double>(edge_count));
  }

  /// Whether there are too few faces to tell the section of a vessel.
  [[nodiscard]] bool is_tiny() const { return area_mm2 < kFewFaces * face_mm2; }
};

/// Whether a section is that of a wall whose lumen is background: what other labels have of its hole is no
/// hole.
bool is_hollow_of_background(const Opening& opening, std::span<const Opening> openings) {
  if (!opening.is_hollow()) return false;
  auto filled = std::make_shared<OpeningSquares>(*opening.squares);
  for (const Opening& other : openings) {
    if (other.label == opening.label || !other.squares || !are_nearly_coplanar(opening, other)) continue;
    for (int row = 0; row < filled->rows; ++row)
      for (int column = 0; column < filled->columns; ++column)
        if (other.squares->hold(filled->centre_of(column, row)))
          filled->is_inside[filled->square(column, row)] = 1;
  }
  Opening all = opening;
  all.squares = filled;
  return all.is_hollow();
}

/// A side cut as find_side_cut() tells it; none for rims of walls, and for sections of a few voxels.
std::optional<SideCut> side_cut_of(const LabelImage& image, std::span<const CutPlane> cuts,
                                   const BorderSection& section, const Opening& opening) {
  if (!section.is_wide() || opening.is_rim) return std::nullopt;
  return find_side_cut(image, cuts, section);
}

/// A line on an opening that is no end of a vessel.
std::string doubt_of_side(const Opening& opening, const SideCut& cut) {
  return fmt::format(
      "{} at {}: what lies behind it {} within {:.3g} mm, so that the border of the image cuts {}, not the "
      "end of a vessel; cut vessels where they are whole with {} or {}, or take an image that holds all of "
      "it",
      opening.name, place_text(opening.centre_mm),
      cut.grows() ? fmt::format("grows by {:.0f} % or more", 100 * (cut.share - 1))
                  : fmt::format("shrinks to {:.0f} % of the opening", 100 * cut.share),
      cut.depth_mm,
      cut.grows() ? "the side of a bend or a sac, or a mouth"
                  : "through a sac, a vessel along its length, or before a throat",
      option_name("cut_at"), option_name("clip_ends"));
}

std::string doubt_of(const Opening& opening, const Voxels& voxels, std::span<const Opening> openings,
                     BoundaryFidelity fidelity) {
  if (voxels.sections > 1)
    return fmt::format(
        "{} at {} joins {} sections that are separate in the voxels; the image is too coarse there, or "
        "cut them apart with {}",
        opening.name, place_text(opening.centre_mm), voxels.sections, "`cut_plane`");
  if (is_hollow_of_background(opening, openings))
    return fmt::format(
        "{} at {} is the section of a wall whose lumen has no label: at the border its area may be a tenth "
        "off; give the lumen a label, or cut some voxels further in with {}",
        opening.name, place_text(opening.centre_mm), "`cut_plane`");
  if (!voxels.contradict(opening.area_mm2))
    return voxels.is_along_wall()
               ? fmt::format(
                     "{} at {} lies along the wall of a vessel, {:.0f} % larger one voxel further in: its "
                     "{:.4g} mm² are no section of the vessel; cut that with {} or {}",
                     opening.name, place_text(opening.centre_mm),
                     100 * (voxels.next_area_mm2() / voxels.area_mm2 - 1), opening.area_mm2,
                     option_name("cut_at"), option_name("clip_ends"))
               : "";
  const double off = opening.area_mm2 - voxels.area_mm2;
  return fmt::format(
      "{} at {} has {:.4g} mm², {:.0f} % {} than its {:.4g} mm² of voxel faces; cut it a few voxels "
      "further in with {}{}",
      opening.name, place_text(opening.centre_mm), opening.area_mm2, 100 * std::abs(off) / voxels.area_mm2,
      off > 0 ? "more" : "less", voxels.area_mm2, "`cut_plane`",
      fidelity == BoundaryFidelity::kExact ? "" : ", or try `boundary` exact");
}

/// A line for all of them, at least one.
std::string doubt_of_tiny(const std::vector<const Opening*>& tiny) {
  const bool is_one = tiny.size() == 1;
  return fmt::format("{} at {}{} {} 3 voxel faces or fewer, too few to tell the section of a vessel",
                     tiny.front()->name, place_text(tiny.front()->centre_mm),
                     is_one ? "" : fmt::format(" and {} more", tiny.size() - 1), is_one ? "has" : "have");
}

bool is_at_border(const ImageFrame& frame, const Opening& opening) {
  constexpr double kNear = 1e-3;  // Voxels.
  const Vec3 index = frame.to_index(opening.centre_mm);
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(frame.direction.col(axis).dot(opening.normal)) > kAlike)
      return std::abs(index[axis] + 0.5) < kNear || std::abs(index[axis] + 0.5 - frame.size[axis]) < kNear;
  return false;
}

/// Whether two openings in different faces of the image have parts of one edge.
bool meet_at_edge(const Opening& a, const Opening& b) {
  constexpr double kAcross = 0.1, kHalf = 0.5;  // Cosine; voxels.
  const double voxel_mm = std::max(a.voxel_mm, b.voxel_mm);
  if (a.label != b.label || std::abs(a.normal.dot(b.normal)) > kAcross) return false;
  if (a.box_mm.exteriorDistance(b.box_mm) > voxel_mm) return false;
  for (int row = 0; row < a.squares->rows; ++row)
    for (int column = 0; column < a.squares->columns; ++column) {
      const Vec3 x = a.squares->centre_of(column, row);
      if (!a.squares->hold(column, row) || b.normal.dot(b.centre_mm - x) > kHalf * voxel_mm) continue;
      if (b.squares->hold(x - kHalf * voxel_mm * a.normal)) return true;
    }
  return false;
}

/// A line on an opening whose area is likely to be off; none where values place the boundary, which hold it
/// to half a voxel from the border.
std::string doubt_of_change(const LabelImage& image, const Domain& domain, const Opening& opening,
                            const Voxels& voxels) {
  if (!image.crossings().empty() || !is_at_border(image.frame(), opening) || !(voxels.area_mm2 > 0))
    return "";
  const std::optional<SectionDoubt> doubt =
      doubtful_change(domain, opening, {voxels.area_mm2, voxels.deviation_mm2() / voxels.area_mm2});
  if (!doubt) return "";
  return fmt::format(
      "{} at {}: its section {} by {:.0f} % within the last two voxels before the border, where nothing "
      "beyond tells how it goes on; its area may be about {:.0f} % {}; cut it further in with {} 1r",
      opening.name, place_text(opening.centre_mm), doubt->growth > 0 ? "grows" : "shrinks",
      100 * std::abs(doubt->growth), 100 * std::abs(doubt->error),
      !doubt->has_sign   ? "off"
      : doubt->error > 0 ? "too large"
                         : "too small",
      option_name("clip_ends"));
}

/// Voxels of each opening; calls look_at(section, opening) for all sections, whose opening may be none.
template <class LookAt>
std::vector<Voxels> voxels_of(const LabelImage& image, std::span<const CutPlane> cuts,
                              std::span<const Opening> openings, const LookAt& look_at) {
  std::vector<Voxels> of_openings(openings.size());
  for (const BorderSection& section : border_sections(image, cuts)) {
    const std::optional<std::size_t> opening = opening_of(section, openings);
    if (opening) of_openings[*opening].add(section);
    look_at(section, opening);
  }
  return of_openings;
}

/// The openings that are worth a boundary condition.
std::vector<std::uint32_t> openings_at_border(const LabelImage& image, std::span<const Opening> openings) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t i = 0; i < openings.size(); ++i) {
    const Opening& o = openings[i];
    if (!o.is_rim && o.squares && o.area_mm2 > kFewFaces * o.voxel_mm * o.voxel_mm &&
        is_at_border(image.frame(), o))
      found.push_back(i);
  }
  return found;
}

/// A line for each vessel that leaves the image through an edge: each face has a part of its section.
std::vector<std::string> doubts_about_edges(const LabelImage& image, std::span<const Opening> openings) {
  const std::vector<std::uint32_t> at_border = openings_at_border(image, openings);
  DisjointSets sets(openings.size());
  for (const std::uint32_t a : at_border)
    for (const std::uint32_t b : at_border)
      if (a < b && meet_at_edge(openings[a], openings[b])) sets.merge(a, b);
  std::map<std::uint32_t, std::vector<std::string>> names;
  std::set<std::uint32_t> wide;  // From one face of the image to the opposite one, as tissue is.
  for (const std::uint32_t i : at_border) {
    names[sets.find(i)].push_back(openings[i].name);
    for (const std::uint32_t j : at_border)
      if (sets.find(i) == sets.find(j) && openings[i].normal.dot(openings[j].normal) < -0.5)
        wide.insert(sets.find(i));
  }
  std::vector<std::string> doubts;
  for (const auto& [first, parts] : names)
    if (parts.size() > 1 && !wide.contains(first))
      doubts.push_back(fmt::format(
          "{} and {} at {} are parts of one section, through an edge of the image: one vessel would have {} "
          "boundary conditions; cut it before the edge with {} or {}",
          fmt::join(std::span(parts).first(parts.size() - 1), ", "), parts.back(),
          place_text(openings[first].centre_mm), parts.size(), option_name("cut_at"),
          option_name("clip_ends")));
  return doubts;
}

}  // namespace

Vec3 BorderSection::centre_mm() const {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : centres_mm) sum += p;
  return sum / static_cast<double>(centres_mm.size());
}

double BorderSection::reach_mm() const {
  const Vec3 centre = centre_mm();
  double reach_mm = 0;
  for (const Vec3& p : centres_mm) reach_mm = std::max(reach_mm, (p - centre).norm());
  return reach_mm + std::sqrt(face_mm2);
}

std::vector<BorderSection> border_sections(const LabelImage& image, std::span<const CutPlane> cuts) {
  std::vector<BorderSection> sections;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool is_last : {false, true}) add_sections(image, cuts, axis, is_last, sections);
  return sections;
}

std::vector<std::string> doubts_about_sections(const LabelImage& image, std::span<const CutPlane> cuts,
                                               std::span<const Opening> openings, BoundaryFidelity fidelity) {
  std::vector<std::string> doubts, sides(openings.size());
  const auto look_at = [&](const BorderSection& section, std::optional<std::size_t> opening) {
    if (!section.is_wide()) return;
    if (!opening)
      doubts.push_back(fmt::format("the section of {} voxel faces of label {} at {} is in no opening",
                                   section.centres_mm.size(), section.label,
                                   place_text(section.centre_mm())));
    else if (const auto cut = side_cut_of(image, cuts, section, openings[*opening]))
      sides[*opening] = doubt_of_side(openings[*opening], *cut);
  };
  const std::vector<Voxels> of_openings = voxels_of(image, cuts, openings, look_at);
  std::vector<const Opening*> tiny;
  for (std::size_t i = 0; i < openings.size(); ++i) {
    if (of_openings[i].area_mm2 == 0) continue;
    std::string doubt = doubt_of(openings[i], of_openings[i], openings, fidelity);
    if (!sides[i].empty()) {
      // Says more than that its area is uncertain.
      if (of_openings[i].sections > 1) doubts.push_back(std::move(doubt));
      doubt = std::move(sides[i]);
    }
    if (doubt.empty()) continue;
    if (of_openings[i].is_tiny())
      tiny.push_back(&openings[i]);
    else
      doubts.push_back(std::move(doubt));
  }
  if (!tiny.empty()) doubts.push_back(doubt_of_tiny(tiny));
  for (std::string& doubt : doubts_about_edges(image, openings)) doubts.push_back(std::move(doubt));
  return doubts;
}

std::vector<std::string> doubts_about_shapes(const LabelImage& image, const Domain& domain,
                                             std::span<const Opening> openings) {
  std::vector<std::string> doubts = doubts_about_shared_outlines(openings);
  std::vector<bool> is_side(openings.size(), false);
  const auto look_at = [&](const BorderSection& section, std::optional<std::size_t> opening) {
    if (opening && side_cut_of(image, domain.cut_planes(), section, openings[*opening]))
      is_side[*opening] = true;
  };
  const std::vector<Voxels> of_openings = voxels_of(image, domain.cut_planes(), openings, look_at);
  for (std::size_t i = 0; i < openings.size(); ++i) {
    const Opening& opening = openings[i];
    if (const std::optional<SectionWaist> waist = find_waist(domain, opening))
      doubts.push_back(fmt::format(
          "{} at {} narrows to {:.3g} mm between parts {:.3g} and {:.3g} mm wide: two vessels that touch "
          "there would have one boundary condition; cut them with {} where they run apart, or try {} "
          "separate",
          opening.name, place_text(opening.centre_mm), waist->width_mm, waist->diameters_mm[0],
          waist->diameters_mm[1], option_name("cut_at"), option_name("touching")));
    else if (is_side[i])
      continue;  // Its area is that of no vessel.
    else if (std::string doubt = doubt_of_change(image, domain, opening, of_openings[i]); !doubt.empty())
      doubts.push_back(std::move(doubt));
  }
  return doubts;
}

}  // namespace lumesh
