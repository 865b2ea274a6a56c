#include "mesh_figures.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "lumesh/parallel/loops.hpp"

namespace lumesh::boundary {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The wall alone: its triangles, pointing outwards, and which points they use.
struct Wall {
  std::vector<Cell<3>> triangles;
  std::vector<std::uint32_t> vertices;
};

Wall wall_of(const MixedMesh& mesh) {
  Wall wall;
  std::vector<std::uint8_t> used(mesh.points.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto patch = static_cast<std::size_t>(mesh.triangle_patches[t]);
    if (mesh.info.patches[patch].kind != PatchKind::kWall) continue;
    wall.triangles.push_back(mesh.triangles[t]);
    for (const std::uint32_t v : mesh.triangles[t]) used[v] = 1;
  }
  for (std::uint32_t v = 0; v < used.size(); ++v)
    if (used[v] != 0) wall.vertices.push_back(v);
  return wall;
}

/// Distance to the cut planes at which the object leaves the image, in mm; infinite if there are none.
double distance_to_cuts(const ImageDomain& domain, const Vec3& point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const CutPlane& plane : domain.cut_planes())
    nearest = std::min(nearest, -plane.normal.dot(point - plane.point_mm));
  return nearest;
}

/// Which places count: those that are far enough from cuts.
struct Range {
  const ImageDomain& domain;
  double from_cuts_mm;

  [[nodiscard]] bool holds(const Vec3& point) const {
    return distance_to_cuts(domain, point) >= from_cuts_mm;
  }
};

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Outward normals of vertices, those of the facets weighted by their angles (Thürmer and Wüthrich 1998,
/// doi:10.1080/10867651.1998.10487487).
std::vector<Vec3> vertex_normals(const std::vector<Vec3>& points, const Wall& wall) {
  std::vector<Vec3> normals(points.size(), Vec3::Zero());
  for (const Cell<3>& triangle : wall.triangles) {
    const std::array<Vec3, 3> p = {points[triangle[0]], points[triangle[1]], points[triangle[2]]};
    const Vec3 normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vec3& here = p[corner];
      normals[triangle[corner]] +=
          angle_between(p[(corner + 1) % 3] - here, p[(corner + 2) % 3] - here) * normal;
    }
  }
  return normals;
}

/// Places at the vertices of the wall that count: neither near the border nor at a sharp crease.
std::vector<WallSample> vertex_samples(const Shape& shape, const std::vector<Vec3>& points, const Wall& wall,
                                       const Range& range) {
  const std::vector<Vec3> normals = vertex_normals(points, wall);
  std::vector<WallSample> samples;
  for (const std::uint32_t v : wall.vertices) {
    WallSample s;
    s.point_mm = shape.on_surface(points[v]);
    if (!range.holds(s.point_mm) || (shape.near_crease && shape.near_crease(s.point_mm))) continue;
    s.normal = shape.inward_normal(s.point_mm);
    s.offset_mm = -s.normal.dot(points[v] - s.point_mm);
    s.angle_deg = angle_between(-normals[v], s.normal) * 180 / std::numbers::pi;
    samples.push_back(s);
  }
  return samples;
}

/// From a point near it to the boundary, by steps along the gradient; > 0 outside.
double distance_to_boundary(const ImageDomain& domain, const Vec3& point) {
  constexpr int kSteps = 6;
  constexpr double kLongest = 0.5;
  Vec3 p = point;
  for (int step = 0; step < kSteps; ++step) {
    const FieldSample s = domain.separation(p, 1, 0);
    Vec3 move = -s.value / std::max(1e-12, s.gradient.squaredNorm()) * s.gradient;
    if (move.norm() > kLongest) move *= kLongest / move.norm();
    p += move;
  }
  return (domain.separation_value(point, 1, 0) > 0 ? -1 : 1) * (p - point).norm();
}

double volume_of(const MixedMesh& mesh) {
  double volume = 0;
  for (const Cell<4>& t : mesh.tetrahedra) {
    const Vec3& a = mesh.points[t[0]];
    volume += (mesh.points[t[1]] - a).cross(mesh.points[t[2]] - a).dot(mesh.points[t[3]] - a) / 6;
  }
  return volume;
}

/// Twice the area that the triangles enclose in the plane through `origin` across the direction.
double doubled_section(const std::vector<Vec3>& points, const Wall& wall, const Vec3& origin,
                       const Vec3& direction) {
  double doubled = 0;
  for (const Cell<3>& triangle : wall.triangles) {
    std::array<double, 3> height{};
    for (std::size_t c = 0; c < 3; ++c) height[c] = (points[triangle[c]] - origin).dot(direction);
    Vec3 leaves = Vec3::Zero(), enters = Vec3::Zero();
    int crossings = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t d = (c + 1) % 3;
      if ((height[c] >= 0) == (height[d] >= 0)) continue;
      const double t = height[c] / (height[c] - height[d]);
      (height[c] >= 0 ? leaves : enters) =
          points[triangle[c]] + t * (points[triangle[d]] - points[triangle[c]]) - origin;
      ++crossings;
    }
    if (crossings == 2) doubled += leaves.cross(enters).dot(direction);
  }
  return std::abs(doubled);
}

/// Mean over sections across a tube, wholly inside the image, of the radius of a circle of their area: its
/// error in per cent.
double section_radius_percent(const Shape& shape, const std::vector<Vec3>& points, const Wall& wall,
                              const Range& range) {
  if (!shape.tube) return kNaN;
  const Tube& tube = *shape.tube;
  const double reach = shape.frame.size.cast<double>().cwiseProduct(shape.frame.spacing_mm).norm();
  double sum = 0;
  int count = 0;
  for (double along = -reach; along <= reach; along += 0.77) {
    const Vec3 origin = tube.centre_mm + along * tube.direction;
    const Vec3 half = (tube.radius_mm * (Vec3::Ones() - tube.direction.cwiseAbs2()).cwiseMax(0).cwiseSqrt());
    if (!range.holds(origin - half) || !range.holds(origin + half)) continue;
    sum += std::sqrt(0.5 * doubled_section(points, wall, origin, tube.direction) / std::numbers::pi);
    ++count;
  }
  return count == 0 ? kNaN : 100 * (sum / count / tube.radius_mm - 1);
}

}  // namespace

double exact_volume_mm3(const Shape& shape) {
  constexpr int kRefinement = 3;
  const ImageFrame& f = shape.frame;
  const auto rows =
      static_cast<std::size_t>(f.size.y() * kRefinement) * static_cast<std::size_t>(f.size.z() * kRefinement);
  const auto sum_rows = [&](std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t row = begin; row < end; ++row) {
      const auto width = static_cast<std::size_t>(f.size.y() * kRefinement);
      Vec3 index(0, static_cast<double>(row % width), static_cast<double>(row / width));
      for (int i = 0; i < f.size.x() * kRefinement; ++i) {
        index.x() = i;
        const Vec3 centre = (index + Vec3::Constant(0.5)) / kRefinement - Vec3::Constant(0.5);
        sum += std::clamp(0.5 + shape.depth_mm(f.to_physical(centre)) * kRefinement, 0.0, 1.0);
      }
    }
    return sum;
  };
  const double sum =
      parallel::reduce_blocks(rows, 64, 0.0, sum_rows, [](double a, double b) { return a + b; });
  return sum * f.voxel_volume_mm3() / std::pow(kRefinement, 3);
}

MeshFigures measure_mesh(const Shape& shape, const LabelImage& image, const ImageDomain& domain,
                         const MixedMesh& mesh, double spacing_mm) {
  MeshFigures figures;
  const Wall wall = wall_of(mesh);
  figures.tetrahedra = mesh.tetrahedra.size();
  figures.wall_vertices = wall.vertices.size();
  const Range range{domain, 4 + spacing_mm};
  double square = 0;
  std::size_t count = 0;
  for (const std::uint32_t v : wall.vertices) {
    const Vec3& point = mesh.points[v];
    const double distance = distance_to_boundary(domain, point);
    if (!range.holds(point)) {
      if (std::abs(distance) <= figures.border_distance_max_mm) continue;
      figures.border_distance_max_mm = std::abs(distance);
      figures.border_worst_mm = point;
      continue;
    }
    ++count;
    figures.distance_max_mm = std::max(figures.distance_max_mm, std::abs(distance));
    figures.lift_mm += distance;
    square += distance * distance;
  }
  figures.lift_mm /= static_cast<double>(std::max<std::size_t>(1, count));
  figures.distance_rms_mm = std::sqrt(square / static_cast<double>(std::max<std::size_t>(1, count)));
  figures.wall = deviation_of(shape, vertex_samples(shape, mesh.points, wall, range));
  figures.section_radius_percent = section_radius_percent(shape, mesh.points, wall, range);
  std::vector<Vec3> exact = mesh.points;
  for (const std::uint32_t v : wall.vertices) exact[v] = shape.on_surface(exact[v]);
  figures.floor = deviation_of(shape, vertex_samples(shape, exact, wall, range));
  figures.floor_section_radius_percent = section_radius_percent(shape, exact, wall, range);
  const double exact_volume = exact_volume_mm3(shape);
  figures.volume_percent = 100 * (volume_of(mesh) / exact_volume - 1);
  const LabelTopology voxels = union_topology(image);
  figures.voxel_volume_percent = 100 * (voxels.volume_mm3 / exact_volume - 1);
  return figures;
}

}  // namespace lumesh::boundary
