// The surfaces of the labels: closed manifolds, their topology, and the volume they enclose.

#include <fmt/core.h>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/cell_faces.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "validate_impl.hpp"

namespace lumesh::detail {
namespace {

/// A face of the surface of `label`, pointing out of it.
struct SurfaceFace {
  Label label;
  Cell<3> corners;
  TetId tet;
  bool outside;  // Nothing behind it.
};

/// A side of a surface face.
struct SurfaceSide {
  Label label;
  TriangleSide side;
  auto operator<=>(const SurfaceSide&) const = default;
};

std::vector<SurfaceFace> surface_faces(const TetMesh& mesh) {
  return collect_from_tets<SurfaceFace>(mesh, [&](TetId t, std::vector<SurfaceFace>& out) {
    for (int f = 0; f < 4; ++f) {
      const FaceLink link = mesh.link(t, f);
      if (link.is_boundary() || mesh.label(link.tet()) != mesh.label(t))
        out.push_back({mesh.label(t), mesh.face_corners(t, f), t, link.is_boundary()});
    }
  });
}

/// Two faces on the outside with the same corners should have been neighbours.
void check_unlinked(const std::vector<SurfaceFace>& faces, ValidationReport& report) {
  std::vector<std::pair<Cell<3>, std::uint32_t>> outside;
  for (const SurfaceFace& face : faces)
    if (face.outside) outside.emplace_back(sorted_corners(face.corners), face.tet.value);
  parallel::sort(outside.begin(), outside.end());
  Findings findings;
  for (std::size_t i = 1; i < outside.size(); ++i)
    if (outside[i].first == outside[i - 1].first)
      findings.add("tetrahedra " + std::to_string(outside[i - 1].second) + " and " +
                   std::to_string(outside[i].second) + " share face " + corners_text(outside[i].first) +
                   " but are not linked");
  merge(report, findings);
}

LabelBoundary& entry_of(ValidationReport& report, Label label) {
  return *std::ranges::lower_bound(report.labels, label, {}, &LabelBoundary::label);
}

std::vector<SurfaceSide> surface_sides(const std::vector<SurfaceFace>& faces) {
  std::vector<SurfaceSide> sides(faces.size() * 3);
  parallel::for_each_index(faces.size(), [&](std::size_t i) {
    for (std::uint32_t k = 0; k < 3; ++k)
      sides[3 * i + k] = {faces[i].label, side_of(faces[i].corners, i, k)};
  });
  parallel::sort(sides.begin(), sides.end());
  return sides;
}

/// Joins faces across edges, and at each end the corners of the two faces; adds -E to the Euler numbers.
void join_at_edges(const std::vector<SurfaceFace>& faces, DisjointSets& surfaces, DisjointSets& corners,
                   ValidationReport& report) {
  const auto same = [](const SurfaceSide& a, const SurfaceSide& b) {
    return a.label == b.label && a.side.is_of_edge(b.side);
  };
  Findings findings;
  parallel::for_each_run(surface_sides(faces), same, [&](std::span<const SurfaceSide> edge) {
    const auto& [label, side] = edge[0];
    --entry_of(report, label).surface_euler;
    if (edge.size() != 2) {
      findings.add("edge " + corners_text(Cell<2>{side.low, side.high}) + " has " +
                   std::to_string(edge.size()) + " faces on the surface of label " + std::to_string(label) +
                   " instead of 2");
      return;
    }
    const TriangleSide& other = edge[1].side;
    surfaces.merge(side.triangle, other.triangle);
    // The two faces run along the edge in opposite directions: the end of one is the start of the other.
    corners.merge(3 * side.triangle + side.side, 3 * other.triangle + (other.side + 1) % 3);
    corners.merge(3 * side.triangle + (side.side + 1) % 3, 3 * other.triangle + other.side);
  });
  merge(report, findings);
}

/// Every vertex of a surface must have one ring of faces; adds V to the Euler numbers.
void check_rings(const std::vector<SurfaceFace>& faces, DisjointSets& corners, ValidationReport& report) {
  struct Corner {
    Label label;
    std::uint32_t vertex;
    std::uint32_t ring;
    auto operator<=>(const Corner&) const = default;
  };
  std::vector<Corner> all(faces.size() * 3);
  for (std::uint32_t i = 0; i < all.size(); ++i)
    all[i] = {faces[i / 3].label, faces[i / 3].corners[i % 3], corners.find(i)};
  parallel::sort(all.begin(), all.end());
  Findings findings;
  const auto same = [](const Corner& a, const Corner& b) {
    return a.label == b.label && a.vertex == b.vertex;
  };
  parallel::for_each_run(all, same, [&](std::span<const Corner> run) {
    std::size_t rings = 1;
    for (std::size_t i = 1; i < run.size(); ++i) rings += run[i].ring != run[i - 1].ring;
    ++entry_of(report, run[0].label).surface_euler;
    if (rings > 1)
      findings.add("vertex " + std::to_string(run[0].vertex) + " joins " + std::to_string(rings) +
                   " sheets of the surface of label " + std::to_string(run[0].label) + " (pinched vertex)");
  });
  merge(report, findings);
}

/// Fills report.labels with counts and volumes; the surface part starts at zero.
void count_labels(const TetMesh& mesh, ValidationReport& report) {
  std::vector<Label> labels;
  for (std::uint32_t t = 0; t < mesh.tet_slots(); ++t)
    if (mesh.alive(TetId(t)) && (labels.empty() || labels.back() != mesh.label(TetId(t))))
      labels.push_back(mesh.label(TetId(t)));
  sort_unique(labels);
  for (const Label label : labels) report.labels.push_back({.label = label});
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    const TetId t(i);
    if (!mesh.alive(t)) continue;
    LabelBoundary& entry = entry_of(report, mesh.label(t));
    ++entry.tet_count;
    entry.volume +=
        tetrahedron_volume(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3));
  }
}

/// The divergence theorem: a third of the flux of the position through a closed surface is the volume inside.
void check_volumes(const TetMesh& mesh, const std::vector<SurfaceFace>& faces, ValidationReport& report) {
  struct Flux {
    double sum = 0, magnitude = 0;
  };
  std::vector<Flux> flux(report.labels.size());
  if (faces.empty()) return;
  const Vec3& origin = mesh.point(VertexId(faces[0].corners[0]));  // Near the mesh, so that little cancels.
  for (const SurfaceFace& face : faces) {
    const auto& [a, b, c] = face.corners;
    const double term = (mesh.point(VertexId(a)) - origin)
                            .dot((mesh.point(VertexId(b)) - origin).cross(mesh.point(VertexId(c)) - origin)) /
                        6;
    Flux& entry = flux[static_cast<std::size_t>(&entry_of(report, face.label) - report.labels.data())];
    entry.sum += term;
    entry.magnitude += std::abs(term);
  }
  constexpr double kRounding =
      1e-11;  // Sums of up to 1e9 terms of random sign, and coordinates far from zero.
  Findings findings;
  for (std::size_t i = 0; i < flux.size(); ++i)
    if (std::abs(flux[i].sum - report.labels[i].volume) >
        kRounding * (flux[i].magnitude + report.labels[i].volume))
      findings.add("label " + std::to_string(report.labels[i].label) + ": its tetrahedra have volume " +
                   std::to_string(report.labels[i].volume) + " but its surface encloses " +
                   std::to_string(flux[i].sum));
  merge(report, findings);
}

/// Cells that are all positive and properly linked cover space once unless the outside crosses itself or a
/// piece lies within another.
void check_crossings(const TetMesh& mesh, const std::vector<SurfaceFace>& faces, ValidationReport& report) {
  std::vector<Cell<3>> outside;
  for (const SurfaceFace& face : faces)
    if (face.outside) outside.push_back(face.corners);
  std::vector<Vec3> points(mesh.vertex_slots(), Vec3::Zero());
  for (const Cell<3>& corners : outside)
    for (const std::uint32_t v : corners) points[v] = mesh.point(VertexId(v));
  Findings findings;
  for (const SelfCrossing& crossing : find_self_crossings(points, outside))
    findings.add(fmt::format("the outside crosses or touches itself at {}: faces {} and {}",
                             coordinates_text(crossing.place), corners_text(outside[crossing.first]),
                             corners_text(outside[crossing.second])));
  if (findings.count == 0 && report.ok())
    for (const Vec3& place : find_doubled_places(points, outside))
      findings.add("at " + coordinates_text(place) + " the mesh lies within itself");
  merge(report, findings);
}

}  // namespace

void check_label_surfaces(const TetMesh& mesh, ValidationReport& report) {
  count_labels(mesh, report);
  const std::vector<SurfaceFace> faces = surface_faces(mesh);
  check_unlinked(faces, report);
  DisjointSets surfaces(faces.size()), corners(faces.size() * 3);
  join_at_edges(faces, surfaces, corners, report);
  check_rings(faces, corners, report);
  for (std::uint32_t i = 0; i < faces.size(); ++i) {
    LabelBoundary& entry = entry_of(report, faces[i].label);
    ++entry.surface_euler;
    entry.surface_components += surfaces.find(i) == i;
  }
  Findings findings;
  for (const LabelBoundary& entry : report.labels)
    if (entry.surface_euler % 2 != 0)
      findings.add("the surface of label " + std::to_string(entry.label) + " has the odd Euler number " +
                   std::to_string(entry.surface_euler));
  merge(report, findings);
  check_volumes(mesh, faces, report);
  check_crossings(mesh, faces, report);
}

}  // namespace lumesh::detail
