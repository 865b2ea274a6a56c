#include "extension_plan.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

constexpr double kStump = 5;    // Layers of voxels beyond the end, by which the boundary goes on there.
constexpr double kAir = 4;      // Voxels around an extension: as far as the functions of a field reach.
constexpr double kCutAir = 2;   // The same of what its end cuts off, which has to leave others.
constexpr double kApart = 2.5;  // Voxels between two vessels whose boundaries don't feel each other.

class ExtensionPlanner {
 public:
  ExtensionPlanner(const ImageDomain& domain, std::span<const Opening> openings,
                   const ExtensionOptions& options)
      : domain_(domain),
        openings_(openings),
        wanted_(options.lengths),
        transition_(options.transition),
        voxel_mm_(domain.frame().spacing_mm.maxCoeff()) {}

  ExtensionPlan make() {
    check_names();
    plan_.groups = group_openings(openings_);
    plan_.tubes.resize(plan_.groups.size());
    plan_.lengths_mm.resize(plan_.groups.size());
    radii_mm_.resize(plan_.groups.size());
    is_clear_.resize(plan_.groups.size());
    find_directions();
    find_gaps();
    make_neighbours_parallel();
    for (std::size_t g = 0; g < plan_.groups.size(); ++g) add_tube(g);
    shorten_all();
    for (std::size_t g = 0; g < plan_.groups.size(); ++g) set_length(g, plan_.lengths_mm[g]);
    return std::move(plan_);
  }

 private:
  void check_names() const {
    std::vector<std::string> names;
    for (const Opening& o : openings_) names.push_back(o.name);
    check_names_of(wanted_, names, "the image");
  }

  /// The lumen, where there is a wall, too.
  [[nodiscard]] const Opening& main_opening(const OpeningGroup& group) const {
    for (const std::size_t m : group.members)
      if (!openings_[m].is_rim) return openings_[m];
    return openings_[group.members[0]];
  }

  /// A length by name counts for the whole section.
  [[nodiscard]] double wanted_mm(const OpeningGroup& group, double radius_mm) const {
    std::vector<std::string> names = {main_opening(group).name};
    for (const std::size_t m : group.members) names.push_back(openings_[m].name);
    return length_wanted_mm(wanted_, names, radius_mm);
  }

  [[nodiscard]] bool is_wanted(std::size_t g) const {
    return wanted_mm(plan_.groups[g], main_opening(plan_.groups[g]).lumen_radius_mm()) > 0;
  }

  void find_directions() {
    constexpr double kMinDepth = 3;       // Voxels.
    constexpr double kRadiiOfHollow = 2;  // The places of thin walls are noisier.
    for (std::size_t g = 0; g < plan_.groups.size(); ++g) {
      const EndSection& section = plan_.groups[g].section;
      const Opening& main = main_opening(plan_.groups[g]);
      directions_.push_back(section.plane.normal);
      if (!is_wanted(g)) continue;
      const double depth_mm = (main.is_hollow() ? kRadiiOfHollow : 1) * main.lumen_radius_mm();
      const auto axis = end_axis(domain_, section, std::max(depth_mm, kMinDepth * voxel_mm_));
      is_clear_[g] = axis.has_value();
      if (axis)
        directions_[g] = *axis;
      else
        note(g,
             "has an extension perpendicular to its plane: the vessel forks, bulges or begins there, or runs "
             "almost along the plane, so that its direction is not clear; cut it further inside with "
             "`cut_at`");
    }
  }

  [[nodiscard]] auto section_with_air(std::size_t g, double voxels) const {
    return section_of(openings_, plan_.groups, g, directions_[g], voxels * voxel_mm_, voxel_mm_);
  }

  /// Between each two sections in one plane; elsewhere kApart.
  void find_gaps() {
    const std::size_t count = plan_.groups.size();
    gaps_mm_.assign(count, std::vector<double>(count, kApart * voxel_mm_));
    for (std::size_t g = 0; g < count; ++g) plan_.tubes[g].bare = section_with_air(g, 0);
    for (std::size_t g = 0; g < count; ++g)
      for (std::size_t other = g + 1; other < count; ++other)
        if (are_in_one_plane(g, other))
          gaps_mm_[g][other] = gaps_mm_[other][g] =
              std::min(kApart * voxel_mm_, gap_mm(*plan_.tubes[g].bare, *plan_.tubes[other].bare));
  }

  [[nodiscard]] bool are_in_one_plane(std::size_t g, std::size_t other) const {
    return lumesh::are_in_one_plane(openings_[plan_.groups[g].members[0]],
                                    openings_[plan_.groups[other].members[0]]);
  }

  [[nodiscard]] static double gap_mm(const CarriedSection& a, const CarriedSection& b) {
    double nearest_mm = 1e300;
    for (int j = 0; j < b.rows; ++j)
      for (int i = 0; i < b.columns; ++i) {
        const Vec3 x = b.square(i, j);
        if (b.inside_section_mm(x) >= 0) nearest_mm = std::min(nearest_mm, -a.inside_section_mm(x));
      }
    return std::max(0.0, nearest_mm - b.step_mm);  // Half a square on both sides.
  }

  /// Neighbours whose axes come together, or are parallel but for their errors, stay as far apart as their
  /// openings are: so near to each other, axes may be off by some degrees.
  void make_neighbours_parallel() {
    const std::vector<Vec3> found = directions_;
    for (std::size_t g = 0; g < found.size(); ++g) {
      Vec3 sum = plan_.groups[g].section.area_mm2 * found[g];
      for (std::size_t other = 0; other < found.size(); ++other)
        if (other != g && may_become_parallel(g, other, found)) {
          sum += plan_.groups[other].section.area_mm2 * found[other];
          is_clear_[g] = false;  // Walls that lean towards the other one are not to be followed.
        }
      directions_[g] = sum.normalized();
    }
  }

  [[nodiscard]] bool may_become_parallel(std::size_t g, std::size_t other,
                                         const std::vector<Vec3>& found) const {
    constexpr double kAlike = 0.978;       // Cosine of 12 degrees: each turns by about six.
    constexpr double kParallel = 0.99966;  // Of 1.5 degrees.
    if (!is_wanted(g) || !is_wanted(other) || !are_in_one_plane(g, other)) return false;
    const Vec3 way = plan_.groups[other].section.plane.point_mm - plan_.groups[g].section.plane.point_mm;
    const bool come_together = way.dot(found[g] - found[other]) > 0;
    return gaps_mm_[g][other] < kApart * voxel_mm_ &&
           found[g].dot(found[other]) > (come_together ? kAlike : kParallel);
  }

  void add_tube(std::size_t g) {
    const OpeningGroup& group = plan_.groups[g];
    const Opening& main = main_opening(group);
    VesselTube& tube = plan_.tubes[g];
    const Vec3& direction = directions_[g];
    const bool is_hollow = main.is_hollow();
    const double radius_mm = main.lumen_radius_mm();
    radii_mm_[g] = radius_mm * std::sqrt(direction.dot(group.section.plane.normal));
    const auto carried = section_with_air(g, kAir), of_cut = section_with_air(g, kCutAir);
    tube.section = carried;
    tube.of_cut = of_cut;
    const bool is_circle = is_wanted(g) && transition_;
    if (is_circle && is_hollow) {
      note(g, "keeps its section, which is that of a hollow wall: a circle would close its lumen");
    } else if (is_circle) {
      set_circles(group, tube, *carried, radii_mm_[g]);
      of_cut->circle_mm = tube.outer.radius_mm + kCutAir * voxel_mm_;
    }
    if (is_clear_[g]) find_ramp(g);
    double length_mm = wanted_mm(group, radii_mm_[g]);
    const double min_mm = min_length_mm(g);
    if (length_mm > 0 && length_mm < min_mm) {
      note(g,
           fmt::format("is cut off obliquely, so that {:.3g} mm would end within the image; it has {:.3g} mm",
                       length_mm, min_mm));
      length_mm = min_mm;
    }
    set_length(g, length_mm);
  }

  /// How far the opening's plane leans along the extension.
  [[nodiscard]] double slant_mm(std::size_t g) const {
    const EndSection& section = plan_.groups[g].section;
    const double cosine = directions_[g].dot(section.plane.normal);
    return section.reach_mm * std::sqrt(std::max(0.0, 1 - cosine * cosine));
  }
  /// The end has to stand off the opening's plane.
  [[nodiscard]] double min_length_mm(std::size_t g) const { return slant_mm(g) + voxel_mm_; }

  /// The slopes are those of the outer wall around the opening, in its plane.
  void find_ramp(std::size_t g) {
    const CarriedSection& section = *plan_.tubes[g].bare;
    WallRamp ramp(section.direction, plan_.groups[g].section.reach_mm);
    std::vector<Vec3> places;
    for (const Vec3& square : rim_squares(section)) {
      const FieldSample at = domain_.separation(square, 1, 0);
      const Vec3 across = at.gradient - at.gradient.dot(section.normal) * section.normal;
      if (!(std::abs(at.value) < voxel_mm_ * across.norm())) continue;
      places.emplace_back(square - at.value / across.squaredNorm() * across - section.centre_mm);
      const FieldSample wall = domain_.separation(section.centre_mm + places.back(), 1, 0);
      ramp.add_wall(places.back(), -wall.gradient.normalized(), 1);
    }
    ramp.fit();
    ramp.set_length(WallRamp::kRadii * radii_mm_[g]);
    double steepest = 0;
    for (const Vec3& off : places) steepest = std::max(steepest, ramp.slope(off).norm());
    ramp.limit(steepest, section.direction.dot(section.normal));
    plan_.tubes[g].ramp = ramp;
  }
  /// Squares of a section without air that have a neighbour outside.
  [[nodiscard]] static std::vector<Vec3> rim_squares(const CarriedSection& section) {
    const auto is_inside = [&](int i, int j) {
      return section.inside[static_cast<std::size_t>(j) * static_cast<std::size_t>(section.columns) +
                            static_cast<std::size_t>(i)] >= 0;
    };
    std::vector<Vec3> places;
    for (int j = 1; j + 1 < section.rows; ++j)
      for (int i = 1; i + 1 < section.columns; ++i)
        if (is_at_rim(is_inside, i, j)) places.push_back(section.square(i, j));
    return places;
  }

  void set_circles(const OpeningGroup& group, VesselTube& tube, CarriedSection& carried, double radius_mm) {
    const double cosine = carried.direction.dot(carried.normal);
    tube.transition_mm = transition_->in_mm(radius_mm);
    tube.outer = {carried.centre_mm, circle_radius(group.section.area_mm2 * cosine)};
    carried.circle_mm = tube.outer.radius_mm + kAir * voxel_mm_;
    const auto is_rim = [&](std::size_t m) { return openings_[m].is_rim; };
    if (group.members.size() != 2 || is_rim(group.members[0]) == is_rim(group.members[1])) return;
    const Opening& wall = openings_[group.members[is_rim(group.members[0]) ? 0 : 1]];
    const Opening& lumen = main_opening(group);
    tube.lumen.radius_mm = circle_radius(lumen.area_mm2 * cosine);
    // Half of the wall stays at the thinnest place.
    const double max_mm = 0.5 * (tube.outer.radius_mm - tube.lumen.radius_mm);
    const Vec3 off = lumen.centre_mm - carried.centre_mm;
    tube.lumen.centre_mm = carried.centre_mm + std::min(1.0, max_mm / std::max(off.norm(), 1e-300)) * off;
    for (Material m = 1; m < domain_.label_count(); ++m) {
      if (domain_.label_of(m) == wall.label) tube.wall_label = static_cast<VesselTube::LabelIndex>(m);
      if (domain_.label_of(m) == lumen.label) tube.lumen_label = static_cast<VesselTube::LabelIndex>(m);
    }
  }

  void set_length(std::size_t g, double length_mm) {
    VesselTube& tube = plan_.tubes[g];
    plan_.lengths_mm[g] = length_mm;
    if (length_mm == 0) {  // It stays as it is.
      for (auto* const section : {&tube.section, &tube.of_cut}) {
        auto straight = std::make_shared<CarriedSection>(**section);
        straight->direction = straight->normal;
        straight->circle_mm = CarriedSection().circle_mm;
        *section = straight;
      }
    }
    const CarriedSection& section = *tube.section;
    tube.stays = length_mm == 0;
    const double straight_mm = std::max(0.0, length_mm - slant_mm(g));
    tube.ramp.set_length(is_clear_[g] ? std::min(WallRamp::kRadii * radii_mm_[g], straight_mm) : 0);
    if (tube.stays) tube.transition_mm = -1;
    tube.end_mm = section.centre_mm + length_mm * section.direction;
    tube.end_normal = section.direction;
    tube.stump_mm = kStump * domain_.frame().thickness_along_mm(tube.end_normal);
    tube.box_mm.setEmpty();
    const Vec3 last = tube.end_mm + tube.stump_mm * tube.end_normal;
    for (const int i : {0, section.columns - 1})
      for (const int j : {0, section.rows - 1}) {
        const Vec3 corner = section.square(i, j);
        tube.box_mm.extend(corner);
        tube.box_mm.extend(
            Vec3(corner + std::max(0.0, (last - corner).dot(section.direction)) * section.direction));
      }
    const Vec3 margin = Vec3::Constant(tube.ramp.max_displacement_mm());
    tube.box_mm = {tube.box_mm.min() - margin, tube.box_mm.max() + margin};
  }

  void note(std::size_t g, const std::string& text) {
    plan_.notes.push_back(
        fmt::format("{}: {} {}", option_name("extend"), main_opening(plan_.groups[g]).name, text));
  }

  /// How far from an opening something is in the way, and where.
  struct Hit {
    double along_mm = 0;
    Vec3 place_mm = Vec3::Zero();
  };

  [[nodiscard]] double clearance_mm(std::size_t g) const {
    return std::max(radii_mm_[g], plan_.tubes[g].stump_mm + kApart * voxel_mm_);
  }

  void shorten_all() {
    const std::size_t count = plan_.groups.size();
    std::vector<std::optional<Hit>> hits(count);
    parallel::for_each_index(count, 1, [&](std::size_t g) {
      if (plan_.lengths_mm[g] > 0) hits[g] = first_hit(g);
    });
    for (std::size_t g = 0; g < count; ++g) {
      if (!hits[g]) continue;
      const double asked_mm = plan_.lengths_mm[g];
      double length_mm = std::min(asked_mm, hits[g]->along_mm - clearance_mm(g));
      if (length_mm < std::max(min_length_mm(g), 2 * voxel_mm_)) length_mm = 0;
      note(g,
           fmt::format("is extended by {:.4g} mm, not {:.4g} mm: another vessel or extension is in the way "
                       "at {}; cut the vessel further inside with `cut_at`",
                       length_mm, asked_mm, place_text(hits[g]->place_mm)));
      plan_.lengths_mm[g] = length_mm;
    }
  }

  /// Looks along the extension, and beyond its end by the clearance, with some room around it.
  [[nodiscard]] std::optional<Hit> first_hit(std::size_t g) const {
    const VesselTube& tube = plan_.tubes[g];
    const CarriedSection& section = *tube.section;
    const std::vector<PlaceAcross> places = places_across(tube);
    for (const PlaceAcross& from : places)
      if (is_beside_other_face(from.place_mm, g)) return Hit{0, from.place_mm};
    const double last_mm = plan_.lengths_mm[g] + clearance_mm(g), step_mm = 0.8 * voxel_mm_;
    for (double along_mm = step_mm; along_mm < last_mm + step_mm; along_mm += step_mm)
      for (const PlaceAcross& from : places) {
        const double at_mm = std::min(along_mm, last_mm);
        const Vec3 x = from.place_mm + at_mm * section.direction +
                       tube.ramp.displacement(from.place_mm - section.centre_mm, at_mm);
        if ((x - section.centre_mm).dot(section.normal) > 0.5 * voxel_mm_ && is_taken(x, from.off_mm, g))
          return Hit{at_mm, x};
      }
    return std::nullopt;
  }

  struct PlaceAcross {
    Vec3 place_mm;
    double off_mm = 0;  ///< Distance from the section, negative within.
  };

  /// About a voxel apart: the section with the room around it, as it is carried and as the circle.
  [[nodiscard]] std::vector<PlaceAcross> places_across(const VesselTube& tube) const {
    const CarriedSection& section = *tube.section;
    const int stride = std::max(1, static_cast<int>(voxel_mm_ / section.step_mm));
    std::vector<PlaceAcross> places;
    for (int j = 0; j < section.rows; j += stride)
      for (int i = 0; i < section.columns; i += stride) {
        const Vec3 x = section.square(i, j);
        const double off_circle_mm = section.off_axis_mm(x) - section.circle_mm + kAir * voxel_mm_;
        const double off_mm = std::min(-tube.bare->inside_section_mm(x), off_circle_mm);
        if (off_mm <= kApart * voxel_mm_) places.push_back({x, off_mm});
      }
    return places;
  }

  /// Whether an opening in another plane is there: a vessel that leaves through an edge of the image has two.
  [[nodiscard]] bool is_beside_other_face(const Vec3& x, std::size_t own) const {
    constexpr double kSamePlane = 0.999;
    for (std::size_t g = 0; g < plan_.tubes.size(); ++g) {
      const CarriedSection& bare = *plan_.tubes[g].bare;
      const double height_mm = (x - bare.centre_mm).dot(bare.normal);
      if (g == own || bare.normal.dot(plan_.tubes[own].bare->normal) > kSamePlane) continue;
      if (std::abs(height_mm) < kApart * voxel_mm_ &&
          bare.inside_section_mm(x - height_mm * bare.normal) > -voxel_mm_)
        return true;
    }
    return false;
  }

  /// @param off_mm  How far the place is from the own extension: what is beside the opening already may stay
  /// as near as it is there.
  [[nodiscard]] bool is_taken(const Vec3& x, double off_mm, std::size_t own) const {
    constexpr double kSameGap = 0.75;
    if (is_of_image(domain_, x) && domain_.is_meshed(domain_.material_at(x))) return true;
    for (std::size_t g = 0; g < plan_.tubes.size(); ++g) {
      const bool is_near = gaps_mm_[own][g] == kApart * voxel_mm_ || off_mm < kSameGap * gaps_mm_[own][g];
      if (g != own && is_near && plan_.tubes[g].outer_value(domain_.field(), x) > 0) return true;
    }
    return false;
  }

  const ImageDomain& domain_;
  std::span<const Opening> openings_;
  std::vector<NamedLength> wanted_;
  std::optional<LocalLength> transition_;
  double voxel_mm_;
  std::vector<Vec3> directions_;              // Of extensions, unit.
  std::vector<bool> is_clear_;                // Whether the walls before an opening show its direction.
  std::vector<std::vector<double>> gaps_mm_;  // Between sections, at most kApart.
  std::vector<double> radii_mm_;              // Of the lumens, square to their axes.
  ExtensionPlan plan_;
};

}  // namespace

bool is_of_image(const ImageDomain& domain, const Vec3& x) {
  constexpr double kHalf = 0.5;
  const ImageFrame& frame = domain.frame();
  const Eigen::Array3d index = frame.to_index(x).array();
  return (index > -kHalf).all() && (index < frame.size.cast<double>().array() - kHalf).all() &&
         !domain.beyond_cut(x);
}

ExtensionPlan plan_extensions(const ImageDomain& domain, std::span<const Opening> openings,
                              const ExtensionOptions& options) {
  return ExtensionPlanner(domain, openings, options).make();
}

}  // namespace lumesh
