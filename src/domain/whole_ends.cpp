#include "whole_ends.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "flat_regions.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/domain/patched_surface.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "room_behind.hpp"

namespace lumesh::surfaces {
namespace {

/// The plane of pieces, and the radius of the circle with their area within it.
struct EndPlane {
  explicit EndPlane(const AreaSum& all)
      : normal(all.normal.stableNormalized()),
        centre_mm(all.centre()),
        radius_mm(circle_radius(all.normal.norm())) {}

  Vec3 normal, centre_mm;
  double radius_mm;
};

/// Looks for pieces of one end around others.
class EndPieces {
 public:
  EndPieces(const ClosedSurface& surface, const FeatureRegions& regions)
      : surface_(surface),
        regions_(regions),
        pieces_(regions.count()),
        triangles_(regions.count()),
        beside_(regions.count()),
        box_mm_(regions.count()),
        visits_(regions.count(), 0),
        seen_by_(regions.count(), ~0U),
        is_in_(surface.triangles.size(), 0) {
    for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) add(t);
    for (std::vector<std::uint32_t>& beside : beside_) sort_unique(beside);
  }

  /// Triangles of ends that are no region; none is in two.
  [[nodiscard]] std::vector<std::vector<std::uint32_t>> find() {
    constexpr int kMaxTries = 64;  // Each looks at the whole surface.
    std::vector<std::vector<std::uint32_t>> found;
    std::vector<std::uint8_t> is_taken(surface_.triangles.size(), 0);
    int tries = 0;
    for (std::uint32_t seed = 0; seed < regions_.count() && tries < kMaxTries; ++seed) {  // By falling area.
      const std::uint32_t first = triangles_[seed].front();
      if (is_taken[first] != 0 || !is_seed(seed)) continue;
      const End pieces = around(seed, kMaxBent);
      if (pieces.regions.size() + pieces.triangles.size() < 2) continue;
      std::vector<std::uint32_t> end = triangles_of(pieces);
      if (std::ranges::any_of(end, [&](std::uint32_t t) { return is_taken[t] != 0; }) || !has_one_rim(end))
        continue;
      ++tries;
      if (!is_end(end)) continue;
      for (const std::uint32_t t : end) is_taken[t] = 1;
      found.push_back(std::move(end));
    }
    if (!found.empty() && is_of_voxels()) return {};
    return found;
  }

  /// Regions that would be ends were it not for how bent they are.
  [[nodiscard]] std::vector<BentEnd> find_bent() {
    constexpr int kMaxTries = 16;
    std::vector<BentEnd> found;
    std::vector<std::uint8_t> is_taken(surface_.triangles.size(), 0);
    int tries = 0;
    for (std::uint32_t seed = 0; seed < regions_.count() && tries < kMaxTries; ++seed) {
      if (is_taken[triangles_[seed].front()] != 0 || !is_seed(seed)) continue;
      const std::vector<std::uint32_t> end = triangles_of(around(seed, kMostBent));
      if (end.empty() || !has_one_rim(end)) continue;
      ++tries;
      if (const std::optional<BentEnd> bent = as_bent_end(end)) found.push_back(*bent);
      for (const std::uint32_t t : end) is_taken[t] = 1;
    }
    if (!found.empty() && is_of_voxels()) return {};
    return found;
  }

 private:
  /// Parts of what may be one end: regions as a whole, and triangles of others, as needles of which the wall
  /// took hold.
  struct End {
    std::vector<std::uint32_t> regions, triangles;
  };

  static constexpr double kMostBent = 4 * kMaxBent;  // Beyond, nothing tells an end from a dome.
  static constexpr int kMaxVisits = 8;               // Rough surfaces have very many regions.
  static constexpr double kMinCosine = 0.5;

  void add(std::uint32_t t) {
    const std::uint32_t own = regions_.of_triangle[t];
    const Vec3 &a = surface_.corner(t, 0), &b = surface_.corner(t, 1), &c = surface_.corner(t, 2);
    pieces_[own].add(a, b, c);
    for (const Vec3* corner : {&a, &b, &c}) box_mm_[own].extend(*corner);
    triangles_[own].push_back(t);
    if (surface_.is_enclosed[t] != 0) return;
    for (const std::uint32_t neighbour : surface_.neighbours[t]) {
      const std::uint32_t other = regions_.of_triangle[neighbour];
      if (other != own && regions_.patches[other] == regions_.patches[own]) beside_[own].push_back(other);
    }
  }

  [[nodiscard]] bool is_of_voxels() const {
    return !steps_of_voxels(region_shapes(surface_, regions_), [](std::uint32_t) { return false; }).empty();
  }
  [[nodiscard]] bool is_seed(std::uint32_t r) const {
    return visits_[r] < kMaxVisits && is_even(r) && surface_.is_enclosed[triangles_[r].front()] == 0;
  }
  [[nodiscard]] bool is_even(std::uint32_t r) const {
    constexpr double kMinEvenness = 0.6;
    return pieces_[r].normal.norm() > kMinEvenness * pieces_[r].area;
  }
  /// Needles have normals of all directions.
  [[nodiscard]] bool is_needle(std::uint32_t r) const {
    constexpr double kThin = 0.02;
    return pieces_[r].area < kThin * box_mm_[r].diagonal().squaredNorm();
  }
  [[nodiscard]] bool faces(std::uint32_t r, const Vec3& normal) const {
    return is_needle(r) || (is_even(r) && pieces_[r].normal.dot(normal) > kMinCosine * pieces_[r].area);
  }
  [[nodiscard]] std::vector<std::uint32_t> triangles_of(const End& end) const {
    std::vector<std::uint32_t> all = end.triangles;
    for (const std::uint32_t r : end.regions)
      all.insert(all.end(), triangles_[r].begin(), triangles_[r].end());
    return all;
  }
  [[nodiscard]] EndPlane plane_of(const End& end) const {
    AreaSum all;
    for (const std::uint32_t t : triangles_of(end))
      all.add(surface_.corner(t, 0), surface_.corner(t, 1), surface_.corner(t, 2));
    return EndPlane(all);
  }

  [[nodiscard]] bool has_one_rim(const std::vector<std::uint32_t>& end) {
    std::map<std::uint32_t, std::uint32_t> next;
    std::size_t edges = 0;
    for (const std::uint32_t t : end) is_in_[t] = 1;
    for (const std::uint32_t t : end)
      for (std::size_t s = 0; s < 3; ++s) {
        if (is_in_[surface_.neighbours[t][s]] != 0) continue;
        next[surface_.triangles[t][s]] = surface_.triangles[t][(s + 1) % 3];
        ++edges;
      }
    for (const std::uint32_t t : end) is_in_[t] = 0;
    return edges == next.size() && is_one_curve(next);
  }
  /// Whether triangles, as one region, are a flat end that the wall leaves at an angle.
  [[nodiscard]] bool is_end(const std::vector<std::uint32_t>& end) {
    constexpr double kMaxWallCosine = 0.45;  // Rough places of a wall are flat here and there, too.
    const FeatureRegions joined = with_regions(surface_, regions_, std::span(&end, 1));
    const RegionShape shape = region_shapes(surface_, joined)[joined.of_triangle[end.front()]];
    return shape.is_like_end && shape.wall_cosine <= kMaxWallCosine && room_behind().has_room(end, kMaxBent);
  }
  /// Nothing if triangles are flat, or the wall around is not that of a vessel that ends there.
  [[nodiscard]] std::optional<BentEnd> as_bent_end(const std::vector<std::uint32_t>& end) {
    constexpr double kMaxWallCosine = 0.3, kMinDepth = 1;
    constexpr std::size_t kMinTriangles = 8;
    if (end.size() < kMinTriangles) return std::nullopt;
    const EndPlane plane = plane_of({{}, end});
    double off_mm = 0;
    for (const std::uint32_t t : end)
      for (const std::uint32_t v : surface_.triangles[t])
        off_mm = std::max(off_mm, std::abs(plane.normal.dot(surface_.points[v] - plane.centre_mm)));
    if (off_mm <= kMaxBent * plane.radius_mm) return std::nullopt;
    const FeatureRegions joined = with_regions(surface_, regions_, std::span(&end, 1));
    const std::uint32_t region = joined.of_triangle[end.front()];
    RegionShape shape;
    shape.area_mm2 = std::numbers::pi * plane.radius_mm * plane.radius_mm;
    shape.centre_mm = plane.centre_mm;
    shape.normal = plane.normal;
    if (std::abs(cosine_of_wall(surface_, joined, region, shape, end)) > kMaxWallCosine ||
        !room_behind().has_room(end, kMostBent, kMinDepth))
      return std::nullopt;
    return BentEnd{plane.centre_mm, plane.radius_mm, off_mm, regions_.of_triangle[end.front()]};
  }
  [[nodiscard]] const RoomBehind& room_behind() {
    if (!room_behind_) room_behind_.emplace(surface_);
    return *room_behind_;
  }
  void put(const End& end, std::uint8_t is_in) {
    for (const std::uint32_t r : end.regions)
      for (const std::uint32_t t : triangles_[r]) is_in_[t] = is_in;
    for (const std::uint32_t t : end.triangles) is_in_[t] = is_in;
  }

  [[nodiscard]] bool is_near(const Cell<3>& corners, const EndPlane& plane, double share) const {
    return std::ranges::all_of(corners, [&](std::uint32_t v) {
      return std::abs(plane.normal.dot(surface_.points[v] - plane.centre_mm)) <= share * plane.radius_mm;
    });
  }
  [[nodiscard]] bool is_region_near(std::uint32_t r, const EndPlane& plane, double share) const {
    return std::ranges::all_of(triangles_[r],
                               [&](std::uint32_t t) { return is_near(surface_.triangles[t], plane, share); });
  }
  /// Whether a triangle is a needle that reaches far into the end, and leans on it with its longest edge.
  [[nodiscard]] bool is_needle_of(const EndPlane& plane, std::uint32_t t) const {
    constexpr double kMinReach = 0.2, kMaxThickness = 0.2;  // Of the radius; of its length.
    std::size_t longest = 0;
    const auto length_mm = [&](std::size_t s) {
      return (surface_.corner(t, (s + 1) % 3) - surface_.corner(t, s)).norm();
    };
    for (const std::size_t s : {1U, 2U})
      if (length_mm(s) > length_mm(longest)) longest = s;
    const double reach_mm = length_mm(longest);
    return is_in_[surface_.neighbours[t][longest]] != 0 && reach_mm > kMinReach * plane.radius_mm &&
           2 * triangle_area(surface_.corner(t, 0), surface_.corner(t, 1), surface_.corner(t, 2)) <
               kMaxThickness * reach_mm * reach_mm;
  }

  /// Small pieces of a ragged end face any way.
  [[nodiscard]] bool is_small(std::uint32_t r, const EndPlane& plane) const {
    constexpr double kSmall = 0.05;  // Of the end's area.
    return pieces_[r].area < kSmall * std::numbers::pi * plane.radius_mm * plane.radius_mm;
  }
  /// Adds what is beside the end and near its plane, and beside that. False if there is nothing.
  bool grow(End& end, const EndPlane& plane, double share) {
    std::vector<std::uint32_t> front = triangles_of(end);
    const std::size_t before = front.size();
    for (std::size_t i = 0; i < front.size(); ++i)
      for (const std::uint32_t t : surface_.neighbours[front[i]]) {
        const std::uint32_t r = regions_.of_triangle[t];
        if (is_in_[t] != 0 || surface_.patches[t] != surface_.patches[front[i]]) continue;
        if ((faces(r, plane.normal) || is_small(r, plane)) && is_region_near(r, plane, share)) {
          end.regions.push_back(r);
          for (const std::uint32_t own : triangles_[r]) {
            if (is_in_[own] == 0) front.push_back(own);
            is_in_[own] = 1;
          }
          std::erase_if(end.triangles, [&](std::uint32_t own) { return regions_.of_triangle[own] == r; });
        } else if (is_near(surface_.triangles[t], plane, share) && is_needle_of(plane, t)) {
          end.triangles.push_back(t);
          front.push_back(t);
          is_in_[t] = 1;
        }
      }
    return front.size() > before;
  }

  /// The regions that face as the seed does.
  [[nodiscard]] End facing_as(std::uint32_t seed) {
    End end{{seed}, {}};
    const Vec3 normal = pieces_[seed].normal.normalized();
    seen_by_[seed] = seed;
    for (std::size_t i = 0; i < end.regions.size(); ++i)
      for (const std::uint32_t r : beside_[end.regions[i]])
        if (seen_by_[r] != seed && visits_[r] < kMaxVisits && faces(r, normal)) {
          seen_by_[r] = seed;
          end.regions.push_back(r);
        }
    for (const std::uint32_t r : end.regions) ++visits_[r];
    return end;
  }

  /// Beginning with these, what is near a plane fitted to all, more and more narrowly.
  /// @param last_share  How near at last, of the radius.
  [[nodiscard]] End around(std::uint32_t seed, double last_share) {
    constexpr int kRounds = 16;
    End end = facing_as(seed);
    for (const double factor : {6.0, 4.0, 2.0, 1.0}) {
      const double share = factor * kMaxBent;
      if (share < last_share) break;
      const EndPlane first = plane_of(end);
      std::erase_if(end.regions, [&](std::uint32_t r) { return !is_region_near(r, first, share); });
      std::erase_if(end.triangles,
                    [&](std::uint32_t t) { return !is_near(surface_.triangles[t], first, share); });
      if (end.regions.empty()) return {};
      put(end, 1);
      for (int round = 0; round < kRounds && grow(end, plane_of(end), share); ++round) continue;
      put(end, 0);
    }
    return end;
  }

  const ClosedSurface& surface_;
  const FeatureRegions& regions_;
  std::vector<AreaSum> pieces_;
  std::vector<std::vector<std::uint32_t>> triangles_;
  std::vector<std::vector<std::uint32_t>> beside_;  // Regions of the same patch.
  std::vector<Box3> box_mm_;
  std::vector<int> visits_;
  std::vector<std::uint32_t> seen_by_;
  std::vector<std::uint8_t> is_in_;
  std::optional<RoomBehind> room_behind_;
};

}  // namespace

std::vector<std::vector<std::uint32_t>> divided_ends(const ClosedSurface& surface,
                                                     const FeatureRegions& regions) {
  return EndPieces(surface, regions).find();
}

std::vector<BentEnd> bent_ends(const ClosedSurface& surface, const FeatureRegions& regions) {
  return EndPieces(surface, regions).find_bent();
}

FeatureRegions with_whole_ends(const ClosedSurface& surface, FeatureRegions regions) {
  const std::vector<std::vector<std::uint32_t>> ends = divided_ends(surface, regions);
  return ends.empty() ? std::move(regions) : with_regions(surface, std::move(regions), ends);
}

}  // namespace lumesh::surfaces

namespace lumesh {

std::vector<std::vector<std::uint32_t>> triangles_of_divided_ends(const SurfaceView& view,
                                                                  const SurfaceDomainOptions& options) {
  const surfaces::ClosedSurface surface = surfaces::closed_surface(view, surfaces::Crossings::kAreBorne);
  if (surface.triangles.size() != view.triangles.size()) return {};
  return surfaces::divided_ends(surface, surfaces::find_regions(surface, options.feature_angle_deg));
}

}  // namespace lumesh
