#include "mesh_boundary.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/triangle_mesh.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::centerline {

namespace {

/// What a patch counts as.
enum class Part : std::uint8_t { kWall, kOpening, kNone };

Part part_of(const MeshView& mesh, std::int32_t patch) {
  if (mesh.info == nullptr || patch < 0 || static_cast<std::size_t>(patch) >= mesh.info->patches.size())
    return Part::kWall;
  const Patch& known = mesh.info->patches[static_cast<std::size_t>(patch)];
  if (known.kind == PatchKind::kInterface) return Part::kNone;
  return known.kind == PatchKind::kOpening ? Part::kOpening : Part::kWall;
}

Boundary given_boundary(const MeshView& mesh) {
  Boundary boundary;
  const auto add = [&](const Cell<3>& triangle, std::int32_t patch) {
    const Part part = part_of(mesh, patch);
    if (part == Part::kNone) return;
    boundary.triangles.push_back(triangle);
    boundary.is_opening.push_back(part == Part::kOpening ? 1 : 0);
  };
  for_each_patch_triangle(mesh, add);
  boundary.points.assign(mesh.points.begin(), mesh.points.end());
  if (boundary.triangles.empty() && !mesh.tetrahedra.empty()) {
    TriangleMesh surface = extract_boundary(TetMesh::build(mesh));
    boundary.points = std::move(surface.points);
    boundary.triangles = std::move(surface.triangles);
    boundary.is_opening.assign(boundary.triangles.size(), 0);
  }
  return boundary;
}

using DirectedEdge = std::array<std::uint32_t, 2>;

/// Edges of one triangle only.
std::vector<DirectedEdge> open_edges(const Boundary& boundary) {
  std::vector<DirectedEdge> open;
  for_each_edge(sorted_sides(boundary.triangles), [&](std::span<const TriangleSide> edge) {
    const Cell<3>& corners = boundary.triangles[edge[0].triangle];
    if (edge.size() == 1) open.push_back({corners[edge[0].side], corners[(edge[0].side + 1) % 3]});
  });
  return open;
}

/// Adds a fan of triangles to each hole, from the middle of its edges. @return Number of holes.
std::size_t close_holes(Boundary& boundary) {
  const std::vector<DirectedEdge> edges = open_edges(boundary);
  DisjointSets sets(boundary.points.size());
  for (const DirectedEdge& edge : edges) sets.merge(edge[0], edge[1]);
  std::map<std::uint32_t, std::vector<DirectedEdge>> holes;
  for (const DirectedEdge& edge : edges) holes[sets.find(edge[0])].push_back(edge);
  for (const auto& [root, rim] : holes) {
    Vec3 middle = Vec3::Zero();
    for (const DirectedEdge& edge : rim)
      middle += (boundary.points[edge[0]] + boundary.points[edge[1]]) / (2 * static_cast<double>(rim.size()));
    const auto centre = static_cast<std::uint32_t>(boundary.points.size());
    boundary.points.push_back(middle);
    for (const DirectedEdge& edge : rim) {
      boundary.triangles.push_back({edge[1], edge[0], centre});
      boundary.is_opening.push_back(1);
    }
  }
  return holes.size();
}

class CapFinder {
 public:
  explicit CapFinder(const Boundary& boundary) : boundary_(boundary), sets_(boundary.points.size()) {}

  /// @param outwards  1 if the boundary's triangles point out of it, else -1.
  std::vector<Cap> find(double outwards) {
    for_each_opening([&](std::size_t t) {
      for (std::size_t n = 1; n < 3; ++n) sets_.merge(boundary_.triangles[t][n], boundary_.triangles[t][0]);
    });
    std::map<std::uint32_t, std::size_t> number;
    std::vector<Cap> caps;
    for_each_opening([&](std::size_t t) {
      const auto [at, added] = number.try_emplace(sets_.find(boundary_.triangles[t][0]), caps.size());
      if (added) caps.emplace_back();
      caps[at->second].triangles.push_back(t);
    });
    for (Cap& cap : caps) measure(cap, outwards);
    std::erase_if(caps, [](const Cap& cap) { return !(cap.radius > 0); });
    return caps;
  }

 private:
  template <class Use>
  void for_each_opening(const Use& use) const {
    for (std::size_t t = 0; t < boundary_.triangles.size(); ++t)
      if (boundary_.is_opening[t] != 0) use(t);
  }
  void measure(Cap& cap, double outwards) const {
    AreaSum sum;
    for (const std::size_t t : cap.triangles)
      sum.add(boundary_.corner(t, 0), boundary_.corner(t, 1), boundary_.corner(t, 2));
    if (!(sum.normal.norm() > 0)) return;
    cap.middle = sum.centre();
    cap.normal = outwards * sum.normal.normalized();
    cap.radius = circle_radius(sum.area);
  }

  const Boundary& boundary_;
  DisjointSets sets_;  // Of points that triangles of openings join.
};

}  // namespace

Boundary boundary_of(const MeshView& mesh, Context& context) {
  Boundary boundary = given_boundary(mesh);
  if (boundary.triangles.empty())
    throw Error(ErrorKind::kBadInput, "the mesh has neither boundary triangles nor tetrahedra");
  if (const std::size_t holes = close_holes(boundary); holes > 0)
    context.warn(fmt::format("the surface has {} taken as {}",
                             counted(holes, "hole, which is", "holes, which are"),
                             holes == 1 ? "an opening" : "openings"));
  return boundary;
}

std::vector<Cap> caps_of(const Boundary& boundary, double outwards) {
  return CapFinder(boundary).find(outwards);
}

}  // namespace lumesh::centerline
