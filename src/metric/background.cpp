#include "background.hpp"

#include <algorithm>
#include <bit>

#include "lumesh/metric/measures.hpp"

namespace lumesh::metric {
namespace {

constexpr int kLongestWalk = 100000;
constexpr double kRounding = 1e-9;  // Of weights, of a point on a face.

using Weights = std::array<double, 4>;

/// Barycentric coordinates of a point, by signed volumes; they sum to 1, but in a tetrahedron that is flat
/// within rounding: there only their signs mean something.
Weights barycentric(const TetMesh& mesh, TetId t, const Vec3& point) {
  Weights weights{};
  double sum = 0;
  for (int f = 0; f < 4; ++f) {
    const auto [i, j, k] = kTetFaces[f];
    const Vec3& a = mesh.corner(t, i);
    // The face's normal points away from vertex f.
    weights[f] = -triple_product(mesh.corner(t, j) - a, mesh.corner(t, k) - a, point - a);
    sum += weights[f];
  }
  if (sum > 0)
    for (double& weight : weights) weight /= sum;
  return weights;
}

/// Walks through the face the point lies farthest behind, until there is none or the boundary is met. A point
/// on a face or an edge may, by rounding, lie behind faces of all tetrahedra there: the walk, which depends
/// on where it is alone, then may cycle, and is cut short to where kLongestWalk steps would end.
TetId walk_to(const TetMesh& mesh, TetId t, const Vec3& point, Weights& weights) {
  TetId marked = t;  // Where it was after as many steps as the last power of two, and this many steps.
  int steps_to_marked = 0, last_step = kLongestWalk;
  for (int step = 0;; ++step) {
    if (step > 0 && t == marked)
      last_step = step + (kLongestWalk - step) % (step - steps_to_marked);
    else if (std::has_single_bit(static_cast<unsigned>(step))) {
      marked = t;
      steps_to_marked = step;
    }
    weights = barycentric(mesh, t, point);
    TetId next;
    double largest = 0;
    for (int f = 0; f < 4; ++f) {
      const FaceLink link = mesh.link(t, f);
      if (weights[f] >= largest || link.is_boundary()) continue;
      largest = weights[f];
      next = link.tet();
    }
    if (!next.valid() || step == last_step) return t;
    t = next;
  }
}

bool is_inside(const Weights& weights) {
  return *std::ranges::min_element(weights) >= -kRounding;
}

Weights brought_inside(Weights weights) {
  double sum = 0;
  for (double& weight : weights) {
    weight = std::max(weight, 0.0);
    sum += weight;
  }
  if (!(sum > 0)) return {0.25, 0.25, 0.25, 0.25};  // A flat one: its vertices lie together.
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// Faces of the outside alone. @param behind  Their tetrahedra.
TriangleTree tree_of_boundary(const TetMesh& mesh, std::vector<TetId>& behind) {
  const BoundaryFaces faces = mesh.boundary_faces();
  std::vector<Cell<3>> triangles;
  for (std::size_t i = 0; i < faces.triangles.size(); ++i) {
    if (faces.tets[i][1].valid()) continue;
    triangles.push_back(faces.triangles[i]);
    behind.push_back(faces.tets[i][0]);
  }
  return {mesh.points(), triangles};
}

}  // namespace

Background::Background(TetMesh mesh) : mesh_(std::move(mesh)), boundary_(tree_of_boundary(mesh_, behind_)) {}

Background::Place Background::locate(const Vec3& point, TetId start) const {
  Place place;
  place.tet = walk_to(mesh_, start, point, place.weights);
  if (!is_inside(place.weights)) {
    // No boundary lies between the point and the nearest one of the boundary.
    const TriangleTree::Nearest nearest = boundary_.nearest(point);
    const TetId behind = behind_[nearest.triangle];
    place.tet = walk_to(mesh_, behind, point, place.weights);
    if (!is_inside(place.weights)) place = {behind, barycentric(mesh_, behind, nearest.point)};
  }
  place.weights = brought_inside(place.weights);
  return place;
}

}  // namespace lumesh::metric
