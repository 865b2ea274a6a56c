#include "opening_rims.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "boundary_stars.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/triangle.hpp"

namespace lumesh::fitting {

namespace {

constexpr Material kOfAnotherLabel = std::numeric_limits<Material>::max();

class RimChoice {
 public:
  RimChoice(const WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain)
      : mesh_(mesh), boundary_(boundary), domain_(domain), surface_(boundary, mesh.positions.size()) {}

  void run() {
    constexpr int kRounds = 8;  // Triangles that a rim moves by, at most.
    std::vector<std::uint32_t> near = triangles_at_rims();
    for (int round = 0; round < kRounds && !near.empty(); ++round) {
      std::vector<std::uint32_t> next;
      for (const std::uint32_t t : near) {
        if (!change_if_nearer(t)) continue;
        for (const std::uint32_t v : boundary_.triangles[t].vertices) append_around(v, next);
      }
      sort_unique(next);
      near = std::move(next);
    }
    renew_sets();
  }

 private:
  [[nodiscard]] Material outside(std::uint32_t t) const { return boundary_.triangles[t].outside; }
  [[nodiscard]] bool is_outer(std::uint32_t t) const { return !domain_.is_meshed(outside(t)); }

  void append_around(std::uint32_t v, std::vector<std::uint32_t>& triangles) const {
    const auto around = surface_.triangles(v);
    std::copy_if(around.begin(), around.end(), std::back_inserter(triangles),
                 [&](std::uint32_t t) { return is_outer(t); });
  }

  [[nodiscard]] std::vector<std::uint32_t> triangles_at_rims() const {
    std::vector<std::uint32_t> near, around;
    for (std::uint32_t v = 0; v < boundary_.sets.size(); ++v) {
      if (!is_on_cut(domain_, boundary_.sets[v])) continue;
      around.clear();
      append_around(v, around);
      const bool is_rim =
          std::ranges::any_of(around, [&](std::uint32_t t) { return outside(t) != outside(around[0]); });
      if (is_rim) near.insert(near.end(), around.begin(), around.end());
    }
    sort_unique(near);
    return near;
  }

  /// Distance of a triangle's centroid from the surface that an outside material gives it; none where that
  /// surface is not near.
  [[nodiscard]] double distance_mm(std::uint32_t t, Material outside) const {
    constexpr double kReach = 6;  // Voxels.
    constexpr double kFar = std::numeric_limits<double>::infinity();
    const BoundaryTriangle& triangle = boundary_.triangles[t];
    const Vec3 centroid = triangle_centre(mesh_.positions, triangle.vertices);
    const double little_mm = 0.01 * domain_.voxel_size_mm();
    if (domain_.is_cut(outside)) {
      const CutPlane& plane = domain_.cut_plane(outside);
      const double height_mm = plane.height(centroid);
      const Vec3 within = centroid - (height_mm + little_mm) * plane.normal;
      const bool is_there = !domain_.beyond_cut(within) && domain_.material_at(within) == triangle.inside;
      return is_there ? std::abs(height_mm) : kFar;
    }
    const std::optional<Vec3> wall =
        domain_.project(centroid, {triangle.inside, outside}, kReach * domain_.voxel_size_mm());
    if (!wall || domain_.beyond_cuts_mm(*wall) > little_mm) return kFar;
    return (*wall - centroid).norm();
  }

  /// The outer triangle on the other side of an edge; none at the edge of several labels.
  [[nodiscard]] std::optional<std::uint32_t> across(std::uint32_t t, std::uint32_t a, std::uint32_t b) const {
    std::optional<std::uint32_t> found;
    for (const std::uint32_t other : surface_.triangles(a)) {
      const Triangle& v = boundary_.triangles[other].vertices;
      if (other == t || !is_outer(other) || std::ranges::find(v, b) == v.end()) continue;
      if (found) return std::nullopt;
      found = other;
    }
    return found;
  }

  /// @return Whether the triangle changed.
  bool change_if_nearer(std::uint32_t t) {
    BoundaryTriangle& triangle = boundary_.triangles[t];
    const Material own = triangle.outside;
    std::array<Material, 3> beside{};
    for (std::size_t e = 0; e < 3; ++e) {
      const auto other = across(t, triangle.vertices[e], triangle.vertices[(e + 1) % 3]);
      beside[e] =
          other && boundary_.triangles[*other].inside == triangle.inside ? outside(*other) : kOfAnotherLabel;
    }
    // At most one other material qualifies: were there two, each at one edge, the vertices opposite would
    // have triangles of both, and may_become() refuses that.
    const auto other = std::ranges::find_if(
        beside, [&](Material m) { return m != own && m != kOfAnotherLabel && may_become(t, m, beside); });
    if (other == beside.end() || distance_mm(t, *other) >= distance_mm(t, own)) return false;
    triangle.outside = *other;
    touched_.insert(touched_.end(), triangle.vertices.begin(), triangle.vertices.end());
    return true;
  }

  /// Whether the triangle's own part and the one that it joins keep their topology: it has one or two edges
  /// with the other one, and where it has one, the vertex opposite has triangles of its own part only.
  [[nodiscard]] bool may_become(std::uint32_t t, Material other,
                                const std::array<Material, 3>& beside) const {
    const BoundaryTriangle& triangle = boundary_.triangles[t];
    const auto shared = std::ranges::count(beside, other);
    if (shared == 3) return false;  // It would be gone.
    if (shared == 2) return std::ranges::count(beside, triangle.outside) == 1;
    const auto edge = static_cast<std::size_t>(std::ranges::find(beside, other) - beside.begin());
    const auto around = surface_.triangles(triangle.vertices[(edge + 2) % 3]);
    return std::ranges::all_of(around, [&](std::uint32_t i) {
      return !is_outer(i) ||
             (outside(i) == triangle.outside && boundary_.triangles[i].inside == triangle.inside);
    });
  }

  void renew_sets() {
    sort_unique(touched_);
    for (const std::uint32_t v : touched_) {
      boundary_.sets[v] = {};
      for (const std::uint32_t t : surface_.triangles(v)) bind(boundary_.sets[v], boundary_.triangles[t]);
    }
  }

  const WorkMesh& mesh_;
  BoundaryModel& boundary_;
  const ImageDomain& domain_;
  BoundaryStars surface_;
  std::vector<std::uint32_t> touched_;  // Corners of the triangles that changed.
};

}  // namespace

void choose_rims(const WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain) {
  RimChoice(mesh, boundary, domain).run();
}

}  // namespace lumesh::fitting
