#include "lumesh/mesh/validate.hpp"

#include "lumesh/core/error.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/mesh/cell_faces.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "validate_impl.hpp"

namespace lumesh {
namespace {

using detail::check_each;
using detail::Findings;
using detail::NoScratch;

std::string name(VertexId v) {
  return "vertex " + std::to_string(v.value);
}
std::string name(TetId t) {
  return "tetrahedron " + std::to_string(t.value);
}
std::string face_name(TetId t, int face) {
  return "face " + std::to_string(face) + " of " + name(t);
}

void check_vertices(const TetMesh& mesh, ValidationReport& report) {
  check_each<NoScratch>(report, mesh.vertex_slots(), [&](std::size_t i, Findings& findings, NoScratch&) {
    const VertexId v(static_cast<std::uint32_t>(i));
    if (!mesh.alive(v)) return;
    if (!mesh.point(v).allFinite()) findings.add(name(v) + kNotFinite);
    const TetId t = mesh.incident_tet(v);
    if (t.valid() && (t.value >= mesh.tet_slots() || !mesh.alive(t) || mesh.index_of(t, v) < 0))
      findings.add(name(v) + " is linked to " + name(t) + ", which does not contain it");
  });
}

void check_tets(const TetMesh& mesh, ValidationReport& report) {
  check_each<NoScratch>(report, mesh.tet_slots(), [&](std::size_t i, Findings& findings, NoScratch&) {
    const TetId t(static_cast<std::uint32_t>(i));
    if (!mesh.alive(t)) return;
    for (const std::uint32_t v : mesh.tet(t))
      if (v >= mesh.vertex_slots() || !mesh.alive(VertexId(v))) {
        findings.add(name(t) + " has " + name(VertexId(v)) + ", which is not there");
        return;
      }
    for (int i = 0; i < 4; ++i)
      if (!mesh.corner(t, i).allFinite()) return;  // Reported with the vertex.
    const int sign = orient3d(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3));
    if (sign <= 0)
      findings.add(name(t) + " " + corners_text(mesh.tet(t)) + (sign == 0 ? " is flat" : " is inverted"));
  });
}

void check_face(const TetMesh& mesh, TetId t, int face, Findings& findings) {
  const FaceLink link = mesh.link(t, face);
  const PatchId behind = mesh.interface_patch(t, face);
  if (link.is_boundary()) {
    if (!link.patch().valid() || link.patch().value >= mesh.info().patches.size())
      findings.add(face_name(t, face) + " is on the boundary but its patch is not in the list");
    if (behind.valid())
      findings.add(face_name(t, face) + " is on the boundary but has an interface patch too");
    return;
  }
  const TetId u = link.tet();
  if (u == t || u.value >= mesh.tet_slots() || !mesh.alive(u)) {
    findings.add(face_name(t, face) + " is linked to " + name(u) + ", which cannot be its neighbour");
    return;
  }
  if (mesh.link(u, link.face()) != FaceLink::to(t, face))
    findings.add(face_name(t, face) + " is linked to " + face_name(u, link.face()) +
                 ", which is not linked back");
  if (!are_opposite_sides(mesh.face_corners(t, face), mesh.face_corners(u, link.face())))
    findings.add(face_name(t, face) + " " + corners_text(mesh.face_corners(t, face)) + " does not match " +
                 face_name(u, link.face()) + " " + corners_text(mesh.face_corners(u, link.face())));
  if (mesh.label(t) == mesh.label(u)) {
    if (behind.valid()) findings.add(face_name(t, face) + " lies within one label but has a patch");
  } else if (!behind.valid() || behind.value >= mesh.info().patches.size()) {
    findings.add(face_name(t, face) + " lies between two labels but has no patch of the list");
  } else if (behind != mesh.interface_patch(u, link.face())) {
    findings.add(face_name(t, face) + " has another patch than the other side");
  }
}

void check_faces(const TetMesh& mesh, ValidationReport& report) {
  check_each<NoScratch>(report, mesh.tet_slots(), [&](std::size_t i, Findings& findings, NoScratch&) {
    const TetId t(static_cast<std::uint32_t>(i));
    if (!mesh.alive(t)) return;
    for (int f = 0; f < 4; ++f) check_face(mesh, t, f, findings);
  });
}

struct StarScratch {
  VertexStar star;
  std::vector<std::uint32_t> neighbours;
};

/// The star of v must be complete, and its link a sphere or, on the outside, a disc: by its Euler number,
/// which is exact because a connected star has a connected link.
void check_star(const TetMesh& mesh, VertexId v, std::uint32_t tets_at_vertex, Findings& findings,
                StarScratch& scratch) {
  if (tets_at_vertex == 0) return findings.add(name(v) + " is used by no tetrahedron");
  if (!mesh.incident_tet(v).valid()) return findings.add(name(v) + " is used but linked to no tetrahedron");
  const auto star = scratch.star.gather(mesh, v);
  if (star.size() != tets_at_vertex) {
    findings.add(name(v) + ": only " + std::to_string(star.size()) + " of its " +
                 std::to_string(tets_at_vertex) + " tetrahedra are connected through faces at it");
    return;
  }
  auto& neighbours = scratch.neighbours;
  neighbours.clear();
  std::int64_t outside_faces = 0;
  bool on_patch = false;
  for (const TetId t : star)
    for (int i = 0; i < 4; ++i) {
      if (mesh.vertex(t, i) == v) continue;
      neighbours.push_back(mesh.tet(t)[i]);
      outside_faces += mesh.link(t, i).is_boundary();
      on_patch |= mesh.patch(t, i).valid();
    }
  std::ranges::sort(neighbours);
  const auto link_vertices = std::unique(neighbours.begin(), neighbours.end()) - neighbours.begin();
  const auto link_triangles = static_cast<std::int64_t>(star.size());
  const std::int64_t link_edges = (3 * link_triangles + outside_faces) / 2;
  if (link_vertices - link_edges + link_triangles != (outside_faces > 0 ? 1 : 2))
    findings.add(name(v) + ": its link is not a " + (outside_faces > 0 ? "disc" : "sphere") +
                 " (pinched vertex)");
  if (on_patch != (mesh.dimension(v) != VertexDimension::kVolume))
    findings.add(name(v) + (on_patch ? " lies on a patch but its dimension is that of the volume"
                                     : " lies on no patch but its dimension is that of a surface"));
}

void check_stars(const TetMesh& mesh, ValidationReport& report) {
  std::vector<std::uint32_t> tets_at_vertex(mesh.vertex_slots(), 0);
  for (std::uint32_t t = 0; t < mesh.tet_slots(); ++t)
    if (mesh.alive(TetId(t)))
      for (const std::uint32_t v : mesh.tet(TetId(t))) ++tets_at_vertex[v];
  check_each<StarScratch>(report, mesh.vertex_slots(),
                          [&](std::size_t i, Findings& findings, StarScratch& scratch) {
                            const VertexId v(static_cast<std::uint32_t>(i));
                            if (mesh.alive(v)) check_star(mesh, v, tets_at_vertex[i], findings, scratch);
                          });
}

}  // namespace

std::string ValidationReport::text() const {
  if (ok()) return "valid";
  std::string lines;
  for (const std::string& problem : problems) lines += problem + "\n";
  if (problem_count > problems.size())
    lines += "and " + std::to_string(problem_count - problems.size()) + " more problems\n";
  return lines;
}

ValidationReport validate(const TetMesh& mesh) {
  ValidationReport report;
  check_vertices(mesh, report);
  check_tets(mesh, report);
  if (report.ok()) check_faces(mesh, report);
  if (!report.ok()) return report;  // What follows walks by adjacency.
  check_stars(mesh, report);
  detail::check_label_surfaces(mesh, report);
  return report;
}

ValidationReport validate(const MeshView& view) {
  try {
    return validate(TetMesh::build(view));
  } catch (const Error& error) {
    ValidationReport report;
    report.problems.emplace_back(error.what());
    report.problem_count = 1;
    return report;
  }
}

}  // namespace lumesh
