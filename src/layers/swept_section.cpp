#include "swept_section.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/smoothstep.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/cell_faces.hpp"
#include "lumesh/mesh/edge_key.hpp"
#include "lumesh/mesh/edge_loops.hpp"

namespace lumesh::layers {
namespace {

/// Whether a patch surrounds others of the section, as a wall does the lumen: its rim has several loops.
bool is_ring(const SweptSection& s, std::int32_t p) {
  std::set<std::uint64_t> rim;
  for (const PatchFace& face : s.faces)
    if (face.patch == p) toggle_edges(face.corners, rim);
  return s.patches.size() > 1 && loop_count(rim) > 1;
}

/// Edges with one face of the section, as that runs.
std::vector<std::pair<std::uint32_t, std::uint32_t>> rim_of(const SweptSection& s) {
  std::map<std::uint64_t, int> count;
  for (const PatchFace& face : s.faces)
    for_each_edge_of(face.corners,
                     [&](std::uint32_t from, std::uint32_t to) { ++count[edge_key(from, to)]; });
  std::vector<std::pair<std::uint32_t, std::uint32_t>> rim;
  for (const PatchFace& face : s.faces)
    for_each_edge_of(face.corners, [&](std::uint32_t from, std::uint32_t to) {
      if (count.at(edge_key(from, to)) == 1) rim.emplace_back(from, to);
    });
  return rim;
}

std::vector<std::uint32_t> key_of(std::vector<std::uint32_t> corners) {
  sort_unique(corners);
  return corners;
}

}  // namespace

Vec3 SweptSection::swept(const Vec3& point, std::uint32_t v, double along_mm) const {
  const Vec3 place = point + towards_circle(point, v, along_mm);
  return place + ramp.displacement(place - centre_mm, along_mm) + along_mm * axis;
}

/// The way that a vertex goes across the axis until so far along it.
Vec3 SweptSection::towards_circle(const Vec3& point, std::uint32_t v, double along_mm) const {
  if (of_circle.empty()) return Vec3::Zero();
  const double ramp = smoothstep(along_mm, transition_mm);
  const Vec3 off = point - centre_mm;
  return ramp * (of_circle[rank_in(vertices, v)] - 1) * (off - off.dot(axis) * axis);
}

Vec3 SectionFinder::area_normal(std::span<const std::uint32_t> face) const {
  Vec3 normal = 0.5 * triangle_area_normal(point(face[0]), point(face[1]), point(face[2]));
  if (face.size() == 4) normal += 0.5 * triangle_area_normal(point(face[0]), point(face[2]), point(face[3]));
  return normal;
}

Vec3 SectionFinder::middle_of(std::span<const std::uint32_t> face) const {
  Vec3 sum = Vec3::Zero();
  for (const std::uint32_t v : face) sum += point(v);
  return sum / static_cast<double>(face.size());
}

/// Mean normal of each patch, over all of its faces.
std::vector<Vec3> SectionFinder::patch_normals() const {
  std::vector<Vec3> sums(mesh_.info.patches.size(), Vec3::Zero());
  for_each_patch_face(mesh_, [&](std::span<const std::uint32_t> face, std::int32_t p) {
    sums[static_cast<std::size_t>(p)] += area_normal(face);
  });
  for (Vec3& sum : sums) sum.stableNormalize();
  return sums;
}

/// Patches of openings that share edges with this one and look the same way, one after the other.
std::vector<std::int32_t> SectionFinder::joined_openings(std::int32_t first) const {
  constexpr double kOnePlane = 0.999;
  const std::vector<Vec3> normals = patch_normals();
  const auto looks_alike = [&](std::int32_t p) {
    return normals[static_cast<std::size_t>(p)].dot(normals[static_cast<std::size_t>(first)]) > kOnePlane;
  };
  std::map<std::uint64_t, std::vector<std::int32_t>> at_edge;
  for_each_patch_face(mesh_, [&](std::span<const std::uint32_t> face, std::int32_t p) {
    if (patch(p).kind != PatchKind::kOpening) return;
    for_each_edge_of(face,
                     [&](std::uint32_t from, std::uint32_t to) { at_edge[edge_key(from, to)].push_back(p); });
  });
  std::vector<std::int32_t> joined = {first};
  for (std::size_t i = 0; i < joined.size(); ++i)
    for (const auto& [edge, at] : at_edge) {
      if (std::ranges::find(at, joined[i]) == at.end()) continue;
      for (const std::int32_t p : at)
        if (std::ranges::find(joined, p) == joined.end() && looks_alike(p)) joined.push_back(p);
    }
  return joined;
}

SweptSection SectionFinder::section_at(std::int32_t first) const {
  SweptSection s;
  s.patches = joined_openings(first);
  AreaSum sum;
  double edges_mm = 0;
  std::map<std::int32_t, double> area_of;
  std::size_t edge_count = 0;
  for_each_patch_face(mesh_, [&](std::span<const std::uint32_t> face, std::int32_t p) {
    if (!s.has(p)) return;
    s.faces.push_back({{face.begin(), face.end()}, p});
    s.vertices.insert(s.vertices.end(), face.begin(), face.end());
    const Vec3 normal = area_normal(face);
    area_of[p] += normal.norm();
    sum.add(normal, middle_of(face));
    for_each_edge_of(face,
                     [&](std::uint32_t a, std::uint32_t b) { edges_mm += (point(a) - point(b)).norm(); });
    edge_count += face.size();
  });
  if (s.faces.empty()) return s;
  sort_unique(s.vertices);
  s.normal = sum.normal.normalized();
  s.centre_mm = sum.centre();
  s.edge_mm = edges_mm / static_cast<double>(edge_count);
  for (const std::uint32_t v : s.vertices) s.reach_mm = std::max(s.reach_mm, (point(v) - s.centre_mm).norm());
  s.axis = axis_at(s);
  double largest_mm2 = 0;
  for (const auto& [p, area] : area_of)
    if (!is_ring(s, p)) largest_mm2 = std::max(largest_mm2, area);
  if (const double hollow_mm2 = hollow_lumen_mm2(s, sum.area); hollow_mm2 > 0) largest_mm2 = hollow_mm2;
  s.radius_mm = circle_radius(largest_mm2 * s.axis.dot(s.normal));
  return s;
}

/// Area of the largest hole of the whole section, where that is a hollow wall's: of a quarter of the
/// section or more, as Opening::is_hollow(). Else 0.
double SectionFinder::hollow_lumen_mm2(const SweptSection& s, double section_mm2) const {
  constexpr double kMin = 0.25;
  const auto rim = rim_of(s);
  DisjointSets loops(s.vertices.size());
  const auto number = [&](std::uint32_t v) { return rank_in(s.vertices, v); };
  for (const auto& [from, to] : rim) loops.merge(number(from), number(to));
  std::map<std::uint32_t, double> area_of;  // Negative within holes, whose edges run the other way.
  for (const auto& [from, to] : rim)
    area_of[loops.find(number(from))] +=
        0.5 * (point(from) - s.centre_mm).cross(point(to) - s.centre_mm).dot(s.normal);
  double largest_mm2 = 0;
  for (const auto& [loop, area] : area_of) largest_mm2 = std::max(largest_mm2, -area);
  return largest_mm2 < kMin * section_mm2 ? 0 : largest_mm2;
}

/// The vessel's direction in the section; the normal where the walls do not say one, and where it is that
/// within what facets and noise turn it by.
Vec3 SectionFinder::axis_at(SweptSection& s) const {
  constexpr double kMinCos = 0.4, kSquare = 0.997;
  constexpr double kClear = 0.15, kUnclear = 0.3;  // What walls differ by, as sines.
  WallDirection axis = wall_direction(s, s.reach_mm);
  if (axis.left > kClear)  // Something may join the vessel further in.
    if (const WallDirection near = wall_direction(s, 0.5 * s.reach_mm); near.left < axis.left) axis = near;
  s.is_rough = axis.left > kClear;
  s.is_clear = axis.left < kUnclear && axis.along.dot(s.normal) > kMinCos;
  return s.is_clear && axis.along.dot(s.normal) < kSquare ? axis.along : s.normal;
}

/// Calls a function with the places of walls at most so deep before a section, from its centre, and their
/// unit normals and areas. Faces as long as the section's reach count by parts: their middles alone, as of
/// the long triangles that decimation leaves of a straight wall, would be at few depths, or none.
template <class Function>
void SectionFinder::for_each_wall_before(const SweptSection& s, double depth_mm,
                                         const Function& function) const {
  for_each_patch_face(mesh_, [&](std::span<const std::uint32_t> face, std::int32_t p) {
    if (patch(p).kind != PatchKind::kWall) return;
    const Vec3 normal = area_normal(face);
    const double area = normal.norm();
    if (!(area > 0)) return;
    const std::vector<Vec3> middles = middles_of_parts(face, s.reach_mm);
    for (const Vec3& middle : middles) {
      const Vec3 off = middle - s.centre_mm;
      if (std::abs(off.dot(s.normal)) > depth_mm || off.norm() > 1.5 * s.reach_mm) continue;
      function(off, Vec3(normal / area), area / static_cast<double>(middles.size()));
    }
  });
}

/// Middle of the face, or middles of parts a third as long as `long_mm`, alike in each of its triangles.
std::vector<Vec3> SectionFinder::middles_of_parts(std::span<const std::uint32_t> face, double long_mm) const {
  constexpr double kParts = 3, kMaxParts = 64;
  double longest_mm = 0;
  for_each_edge_of(face, [&](std::uint32_t a, std::uint32_t b) {
    longest_mm = std::max(longest_mm, (point(a) - point(b)).norm());
  });
  if (longest_mm <= long_mm) return {middle_of(face)};
  const double parts = std::min(kMaxParts, std::ceil(kParts * longest_mm / long_mm));
  std::vector<Vec3> middles;
  for (std::size_t c = 2; c < face.size(); ++c) {
    const Vec3 a = point(face[0]), u = (point(face[c - 1]) - a) / parts, v = (point(face[c]) - a) / parts;
    for (int i = 0; i < parts; ++i)
      for (int j = 0; i + j < parts; ++j) {
        middles.emplace_back(a + (i + 1.0 / 3) * u + (j + 1.0 / 3) * v);
        if (i + j + 1 < parts) middles.emplace_back(a + (i + 2.0 / 3) * u + (j + 2.0 / 3) * v);
      }
  }
  return middles;
}

/// Direction of a vessel that bends and widens evenly before the section, with the normal N of the section:
/// all wall normals n at depth d have n (N + t + d b) = c + d e, solved for t, b, c and e by least squares
/// over the walls at most so deep. Derived in docs/stages/layers.md, "Direction of an opening's vessel".
SectionFinder::WallDirection SectionFinder::wall_direction(const SweptSection& s, double depth_mm) const {
  constexpr double kMinPart = 1e-3;  // Of the largest eigenvalue.
  using Vec6 = Eigen::Matrix<double, 6, 1>;
  const Vec3 u = s.normal.unitOrthogonal(), v = s.normal.cross(u);
  Eigen::Matrix<double, 6, 6> sums = Eigen::Matrix<double, 6, 6>::Zero();
  Vec6 right = Vec6::Zero();
  double area = 0, squares = 0;
  for_each_wall_before(s, depth_mm, [&](const Vec3& off, const Vec3& n, double weight) {
    const double depth = -off.dot(s.normal) / depth_mm;
    Vec6 row;
    row << n.dot(u), n.dot(v), depth * n.dot(u), depth * n.dot(v), -1, -depth;
    const double given = -n.dot(s.normal);
    sums += weight * row * row.transpose();
    right += weight * given * row;
    squares += weight * given * given;
    area += weight;
  });
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(sums);
  if (!(area > 0) || !(solver.eigenvalues()[0] > kMinPart * solver.eigenvalues()[5])) return {};
  const Vec6 fit = sums.ldlt().solve(right);
  return {(s.normal + fit[0] * u + fit[1] * v).normalized(),
          std::sqrt(std::max(0.0, squares - fit.dot(right)) / area)};
}

void SectionFinder::find_labels(SweptSection& s) const {
  std::vector<bool> is_at(mesh_.points.size(), false);
  for (const std::uint32_t v : s.vertices) is_at[v] = true;
  std::map<std::vector<std::uint32_t>, Label> behind;
  const auto look_at = [&](const auto& cells, const std::vector<Label>& labels) {
    for (std::size_t c = 0; c < cells.size(); ++c) {
      const auto count = std::ranges::count_if(cells[c], [&](std::uint32_t v) { return is_at[v]; });
      if (count < 3) continue;
      for (const LocalFace& face : faces_of_cell(cells[c].size())) {
        std::vector<std::uint32_t> corners;
        for (const std::uint8_t i : face) corners.push_back(cells[c][i]);
        behind[key_of(std::move(corners))] = labels[c];
      }
    }
  };
  for_each_cell_list(look_at, mesh_);
  for (PatchFace& face : s.faces) face.label = behind.at(key_of(face.corners));
}

/// The slopes are those of the first one or two rings of the wall: further in it may taper otherwise.
void SectionFinder::find_ramp(SweptSection& s, double row_mm, double most_mm) const {
  constexpr double kDepth = 0.15, kRows = 1.25;
  if (!s.is_clear) return;
  WallRamp ramp(s.axis, s.reach_mm);
  for_each_wall_before(
      s, std::max(kDepth * s.reach_mm, kRows * row_mm),
      [&](const Vec3& off, const Vec3& normal, double area) { ramp.add_wall(off, normal, area); });
  ramp.fit();
  ramp.set_length(std::min(WallRamp::kRadii * s.radius_mm, most_mm));
  double steepest = 0;
  for (const std::uint32_t v : s.vertices)
    steepest = std::max(steepest, ramp.slope(point(v) - s.centre_mm).norm());
  ramp.limit(steepest, s.axis.dot(s.normal));
  s.ramp = ramp;
}

/// Rays from the centre to the vertices, until the rim, along which the section is scaled to a circle.
bool SectionFinder::find_circle(SweptSection& s, double transition_mm) const {
  const Vec3 u = s.axis.unitOrthogonal(), v = s.axis.cross(u);
  const auto flat = [&](std::uint32_t at) {
    const Vec3 off = point(at) - s.centre_mm;
    return Vec2(u.dot(off), v.dot(off));
  };
  std::vector<std::pair<Vec2, Vec2>> rim;
  double doubled_mm2 = 0, of_unit_circle = 0;
  for (const auto& [from, to] : rim_of(s)) {
    const auto& [p, q] = rim.emplace_back(flat(from), flat(to));
    const double across = p.x() * q.y() - p.y() * q.x();
    doubled_mm2 += across;
    of_unit_circle += across / (p.norm() * q.norm());
  }
  const double radius_mm = std::sqrt(doubled_mm2 / of_unit_circle);
  std::vector<double> factors;
  bool is_star = doubled_mm2 > 0 && of_unit_circle > 1;  // 2.6 to 2 pi; of a ring 0, but for rounding.
  for (const std::uint32_t at : s.vertices) {
    const Vec2 ray = flat(at);
    int hits = 0;
    double rim_mm = radius_mm;
    for (const auto& [p, q] : rim) {
      const double before = ray.x() * p.y() - ray.y() * p.x(), after = ray.x() * q.y() - ray.y() * q.x();
      if (!(before <= 0 && after > 0)) continue;  // Passes the ray's line anticlockwise.
      const Vec2 hit = p + before / (before - after) * (q - p);
      if (hit.dot(ray) <= 0) continue;
      ++hits;
      rim_mm = hit.norm();
    }
    is_star = is_star && (hits == 1 || ray.norm() < 1e-9 * radius_mm);
    factors.push_back(radius_mm / rim_mm);
  }
  if (!is_star) return false;
  s.transition_mm = transition_mm;
  s.of_circle = std::move(factors);
  return true;
}

}  // namespace lumesh::layers
