#include "lumesh/domain/patch_names.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/geometry/area_order.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "opening_names.hpp"

namespace lumesh {

namespace {

/// Opening triangles grouped by what they share edges with.
class OpeningGroups {
 public:
  struct Group {
    std::vector<std::uint32_t> triangles;
    Material inside = 0, outside = 0;
    AreaSum sum;                     // In mm².
    std::vector<Vec3> centres_mm;    // Of its triangles.
    bool is_beside_another = false;  // An opening of another label.

    void add(std::uint32_t triangle, const BoundaryTriangle& t, std::span<const Vec3> positions) {
      const Vec3 &a = positions[t.vertices[0]], &b = positions[t.vertices[1]], &c = positions[t.vertices[2]];
      triangles.push_back(triangle);
      inside = t.inside;
      outside = t.outside;
      sum.add(a, b, c);
      centres_mm.push_back(triangle_centre(a, b, c));
    }
  };

  /// @param members  The triangles of openings.
  OpeningGroups(std::span<const BoundaryTriangle> boundary, std::span<const Vec3> positions,
                std::vector<std::uint32_t> members)
      : members_(std::move(members)), sets_(members_.size()) {
    join(boundary);
    group(boundary, positions);
  }

  /// By falling area.
  [[nodiscard]] const std::vector<Group>& groups() const { return groups_; }

 private:
  void join(std::span<const BoundaryTriangle> boundary) {
    struct EdgeOf {
      std::uint64_t edge;
      Material inside, outside;
      auto operator<=>(const EdgeOf&) const = default;
    };
    std::map<EdgeOf, std::uint32_t> first;
    std::map<std::uint64_t, std::uint32_t> first_of_edge;
    for (std::uint32_t i = 0; i < members_.size(); ++i) {
      const BoundaryTriangle& t = boundary[members_[i]];
      for (std::size_t e = 0; e < 3; ++e) {
        const auto [low, high] = std::minmax(t.vertices[e], t.vertices[(e + 1) % 3]);
        const std::uint64_t edge = std::uint64_t{low} << 32 | high;
        const auto [at, added] = first.try_emplace({edge, t.inside, t.outside}, i);
        if (!added) sets_.merge(i, at->second);
        const auto [other, is_first] = first_of_edge.try_emplace(edge, i);
        if (!is_first && boundary[members_[other->second]].inside != t.inside)
          beside_another_.insert(beside_another_.end(), {i, other->second});
      }
    }
  }

  void group(std::span<const BoundaryTriangle> boundary, std::span<const Vec3> positions) {
    std::map<std::uint32_t, std::size_t> number;
    for (std::uint32_t i = 0; i < members_.size(); ++i) {
      const auto [at, added] = number.try_emplace(sets_.find(i), groups_.size());
      if (added) groups_.emplace_back();
      groups_[at->second].add(members_[i], boundary[members_[i]], positions);
    }
    for (const std::uint32_t i : beside_another_) groups_[number.at(sets_.find(i))].is_beside_another = true;
    sort_by_area(groups_, [](const Group& group) { return area_at_place(group.sum); });
  }

  std::vector<std::uint32_t> members_;
  DisjointSets sets_;  // Of members.
  std::vector<std::uint32_t> beside_another_;
  std::vector<Group> groups_;
};

constexpr std::int32_t kUnnamed = -1;

/// The patches that the domain has names for, each boundary one of its own: so it keeps its creases.
void name_by_domain(std::span<const BoundaryTriangle> boundary, const Domain& domain,
                    PatchAssignment& result) {
  std::map<std::pair<Material, Material>, std::int32_t> number;
  for (const BoundaryTriangle& t : boundary) number[{t.inside, t.outside}] = kUnnamed;
  for (auto& [pair, patch] : number) {
    const std::optional<Patch> known = domain.patch_between(pair.first, pair.second);
    if (!known) continue;
    patch = static_cast<std::int32_t>(result.patches.size());
    result.patches.push_back(*known);
  }
  for (std::size_t i = 0; i < boundary.size(); ++i)
    result.of_triangle[i] = number.at({boundary[i].inside, boundary[i].outside});
}

/// Walls and interfaces.
void name_by_materials(std::span<const BoundaryTriangle> boundary, const Domain& domain,
                       const PatchNaming& naming, PatchAssignment& result) {
  std::set<Material> labels;
  std::map<std::pair<Material, Material>, std::int32_t> number;
  const auto pair_of = [](const BoundaryTriangle& t) {
    return t.outside == 0 ? std::pair{t.outside, t.inside} : std::pair{t.inside, t.outside};
  };
  for (std::size_t i = 0; i < boundary.size(); ++i) {
    labels.insert(boundary[i].inside);
    if (result.of_triangle[i] == kUnnamed && !domain.is_cut(boundary[i].outside))
      number[pair_of(boundary[i])] = kUnnamed;
  }
  for (auto& [pair, patch] : number) {
    const Label first = domain.label_of(pair.first);
    const Label second = domain.label_of(pair.second);
    patch = static_cast<std::int32_t>(result.patches.size());
    if (pair.first == 0) {
      result.patches.push_back(
          {naming.wall(second, labels.size() == 1), PatchKind::kWall, {second, kBackground}});
    } else {
      result.patches.push_back({naming.between(first, second), PatchKind::kInterface, {first, second}});
    }
  }
  for (std::size_t i = 0; i < boundary.size(); ++i)
    if (result.of_triangle[i] == kUnnamed && !domain.is_cut(boundary[i].outside))
      result.of_triangle[i] = number.at(pair_of(boundary[i]));
}

/// Openings of the mesh by those of the domain, so that their numbers do not depend on the mesh; what is none
/// of these is wall.
class OpeningNames {
 public:
  OpeningNames(std::span<const BoundaryTriangle> boundary, std::span<const Vec3> positions,
               const Domain& domain, const PatchNaming& naming, PatchAssignment& result)
      : boundary_(boundary),
        positions_(positions),
        domain_(domain),
        naming_(naming),
        result_(result),
        openings_(find_openings(domain)) {}

  void name(std::span<const OpeningGroups::Group> groups) {
    std::map<std::size_t, std::vector<OpeningGroups::Group>> by_number;
    for (const OpeningGroups::Group& group : groups) {
      const std::size_t opening = opening_of(group);
      if (opening == openings_.size())
        set(group, wall_of(group));
      else
        for (auto& [number, part] : parts_of(group, opening)) by_number[number].push_back(std::move(part));
    }
    for (auto& [number, of_opening] : by_number) {
      sort_by_area(of_opening, [](const OpeningGroups::Group& group) { return area_at_place(group.sum); });
      const OpeningGroups::Group& largest = of_opening.front();
      const std::int32_t patch = add(largest, number);
      for (const OpeningGroups::Group& group : of_opening)
        set(group, &group != &largest && is_splinter(group, largest) ? wall_of(group) : patch);
    }
  }

 private:
  /// Where a wall slants, single triangles of it lie in the plane beside the opening.
  static bool is_splinter(const OpeningGroups::Group& group, const OpeningGroups::Group& largest) {
    constexpr double kShare = 0.05;
    return !group.is_beside_another && group.sum.area < kShare * largest.sum.area;
  }

  /// The group, or what it has of each opening where it has most of several: the mesh has joined them.
  [[nodiscard]] std::map<std::size_t, OpeningGroups::Group> parts_of(const OpeningGroups::Group& group,
                                                                     std::size_t opening) const {
    constexpr double kMost = 0.5;  // Of an opening's area.
    const Label label = domain_.label_of(group.inside);
    std::map<std::size_t, OpeningGroups::Group> parts;
    for (std::size_t i = 0; i < group.triangles.size(); ++i) {
      const std::size_t nearest =
          opening_of_places(openings_, label, {&group.centres_mm[i], 1}, normal_of(group));
      const std::uint32_t t = group.triangles[i];
      parts[nearest < openings_.size() ? nearest : opening].add(t, boundary_[t], positions_);
    }
    const bool are_several = std::ranges::all_of(parts, [&](const auto& part) {
      return part.second.sum.area > kMost * openings_[part.first].area_mm2;
    });
    if (parts.size() == 1 || !are_several) return {{opening, group}};
    return parts;
  }
  [[nodiscard]] const Vec3& normal_of(const OpeningGroups::Group& group) const {
    return domain_.cut_plane(group.outside).normal;
  }
  [[nodiscard]] std::size_t opening_of(const OpeningGroups::Group& group) const {
    if (openings_.empty() || !(group.sum.area > 0)) return openings_.size();
    return opening_of_places(openings_, domain_.label_of(group.inside), group.centres_mm, normal_of(group));
  }
  [[nodiscard]] std::int32_t add(const OpeningGroups::Group& group, std::size_t number) {
    result_.patches.push_back(
        {openings_[number].name, PatchKind::kOpening, {domain_.label_of(group.inside), kBackground}});
    return static_cast<std::int32_t>(result_.patches.size()) - 1;
  }
  /// Wall of the group's label; a new one where the mesh has none.
  [[nodiscard]] std::int32_t wall_of(const OpeningGroups::Group& group) {
    const Label label = domain_.label_of(group.inside);
    for (std::size_t p = 0; p < result_.patches.size(); ++p)
      if (result_.patches[p].kind == PatchKind::kWall && result_.patches[p].labels[0] == label)
        return static_cast<std::int32_t>(p);
    result_.patches.push_back({naming_.wall(label, false), PatchKind::kWall, {label, kBackground}});
    return static_cast<std::int32_t>(result_.patches.size()) - 1;
  }
  void set(const OpeningGroups::Group& group, std::int32_t patch) {
    for (const std::uint32_t t : group.triangles) result_.of_triangle[t] = patch;
  }

  std::span<const BoundaryTriangle> boundary_;
  std::span<const Vec3> positions_;
  const Domain& domain_;
  const PatchNaming& naming_;
  PatchAssignment& result_;
  std::vector<Opening> openings_;
};

void name_openings(std::span<const BoundaryTriangle> boundary, std::span<const Vec3> positions,
                   const Domain& domain, const PatchNaming& naming, PatchAssignment& result) {
  std::vector<std::uint32_t> members;
  for (std::uint32_t i = 0; i < boundary.size(); ++i)
    if (result.of_triangle[i] == kUnnamed) members.push_back(i);
  if (members.empty()) return;
  const OpeningGroups groups(boundary, positions, std::move(members));
  OpeningNames(boundary, positions, domain, naming, result).name(groups.groups());
}

/// Openings are flat: what a mesher could not bring into its plane is wall.
std::vector<BoundaryTriangle> with_flat_openings(std::span<const BoundaryTriangle> boundary,
                                                 std::span<const Vec3> positions, const Domain& domain) {
  std::vector<BoundaryTriangle> faces(boundary.begin(), boundary.end());
  if (domain.cut_planes().empty()) return faces;
  const double max_off_mm = 0.25 * domain.resolution_mm();
  for (BoundaryTriangle& face : faces) {
    if (!domain.is_cut(face.outside)) continue;
    const CutPlane& plane = domain.cut_plane(face.outside);
    const auto is_off = [&](std::uint32_t v) { return std::abs(plane.height(positions[v])) > max_off_mm; };
    if (std::ranges::any_of(face.vertices, is_off)) face.outside = 0;
  }
  return faces;
}

}  // namespace

PatchAssignment name_patches(std::span<const BoundaryTriangle> given, std::span<const Vec3> positions,
                             const Domain& domain) {
  const std::vector<BoundaryTriangle> boundary = with_flat_openings(given, positions, domain);
  PatchAssignment result;
  result.label_names = domain.label_names();
  const PatchNaming naming(result.label_names);
  result.of_triangle.assign(boundary.size(), kUnnamed);
  name_by_domain(boundary, domain, result);
  name_by_materials(boundary, domain, naming, result);
  name_openings(boundary, positions, domain, naming, result);
  return result;
}

}  // namespace lumesh
