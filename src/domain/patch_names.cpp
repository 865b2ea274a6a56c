#include "lumesh/domain/patch_names.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <set>
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

  OpeningGroups(std::span<const BoundaryTriangle> boundary, std::span<const Vec3> positions,
                const Domain& domain) {
    for (std::uint32_t i = 0; i < boundary.size(); ++i) {
      if (domain.is_cut(boundary[i].outside)) members_.push_back(i);
    }
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

}  // namespace

PatchAssignment name_patches(std::span<const BoundaryTriangle> boundary, std::span<const Vec3> positions,
                             const Domain& domain) {
  PatchAssignment result;
  result.of_triangle.resize(boundary.size());
  std::set<std::pair<Material, Material>> pairs;
  std::set<Material> labels;
  for (const BoundaryTriangle& t : boundary) {
    labels.insert(t.inside);
    if (!domain.is_cut(t.outside))
      pairs.insert({t.outside == 0 ? 0 : t.inside, t.outside == 0 ? t.inside : t.outside});
  }
  std::map<std::pair<Material, Material>, std::int32_t> number;
  for (const auto& pair : pairs) {
    const Label first = domain.label_of(pair.first);
    const Label second = domain.label_of(pair.second);
    number[pair] = static_cast<std::int32_t>(result.patches.size());
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
  for (std::size_t i = 0; i < boundary.size(); ++i) {
    const BoundaryTriangle& t = boundary[i];
    if (!domain.is_cut(t.outside))
      result.of_triangle[i] =
          number.at({t.outside == 0 ? 0 : t.inside, t.outside == 0 ? t.inside : t.outside});
  }
  const OpeningGroups groups(boundary, positions, domain);
  for (std::size_t i = 0; i < groups.openings().size(); ++i) {
    const OpeningGroups::Opening& opening = groups.openings()[i];
    for (const std::uint32_t t : opening.triangles)
      result.of_triangle[t] = static_cast<std::int32_t>(result.patches.size());
    result.patches.push_back({i == 0 ? "inlet_1" : "outlet_" + std::to_string(i),
                              PatchKind::kOpening,
                              {domain.label_of(opening.label), kBackground}});
  }
  return result;
}

}  // namespace lumesh
