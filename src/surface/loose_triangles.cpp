#include "lumesh/surface/loose_triangles.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/findings.hpp"
#include "lumesh/surface/rims.hpp"

namespace lumesh::surfaces {
namespace {

/// A part over edges of two triangles.
struct OpenPart {
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint32_t> vertices;  // Ascending.
  double area_mm2 = 0;
  Vec3 area_vector = Vec3::Zero();
  std::size_t open_edges = 0;
  bool is_at_others = false;  // Over edges of three triangles or more.

  /// Triangles that are connected over edges so that the graph of their neighbours is a tree make a disc all
  /// of whose vertices lie on its rim: each but the first adds one vertex.
  [[nodiscard]] bool is_disc_without_inner_vertex() const { return vertices.size() == triangles.size() + 2; }
  [[nodiscard]] bool is_disc() const {  // Of Euler number 1.
    return open_edges > 0 &&
           2 * (vertices.size() + triangles.size()) == 3 * triangles.size() + open_edges + 2;
  }
  [[nodiscard]] bool is_loose(double whole_mm2) const {
    constexpr std::size_t kMax = 20;
    constexpr double kMaxShare = 1e-3;
    return triangles.size() <= kMax && !is_at_others && area_mm2 <= kMaxShare * whole_mm2 &&
           is_disc_without_inner_vertex();
  }
};

class OpenParts {
 public:
  explicit OpenParts(const TriangleMesh& surface) {
    const EdgeNeighbours neighbours = edge_neighbours(surface.triangles);
    std::vector<Cell<3>> alike = surface.triangles;
    const Parts parts = turn_alike(alike, neighbours);
    parts_.resize(parts.count);
    for (std::uint32_t t = 0; t < alike.size(); ++t) {
      OpenPart& part = parts_[parts.of_triangle[t]];
      const Vec3 vector = triangle_area_normal(surface.points, alike[t]) / 2;
      part.triangles.push_back(t);
      part.vertices.insert(part.vertices.end(), alike[t].begin(), alike[t].end());
      part.area_vector += vector;
      part.area_mm2 += vector.norm();
      whole_mm2_ += vector.norm();
      for (const std::uint32_t other : neighbours[t]) {
        if (other == kOpenEdge) ++part.open_edges;
        if (other == kCrowdedEdge) part.is_at_others = true;
      }
    }
    for (OpenPart& part : parts_) sort_unique(part.vertices);
  }
  [[nodiscard]] const std::vector<OpenPart>& all() const { return parts_; }
  [[nodiscard]] double whole_mm2() const { return whole_mm2_; }

  /// Discs by themselves that are almost flat and small beside the largest part.
  [[nodiscard]] std::vector<const OpenPart*> small_flat_discs(std::size_t points) const {
    constexpr double kMaxShare = 0.05, kFlat = 0.7;  // Of areas.
    std::vector<std::uint8_t> parts_at(points, 0);
    double largest = 0;
    for (const OpenPart& part : parts_) {
      largest = std::max(largest, part.area_mm2);
      for (const std::uint32_t v : part.vertices) parts_at[v] = parts_at[v] == 0 ? 1 : 2;
    }
    std::vector<const OpenPart*> discs;
    double sum = 0;
    for (const OpenPart& part : parts_)
      if (part.is_disc() && !part.is_at_others && !part.is_loose(whole_mm2_) &&
          part.area_mm2 < kMaxShare * largest && part.area_vector.norm() > kFlat * part.area_mm2 &&
          std::ranges::all_of(part.vertices, [&](std::uint32_t v) { return parts_at[v] == 1; })) {
        discs.push_back(&part);
        sum += part.area_mm2;
      }
    if (sum > kMaxShare * whole_mm2_) discs.clear();  // A wall in pieces.
    return discs;
  }

 private:
  std::vector<OpenPart> parts_;
  double whole_mm2_ = 0;
};

/// Points at the rims of holes in what is left without some parts.
std::vector<Vec3> hole_points_without(TriangleMesh surface, const std::vector<const OpenPart*>& parts) {
  std::vector<std::uint32_t> gone;
  for (const OpenPart* part : parts) gone.insert(gone.end(), part->triangles.begin(), part->triangles.end());
  std::ranges::sort(gone);
  without_triangles(surface, gone);
  const std::vector<Rim> rims = find_rims(surface);
  const std::vector<std::uint8_t> is_opening = rims_are_openings(surface, rims);
  std::vector<Vec3> points;
  for (std::size_t r = 0; r < rims.size(); ++r)
    if (is_opening[r] == 0)
      for (const std::uint32_t v : rims[r].vertices) points.push_back(surface.points[v]);
  return points;
}

}  // namespace

std::vector<std::uint32_t> loose_triangles(const TriangleMesh& surface) {
  const OpenParts parts(surface);
  if (parts.all().size() < 2) return {};
  std::vector<std::uint32_t> loose;
  for (const OpenPart& part : parts.all())
    if (part.is_loose(parts.whole_mm2()))
      loose.insert(loose.end(), part.triangles.begin(), part.triangles.end());
  std::ranges::sort(loose);
  return loose;
}

std::vector<StrayPiece> stray_pieces(const TriangleMesh& surface) {
  const OpenParts parts(surface);
  const std::vector<const OpenPart*> discs = parts.small_flat_discs(surface.points.size());
  if (discs.empty()) return {};
  const std::vector<Vec3> hole_points = hole_points_without(surface, discs);
  std::vector<StrayPiece> pieces;
  for (const OpenPart* part : discs) {
    Box3 box;
    for (const std::uint32_t v : part->vertices) box.extend(surface.points[v]);
    const double reach = box.diagonal().norm();
    const bool is_beside_hole =
        std::ranges::any_of(hole_points, [&](const Vec3& p) { return box.exteriorDistance(p) < reach; });
    if (!is_beside_hole)
      pieces.push_back({part->triangles, part->area_mm2,
                        triangle_centre(surface.points, surface.triangles[part->triangles.front()])});
  }
  return pieces;
}

}  // namespace lumesh::surfaces
