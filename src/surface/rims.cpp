#include "lumesh/surface/rims.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/surface/edges.hpp"

namespace lumesh::surfaces {
namespace {

using DirectedEdge = std::array<std::uint32_t, 2>;

std::vector<DirectedEdge> rim_edges(const TriangleMesh& surface) {
  const EdgeNeighbours neighbours = edge_neighbours(surface.triangles);
  std::vector<DirectedEdge> edges;
  for (std::size_t t = 0; t < neighbours.size(); ++t)
    for (std::size_t s = 0; s < 3; ++s)
      if (neighbours[t][s] == kOpenEdge)
        edges.push_back({surface.triangles[t][s], surface.triangles[t][(s + 1) % 3]});
  std::ranges::sort(edges);
  return edges;
}

/// Walks along edges, each once, and cuts a loop off whenever a vertex is reached that the walk has passed.
class LoopWalk {
 public:
  LoopWalk(std::size_t points, std::vector<DirectedEdge> edges)
      : edges_(std::move(edges)), is_used_(edges_.size(), 0), place_(points, kNotOnPath) {}

  std::vector<std::vector<std::uint32_t>> loops() {
    for (std::size_t first = 0; first < edges_.size(); ++first)
      if (is_used_[first] == 0) walk_from(edges_[first][0]);
    return std::move(loops_);
  }

 private:
  static constexpr std::uint32_t kNotOnPath = ~0U;

  void walk_from(std::uint32_t start) {
    path_ = {start};
    place_[start] = 0;
    while (!path_.empty()) {
      const std::size_t edge = free_edge_from(path_.back());
      if (edge == edges_.size()) {  // The end of a chain, or all loops here are cut off.
        place_[path_.back()] = kNotOnPath;
        path_.pop_back();
        continue;
      }
      is_used_[edge] = 1;
      const std::uint32_t next = edges_[edge][1];
      if (place_[next] == kNotOnPath) {
        place_[next] = static_cast<std::uint32_t>(path_.size());
        path_.push_back(next);
      } else {
        cut_off(place_[next]);
      }
    }
  }
  [[nodiscard]] std::size_t free_edge_from(std::uint32_t vertex) const {
    auto at =
        static_cast<std::size_t>(std::ranges::lower_bound(edges_, DirectedEdge{vertex, 0}) - edges_.begin());
    while (at < edges_.size() && edges_[at][0] == vertex && is_used_[at] != 0) ++at;
    return at < edges_.size() && edges_[at][0] == vertex ? at : edges_.size();
  }
  /// The part of the walk since it was at a place, which stays.
  void cut_off(std::uint32_t place) {
    std::vector<std::uint32_t> loop(path_.begin() + place, path_.end());
    for (std::size_t i = 1; i < loop.size(); ++i) place_[loop[i]] = kNotOnPath;
    path_.resize(place + 1);
    if (loop.size() > 2) loops_.push_back(std::move(loop));
  }

  std::vector<DirectedEdge> edges_;  // Ascending.
  std::vector<std::uint8_t> is_used_;
  std::vector<std::uint32_t> place_;  // On the path, of each vertex.
  std::vector<std::uint32_t> path_;
  std::vector<std::vector<std::uint32_t>> loops_;
};

}  // namespace

Rim measured_rim(std::span<const Vec3> points, std::vector<std::uint32_t> vertices) {
  Rim rim;
  rim.vertices = std::move(vertices);
  const std::size_t count = rim.vertices.size();
  const auto at = [&](std::size_t i) -> const Vec3& { return points[rim.vertices[i % count]]; };
  double length = 0;
  Vec3 area_vector = Vec3::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const double edge = (at(i + 1) - at(i)).norm();
    length += edge;
    rim.centre_mm += edge / 2 * (at(i) + at(i + 1));
    area_vector += (at(i + 1) - at(0)).cross(at(i) - at(0)) / 2;  // The cap runs against the surface.
  }
  rim.centre_mm = length > 0 ? Vec3(rim.centre_mm / length) : at(0);
  rim.mean_edge_mm = length / static_cast<double>(count);
  rim.area_mm2 = area_vector.norm();
  rim.radius_mm = circle_radius(rim.area_mm2);
  rim.normal = rim.area_mm2 > 0 ? Vec3(area_vector / rim.area_mm2) : Vec3(Vec3::Zero());
  for (std::size_t i = 0; i < count; ++i)
    rim.deviation_mm = std::max(rim.deviation_mm, std::abs(rim.height_mm(at(i))));
  return rim;
}

std::vector<Rim> find_rims(const TriangleMesh& surface) {
  std::vector<Rim> rims;
  for (std::vector<std::uint32_t>& loop : LoopWalk(surface.points.size(), rim_edges(surface)).loops())
    rims.push_back(measured_rim(surface.points, std::move(loop)));
  return rims;
}

std::optional<Vec3> place_of_seam(std::size_t count, const std::function<const Rim*(std::size_t)>& opening) {
  constexpr double kApart = 0.1, kOpposed = -0.9, kMaxRatio = 1.2;  // Of radii; cosine.
  std::vector<const Rim*> openings;
  for (std::size_t r = 0; r < count; ++r)
    if (const Rim* const rim = opening(r)) openings.push_back(rim);
  for (std::size_t i = 0; i < openings.size(); ++i)
    for (std::size_t k = i + 1; k < openings.size(); ++k) {
      const Rim &one = *openings[i], &other = *openings[k];
      const double smaller = std::min(one.radius_mm, other.radius_mm);
      if (one.normal.dot(other.normal) < kOpposed &&
          (one.centre_mm - other.centre_mm).norm() < kApart * smaller &&
          std::max(one.radius_mm, other.radius_mm) < kMaxRatio * smaller)
        return one.centre_mm;
    }
  return std::nullopt;
}

void turn_outwards(TriangleMesh& surface, std::vector<Rim>& rims) {
  const Parts parts = turn_alike(surface);
  std::vector<double> volumes(parts.count, 0);
  std::vector<std::uint32_t> part_at(surface.points.size(), 0);
  std::vector<Vec3> origin(parts.count);
  for (std::size_t t = surface.triangles.size(); t-- > 0;)
    origin[parts.of_triangle[t]] = surface.points[surface.triangles[t][0]];
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    const std::uint32_t part = parts.of_triangle[t];
    for (const std::uint32_t v : {a, b, c}) part_at[v] = part;
    volumes[part] +=
        tetrahedron_volume(origin[part], surface.points[a], surface.points[b], surface.points[c]);
  }
  for (const Rim& rim : rims)
    for (std::size_t i = 0; i < rim.vertices.size(); ++i) {
      const std::uint32_t a = rim.vertices[i], b = rim.vertices[(i + 1) % rim.vertices.size()];
      volumes[part_at[a]] +=
          tetrahedron_volume(origin[part_at[a]], surface.points[b], surface.points[a], rim.centre_mm);
    }
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    if (volumes[parts.of_triangle[t]] < 0) std::swap(surface.triangles[t][1], surface.triangles[t][2]);
  for (Rim& rim : rims)
    if (volumes[part_at[rim.vertices[0]]] < 0) {
      std::ranges::reverse(rim.vertices);
      rim.normal = -rim.normal;
    }
}

}  // namespace lumesh::surfaces
