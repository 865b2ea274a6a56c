#include "meshers.hpp"

#include "lumesh/adapt/improve.hpp"
#include "lumesh/delaunay/delaunay.hpp"
#include "lumesh/lattice/lattice.hpp"
#include "lumesh/operators/settling.hpp"

namespace lumesh::boundary {

namespace {

MixedMesh copy_of(const MeshView& view) {
  MixedMesh mesh;
  mesh.points.assign(view.points.begin(), view.points.end());
  mesh.tetrahedra.assign(view.tetrahedra.begin(), view.tetrahedra.end());
  mesh.tetrahedron_labels.assign(view.tetrahedron_labels.begin(), view.tetrahedron_labels.end());
  mesh.triangles.assign(view.triangles.begin(), view.triangles.end());
  mesh.triangle_patches.assign(view.triangle_patches.begin(), view.triangle_patches.end());
  mesh.info = *view.info;
  return mesh;
}

}  // namespace

std::string name_of(Mesher mesher) {
  return mesher == Mesher::kDelaunay ? "delaunay" : "lattice";
}

MixedMesh mesh_by(Mesher mesher, const LabelImage& image, const ImageDomain& domain, double spacing_mm) {
  Context context;
  if (mesher == Mesher::kLattice) {
    LatticeOptions options;
    options.spacing_mm = spacing_mm;
    return mesh_lattice(image, domain, options, context).mesh;
  }
  DelaunayOptions options;
  options.delta_mm = spacing_mm;
  DelaunayResult result = mesh_delaunay(domain, options, context);
  TetMesh& mesh = result.mesh;
  ImproveOptions improvement;  // As of the program.
  improvement.place = operators::places_in_domain(mesh, domain);
  improvement.keep_within = operators::within_cuts_of(domain);
  improvement.settles_all = result.report.held_back > 0;
  improve(mesh, improvement, context);
  const BoundaryFaces faces = mesh.boundary_faces();
  return copy_of(mesh.view(faces));
}

}  // namespace lumesh::boundary
