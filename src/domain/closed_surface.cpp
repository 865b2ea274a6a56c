#include "closed_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>
#include <utility>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/findings.hpp"
#include "lumesh/surface/shells.hpp"

namespace lumesh::surfaces {
namespace {

[[noreturn]] void throw_bad_surface(const std::string& message) {
  throw Error(ErrorKind::kBadInput, message);
}

void check_arrays(const SurfaceView& surface) {
  require_triangles(surface.triangles);
  if (!surface.patches.empty() && surface.patches.size() != surface.triangles.size())
    throw_bad_surface("the surface has " + std::to_string(surface.triangles.size()) + " triangles but " +
                      std::to_string(surface.patches.size()) + " patch numbers");
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (const std::uint32_t v : surface.triangles[t])
      if (v >= surface.points.size() || !surface.points[v].allFinite())
        throw_bad_surface("triangle " + std::to_string(t) + " of the surface: point " + std::to_string(v) +
                          (v >= surface.points.size() ? " does not exist" : " is not finite"));
}

ClosedSurface welded(const SurfaceView& view) {
  TriangleMesh mesh = weld(view.points, view.triangles, view.patches);
  if (mesh.triangles.empty()) throw_bad_surface("the surface has no triangle with three different corners");
  ClosedSurface surface;
  surface.points = std::move(mesh.points);
  surface.triangles = std::move(mesh.triangles);
  surface.patches = std::move(mesh.patches);
  return surface;
}

[[noreturn]] void throw_bad_edge(const ClosedSurface& surface, const TriangleSide& one, std::size_t triangles,
                                 std::size_t open_edges) {
  const std::string ends =
      coordinates_text(surface.points[one.low]) + " to " + coordinates_text(surface.points[one.high]) + " mm";
  if (triangles == 1)
    throw_bad_surface("the surface is not closed: " + counted(open_edges, "edge has", "edges have") +
                      " one triangle only, such as that from " + ends +
                      "; close the holes first (`lumesh repair`)");
  throw_bad_surface("the surface is not a manifold: the edge from " + ends + " has " +
                    std::to_string(triangles) + " triangles; repair it first (`lumesh repair`)");
}

void find_neighbours(ClosedSurface& surface) {
  const std::vector<TriangleSide> sides = sorted_sides(surface.triangles);
  surface.neighbours.resize(surface.triangles.size());
  const TriangleSide* open = nullptr;
  std::size_t open_edges = 0;
  for_each_edge(sides, [&](std::span<const TriangleSide> edge) {
    const TriangleSide &a = edge.front(), &b = edge.back();
    if (edge.size() > 2) throw_bad_edge(surface, a, edge.size(), 0);
    if (edge.size() == 1 && open_edges++ == 0) open = &a;
    surface.neighbours[a.triangle][a.side] = b.triangle;
    surface.neighbours[b.triangle][b.side] = a.triangle;
  });
  if (open != nullptr) throw_bad_edge(surface, *open, 1, open_edges);
}

void turn(ClosedSurface& surface, std::uint32_t t) {
  std::swap(surface.triangles[t][1], surface.triangles[t][2]);
  std::swap(surface.neighbours[t][0], surface.neighbours[t][2]);
}

/// Turns all triangles of a connected part the same way.
Parts turn_parts_alike(ClosedSurface& surface) {
  const std::vector<Cell<3>> given = surface.triangles;
  Parts parts = turn_alike(surface.triangles, surface.neighbours);
  for (std::uint32_t t = 0; t < given.size(); ++t)
    if (surface.triangles[t] != given[t]) std::swap(surface.neighbours[t][0], surface.neighbours[t][2]);
  for (std::uint32_t t = 0; t < given.size(); ++t)
    for (std::size_t s = 0; s < 3; ++s) {
      const std::uint32_t from = surface.triangles[t][s], to = surface.triangles[t][(s + 1) % 3];
      if (runs_along(surface.triangles[surface.neighbours[t][s]], from, to))
        throw_bad_surface(
            "the surface has one side only, as a Moebius strip: triangles cannot be turned alike at " +
            coordinates_text(surface.points[from]) + " mm");
    }
  return parts;
}

/// Turns shells outwards; those within an odd number of others are cavities and are turned into them.
void turn_outwards(ClosedSurface& surface) {
  const Parts parts = turn_parts_alike(surface);
  const std::vector<Shell> shells = shells_of(surface.points, surface.triangles, parts);
  const auto is_flat = [](const Shell& shell) { return shell.volume_mm3 == 0; };
  if (!shells.empty() && std::ranges::all_of(shells, is_flat))
    throw_bad_surface("the surface encloses nothing, such as at " +
                      coordinates_text(shells.front().place_mm) + " mm: its volume is 0");
  for (const Shell& shell : shells)
    if (is_flat(shell))
      throw_bad_surface("the surface encloses nothing at " + coordinates_text(shell.place_mm) +
                        " mm: a flat part by itself is there, such as a cap whose rim does not match the "
                        "wall's; repair it first (`lumesh repair`)");
  surface.is_enclosed.resize(surface.triangles.size());
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
    const Shell& shell = shells[parts.of_triangle[t]];
    if (shell.is_turned()) turn(surface, t);
    surface.is_enclosed[t] = shell.depth > 0 ? 1 : 0;
  }
}

/// All triangles at a point must form one fan.
void check_fans(const ClosedSurface& surface) {
  std::vector<std::uint32_t> around(surface.points.size(), 0);
  std::vector<std::pair<std::uint32_t, std::size_t>> start(surface.points.size());
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      ++around[surface.triangles[t][i]];
      start[surface.triangles[t][i]] = {t, i};
    }
  for (std::uint32_t v = 0; v < surface.points.size(); ++v) {
    auto [t, i] = start[v];
    std::uint32_t seen = 0;
    do {
      t = surface.neighbours[t][i];
      for (i = 0; surface.triangles[t][i] != v;) ++i;
      ++seen;
    } while (t != start[v].first && seen <= around[v]);
    if (seen != around[v])
      throw_bad_surface("the surface is not a manifold: it touches itself in the point " +
                        coordinates_text(surface.points[v]) + " mm; repair it first (`lumesh repair`)");
  }
}

/// One with hardly any area, whose normal would be rounding, takes that of the neighbour at its longest edge.
Vec3 normal_of(const ClosedSurface& surface, std::uint32_t t) {
  constexpr int kMaxHops = 8;
  constexpr double kThin = 1e-12;  // Height over length.
  Vec3 normal = Vec3::Zero();
  for (int hop = 0; hop < kMaxHops; ++hop) {
    const auto length2 = [&](std::size_t s) {
      return (surface.corner(t, s) - surface.corner(t, (s + 1) % 3)).squaredNorm();
    };
    std::size_t longest = 0;
    for (const std::size_t s : {1u, 2u})
      if (length2(s) > length2(longest)) longest = s;
    normal = triangle_area_normal(surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2));
    if (normal.norm() > kThin * length2(longest)) break;
    t = surface.neighbours[t][longest];
  }
  return normal.stableNormalized();
}

/// Where sheets cross, there is no telling inside from outside. Folds of a few triangles over each other, as
/// real surfaces have, do no harm.
/// @param patches  Of the file; caps of open ends are openings without a name.
void check_crossings(const ClosedSurface& surface, std::span<const Patch> patches) {
  const std::vector<SelfCrossing> crossings = find_self_crossings(surface.points, surface.triangles);
  const auto sheets = std::ranges::find_if(crossings, [&](const SelfCrossing& crossing) {
    return !is_close_along(surface.neighbours, crossing.first, crossing.second);
  });
  if (sheets == crossings.end()) return;
  const auto is_of_cap = [&](std::uint32_t t) {
    const auto patch = static_cast<std::size_t>(surface.patches[t]);
    return patch < patches.size() && is_cap(patches[patch]);
  };
  if (is_of_cap(sheets->first) || is_of_cap(sheets->second))
    throw_bad_surface(
        "the cap of an open end crosses another part of the surface at " + coordinates_text(sheets->place) +
        " mm: one part goes on beyond where the other ends; cut both off in one plane, or leave one out");
  throw_bad_surface(
      "the surface crosses or touches itself: " + counted(crossings.size(), "pair") +
      " of triangles, such as at " + coordinates_text(sheets->place) +
      " mm; join its parts, cut ends that are not flat off before, or repair it (`lumesh repair`)");
}

}  // namespace

ClosedSurface closed_surface(const SurfaceView& view, Crossings crossings) {
  check_arrays(view);
  ClosedSurface surface = welded(view);
  find_neighbours(surface);
  turn_outwards(surface);
  check_fans(surface);
  if (crossings == Crossings::kAreRefused) check_crossings(surface, view.patch_info);
  surface.normals.resize(surface.triangles.size());
  parallel::for_each_index(surface.triangles.size(), [&](std::size_t t) {
    surface.normals[t] = normal_of(surface, static_cast<std::uint32_t>(t));
  });
  return surface;
}

}  // namespace lumesh::surfaces
