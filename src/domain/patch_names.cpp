#include "lumesh/domain/patch_names.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>

namespace lumesh {

namespace {

/// Opening triangles grouped by what they share edges with.
class OpeningGroups {
 public:
  struct Opening {
    std::vector<std::uint32_t> triangles;
    Material label = 0;
    double area_mm2 = 0;
  };

  /// @param members  The triangles of openings.
  OpeningGroups(std::span<const BoundaryTriangle> boundary, std::span<const Vec3> positions,
                std::vector<std::uint32_t> members)
      : members_(std::move(members)) {
    parent_.resize(members_.size());
    for (std::uint32_t i = 0; i < parent_.size(); ++i) parent_[i] = i;
    join(boundary);
    group(boundary, positions);
  }

  [[nodiscard]] const std::vector<Opening>& openings() const { return openings_; }

 private:
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  void join(std::span<const BoundaryTriangle> boundary) {
    struct EdgeOf {
      std::uint64_t edge;
      Material inside, outside;
      auto operator<=>(const EdgeOf&) const = default;
    };
    std::map<EdgeOf, std::uint32_t> first;
    for (std::uint32_t i = 0; i < members_.size(); ++i) {
      const BoundaryTriangle& t = boundary[members_[i]];
      for (std::size_t e = 0; e < 3; ++e) {
        const auto [low, high] = std::minmax(t.vertices[e], t.vertices[(e + 1) % 3]);
        const auto [at, added] = first.try_emplace({std::uint64_t{low} << 32 | high, t.inside, t.outside}, i);
        if (!added) parent_[root(i)] = root(at->second);
      }
    }
  }

  void group(std::span<const BoundaryTriangle> boundary, std::span<const Vec3> positions) {
    std::map<std::uint32_t, std::size_t> number;
    for (std::uint32_t i = 0; i < members_.size(); ++i) {
      const auto [at, added] = number.try_emplace(root(i), openings_.size());
      if (added) openings_.emplace_back();
      Opening& opening = openings_[at->second];
      const BoundaryTriangle& t = boundary[members_[i]];
      const Vec3& a = positions[t.vertices[0]];
      opening.triangles.push_back(members_[i]);
      opening.label = t.inside;
      opening.area_mm2 += 0.5 * (positions[t.vertices[1]] - a).cross(positions[t.vertices[2]] - a).norm();
    }
    std::stable_sort(openings_.begin(), openings_.end(),
                     [](const Opening& a, const Opening& b) { return a.area_mm2 > b.area_mm2; });
  }

  std::vector<std::uint32_t> members_;
  std::vector<std::uint32_t> parent_;
  std::vector<Opening> openings_;
};

constexpr std::int32_t kUnnamed = -1;

/// The patches that the domain has names for.
void name_by_domain(std::span<const BoundaryTriangle> boundary, const Domain& domain,
                    PatchAssignment& result) {
  std::map<std::pair<Material, Material>, std::int32_t> number;
  for (const BoundaryTriangle& t : boundary) number[{t.inside, t.outside}] = kUnnamed;
  std::map<std::string, std::int32_t> by_name;
  for (auto& [pair, patch] : number) {
    const std::optional<Patch> known = domain.patch_between(pair.first, pair.second);
    if (!known) continue;
    const auto [at, added] =
        by_name.try_emplace(known->name, static_cast<std::int32_t>(result.patches.size()));
    if (added) result.patches.push_back(*known);
    patch = at->second;
  }
  for (std::size_t i = 0; i < boundary.size(); ++i)
    result.of_triangle[i] = number.at({boundary[i].inside, boundary[i].outside});
}

/// Walls and interfaces.
void name_by_materials(std::span<const BoundaryTriangle> boundary, const Domain& domain,
                       PatchAssignment& result) {
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
      result.patches.push_back({labels.size() == 1 ? "wall" : "wall_" + std::to_string(second),
                                PatchKind::kWall,
                                {second, kBackground}});
    } else {
      result.patches.push_back({"interface_" + std::to_string(first) + "_" + std::to_string(second),
                                PatchKind::kInterface,
                                {first, second}});
    }
  }
  for (std::size_t i = 0; i < boundary.size(); ++i)
    if (result.of_triangle[i] == kUnnamed && !domain.is_cut(boundary[i].outside))
      result.of_triangle[i] = number.at(pair_of(boundary[i]));
}

void name_openings(std::span<const BoundaryTriangle> boundary, std::span<const Vec3> positions,
                   const Domain& domain, PatchAssignment& result) {
  std::vector<std::uint32_t> members;
  for (std::uint32_t i = 0; i < boundary.size(); ++i)
    if (result.of_triangle[i] == kUnnamed) members.push_back(i);
  const OpeningGroups groups(boundary, positions, std::move(members));
  for (std::size_t i = 0; i < groups.openings().size(); ++i) {
    const OpeningGroups::Opening& opening = groups.openings()[i];
    for (const std::uint32_t t : opening.triangles)
      result.of_triangle[t] = static_cast<std::int32_t>(result.patches.size());
    result.patches.push_back({i == 0 ? "inlet_1" : "outlet_" + std::to_string(i),
                              PatchKind::kOpening,
                              {domain.label_of(opening.label), kBackground}});
  }
}

}  // namespace

PatchAssignment name_patches(std::span<const BoundaryTriangle> boundary, std::span<const Vec3> positions,
                             const Domain& domain) {
  PatchAssignment result;
  result.of_triangle.assign(boundary.size(), kUnnamed);
  name_by_domain(boundary, domain, result);
  name_by_materials(boundary, domain, result);
  name_openings(boundary, positions, domain, result);
  return result;
}

}  // namespace lumesh
