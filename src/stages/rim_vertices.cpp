#include "rim_vertices.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/edge_key.hpp"

namespace lumesh {
namespace {

/// How many triangles of some patches there are at each edge.
using TrianglesAt = std::map<std::array<std::uint32_t, 2>, int>;

void add_edges(const Cell<3>& corners, TrianglesAt& all) {
  for_each_edge_of(corners, [&](std::uint32_t a, std::uint32_t b) {
    ++all[{std::min(a, b), std::max(a, b)}];
  });
}

/// The triangles of one patch of openings.
struct RimmedPatch {
  AreaSum sum;
  TrianglesAt triangles_at;

  void add(const Cell<3>& corners, std::span<const Vec3> points) {
    sum.add(points[corners[0]], points[corners[1]], points[corners[2]]);
    add_edges(corners, triangles_at);
  }
  /// The rim's vertices, each with its longest edge there. @param of_label  Edges of all openings of its
  /// label: what is between two patches of one end is no rim.
  [[nodiscard]] std::map<std::uint32_t, double> rim(std::span<const Vec3> points,
                                                    const TrianglesAt& of_label) const {
    std::map<std::uint32_t, double> longest_mm;
    for (const auto& [edge, count] : triangles_at)
      if (count == 1 && of_label.at(edge) == 1)
        for (const std::uint32_t v : edge)
          longest_mm[v] = std::max(longest_mm[v], (points[edge[0]] - points[edge[1]]).norm());
    return longest_mm;
  }
};

/// How far a vertex of a rim is from where it should be.
struct OffRim {
  double mm = 0;  ///< At least; 0: near enough.
  bool is_more_yet =
      false;  ///< Nothing was found so far around it; else a quarter of the resolution more at most.

  [[nodiscard]] bool is_worse_than(const OffRim& other) const {
    return std::pair(is_more_yet, mm) > std::pair(other.is_more_yet, other.mm);
  }
};

/// The first distance for which is_there(distance) is true, from one that is near enough on.
template <class IsThere>
OffRim search_from(double enough_mm, double resolution_mm, const IsThere& is_there) {
  constexpr double kStep = 0.25;  // Of the resolution.
  constexpr int kSteps = 40;
  double off_mm = enough_mm;
  for (int step = 0; step < kSteps; ++step) {
    const double next_mm = off_mm + kStep * resolution_mm;
    if (is_there(next_mm)) return {off_mm, false};
    off_mm = next_mm;
  }
  return {off_mm, true};
}

/// Looks at a domain from places of a plane.
class RimPlane {
 public:
  /// @param normal  Unit, out of the object.
  RimPlane(const Domain& domain, Label label, const Vec3& normal)
      : domain_(domain), label_(label), normal_(normal), first_(normal.unitOrthogonal()) {}

  /// Distance from a place to where the label ends.
  [[nodiscard]] OffRim off(const Vec3& place, double enough_mm) const {
    const bool is_inside = holds(place);
    if (changes_at(place, enough_mm, is_inside) || changes_at(place, 0.5 * enough_mm, is_inside)) return {};
    return search_from(enough_mm, domain_.resolution_mm(),
                       [&](double radius_mm) { return changes_at(place, radius_mm, is_inside); });
  }

 private:
  [[nodiscard]] bool holds(const Vec3& place) const {
    constexpr double kBefore = 1e-3;  // Resolutions.
    const Vec3 before = place - kBefore * domain_.resolution_mm() * normal_;
    return domain_.label_of(domain_.material_at(before)) == label_;
  }
  /// Whether the label begins or ends on the way to a circle around a place.
  [[nodiscard]] bool changes_at(const Vec3& place, double radius_mm, bool is_inside) const {
    constexpr int kDirections = 16;
    const Vec3 second = normal_.cross(first_);
    for (int i = 0; i < kDirections; ++i) {
      const double angle = 2 * std::numbers::pi * i / kDirections;
      if (holds(place + radius_mm * (std::cos(angle) * first_ + std::sin(angle) * second)) != is_inside)
        return true;
    }
    return false;
  }

  const Domain& domain_;
  Label label_;
  Vec3 normal_, first_;
};

/// Distance from a vertex of a rim to where an end of a surface meets what is beside it. Flat ends need not
/// be planar, so that the plane of the mesh's may run beside them.
OffRim off_end(const Domain& domain, Label label, const Vec3& place, double enough_mm) {
  const auto is_rim_within = [&](double reach_mm) {
    std::size_t openings = 0, beside = 0;
    for (const Material m : domain.materials_near(place, reach_mm)) {
      if (domain.label_of(m) == label) continue;
      (domain.is_beyond_opening(m) ? openings : beside) += 1;
    }
    return openings > 0 && openings + beside > 1;
  };
  return is_rim_within(enough_mm) ? OffRim{} : search_from(enough_mm, domain.resolution_mm(), is_rim_within);
}

/// The line of a patch; empty if all of its rim is where the vessel ends.
std::string note_on(const Patch& patch, const RimmedPatch& triangles, std::span<const Vec3> points,
                    const TrianglesAt& of_label, const Domain& domain) {
  constexpr double kOff = 0.5;  // Resolutions.
  const RimPlane view(domain, patch.labels[0], triangles.sum.normal.normalized());
  const double radius_mm = circle_radius(triangles.sum.area);
  const bool is_plane = !domain.cut_planes().empty();
  std::size_t count = 0;
  OffRim worst;
  Vec3 place = Vec3::Zero();
  for (const auto& [v, edge_mm] : triangles.rim(points, of_label)) {
    const double lift_mm = edge_mm * edge_mm / (8 * radius_mm);  // What an edge cuts off a circle.
    const double enough_mm = kOff * domain.resolution_mm() + lift_mm;
    const OffRim off =
        is_plane ? view.off(points[v], enough_mm) : off_end(domain, patch.labels[0], points[v], enough_mm);
    if (off.mm == 0) continue;
    ++count;
    if (!off.is_worse_than(worst)) continue;
    worst = off;
    place = points[v];
  }
  if (count == 0) return "";
  return fmt::format(
      "the rim of {} leaves the vessel's section at {}: {}{:.2g} mm off it, {:.1f} {}{}; another "
      "`edge_length` "
      "may help",
      patch.name, place_text(place), worst.is_more_yet ? "more than " : "", worst.mm,
      worst.mm / domain.resolution_mm(), is_plane ? "voxels" : "edges of the surface",
      count == 1 ? "" : fmt::format(", the worst of {}", counted(count, "vertices", "vertices")));
}

}  // namespace

std::vector<std::string> notes_on_rims(const MeshView& mesh, const Domain& domain) {
  std::map<std::int32_t, RimmedPatch> patches;
  std::map<Label, TrianglesAt> of_labels;
  for_each_patch_triangle(mesh, [&](const Cell<3>& corners, std::int32_t patch) {
    const auto at = static_cast<std::size_t>(patch);
    if (at >= mesh.info->patches.size() || mesh.info->patches[at].kind != PatchKind::kOpening) return;
    patches[patch].add(corners, mesh.points);
    add_edges(corners, of_labels[mesh.info->patches[at].labels[0]]);
  });
  std::vector<std::string> notes;
  for (const auto& [patch, triangles] : patches) {
    if (!(triangles.sum.normal.norm() > 0)) continue;
    const Patch& known = mesh.info->patches[static_cast<std::size_t>(patch)];
    std::string note = note_on(known, triangles, mesh.points, of_labels.at(known.labels[0]), domain);
    if (!note.empty()) notes.push_back(std::move(note));
  }
  return notes;
}

}  // namespace lumesh
