#include "missed_ends.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "flat_regions.hpp"
#include "lumesh/core/angles.hpp"
#include "lumesh/geometry/triangle.hpp"

namespace lumesh::surfaces {
namespace {

class FlatParts {
 public:
  FlatParts(const ClosedSurface& surface, const FeatureRegions& regions)
      : surface_(surface), regions_(regions), part_(surface.triangles.size(), 0) {}

  [[nodiscard]] std::vector<MissedEnd> find() {
    std::vector<MissedEnd> found;
    for (std::uint32_t seed = 0; seed < part_.size(); ++seed)
      if (part_[seed] == 0 && surface_.is_enclosed[seed] == 0)
        if (const std::optional<MissedEnd> end = as_end(part_around(seed))) found.push_back(*end);
    return found;
  }

 private:
  /// Triangles that hang together and face as the first one does.
  std::vector<std::uint32_t> part_around(std::uint32_t seed) {
    static const double kAlike = cosine_deg(0.5);
    std::vector<std::uint32_t> part{seed};
    part_[seed] = ++count_;
    for (std::size_t i = 0; i < part.size(); ++i)
      for (const std::uint32_t t : surface_.neighbours[part[i]])
        if (part_[t] == 0 && surface_.normals[t].dot(surface_.normals[seed]) > kAlike) {
          part_[t] = count_;
          part.push_back(t);
        }
    return part;
  }

  [[nodiscard]] std::optional<MissedEnd> as_end(const std::vector<std::uint32_t>& part) const {
    constexpr std::size_t kMinAround = 8;
    constexpr double kMinTurnDeg = 15, kMaxTurnDeg = 60;
    constexpr double kMaxShare = 0.7;  // Of the region's area.
    constexpr double kMinRound = 0.5;  // Of the area that a circle with the rim has.
    constexpr double kMaxAlike = 0.5;  // Mean normal of the wall around.
    if (part.size() < kMinAround - 2) return std::nullopt;
    AreaSum all;
    Vec3 wall = Vec3::Zero();
    double around_mm = 0, most_alike = -1;
    std::map<std::uint32_t, std::uint32_t> next;
    for (const std::uint32_t t : part) {
      all.add(surface_.corner(t, 0), surface_.corner(t, 1), surface_.corner(t, 2));
      for (std::size_t s = 0; s < 3; ++s) {
        const std::uint32_t other = surface_.neighbours[t][s];
        if (part_[other] == part_[t]) continue;
        const double length_mm = (surface_.corner(t, (s + 1) % 3) - surface_.corner(t, s)).norm();
        most_alike = std::max(most_alike, surface_.normals[t].dot(surface_.normals[other]));
        if (most_alike > cosine_deg(kMinTurnDeg)) return std::nullopt;
        wall += length_mm * surface_.normals[other];
        around_mm += length_mm;
        next[surface_.triangles[t][s]] = surface_.triangles[t][(s + 1) % 3];
      }
    }
    const double round_mm2 = around_mm * around_mm / (4 * std::numbers::pi);
    const double region_mm2 = regions_.areas_mm2[regions_.of_triangle[part.front()]];
    if (next.size() < kMinAround || all.area < kMinRound * round_mm2 || all.area > kMaxShare * region_mm2 ||
        wall.norm() > kMaxAlike * around_mm || most_alike < cosine_deg(kMaxTurnDeg) || !is_one_curve(next))
      return std::nullopt;
    return MissedEnd{all.centre(), circle_radius(all.area), degrees(std::acos(most_alike)),
                     regions_.of_triangle[part.front()]};
  }

  const ClosedSurface& surface_;
  const FeatureRegions& regions_;
  std::vector<std::uint32_t> part_;  // Of each triangle; 0: none yet.
  std::uint32_t count_ = 0;
};

}  // namespace

std::vector<MissedEnd> missed_ends(const ClosedSurface& surface, const FeatureRegions& regions) {
  return FlatParts(surface, regions).find();
}

}  // namespace lumesh::surfaces
