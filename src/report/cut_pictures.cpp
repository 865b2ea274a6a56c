#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "cut_cells.hpp"
#include "cut_window.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/metric_fault.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/metric/measures.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"
#include "scene.hpp"
#include "widest_section.hpp"

namespace lumesh::report {

namespace {

using quality::MeshSurface;

/// The part of a triangle on the side of the plane away from its normal.
std::vector<Vec3> clip(const std::array<Vec3, 3>& triangle, const CutPlane& plane) {
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 &a = triangle[i], &b = triangle[(i + 1) % 3];
    const double at_a = plane.normal.dot(a - plane.point_mm), at_b = plane.normal.dot(b - plane.point_mm);
    if (at_a <= 0) kept.push_back(a);
    if ((at_a <= 0) != (at_b <= 0)) kept.push_back(a + (b - a) * (at_a / (at_a - at_b)));
  }
  return kept;
}

/// The cells of one shape that a plane cuts, in their order.
template <std::size_t N>
std::vector<std::uint32_t> cut_by(std::span<const Vec3> points, std::span<const Cell<N>> cells,
                                  const CutPlane& plane) {
  return parallel::collect<std::uint32_t>(
      cells.size(), 16384, [&](std::size_t i, std::vector<std::uint32_t>& out) {
        bool above = false, below = false;
        for (const std::uint32_t v : cells[i])
          (plane.normal.dot(points[v] - plane.point_mm) > 0 ? above : below) = true;
        if (above && below) out.push_back(static_cast<std::uint32_t>(i));
      });
}

/// Calls visit(cell, section) for every cell that the plane cuts.
template <class Visit>
void for_each_section(const MeshView& mesh, const CutPlane& plane, const Visit& visit) {
  const auto of_shape = [&](const auto& cells, const auto& edges) {
    for (const std::uint32_t i : cut_by(mesh.points, cells, plane)) {
      const std::vector<Vec3> section = cut_cell(mesh.points, cells[i], edges, plane);
      if (section.size() >= 3) visit(cells[i], section);
    }
  };
  of_shape(mesh.tetrahedra, kTetEdges);
  of_shape(mesh.pyramids, kPyramidEdges);
  of_shape(mesh.prisms, kPrismEdges);
  of_shape(mesh.hexahedra, kHexahedronEdges);
}

/// Mean ratio in the metric of the mesh; -1 where that is none.
double metric_quality(const MeshView& mesh, const Cell<4>& cell) {
  std::array<SymTensor, 4> logs;
  for (std::size_t i = 0; i < 4; ++i) {
    if (!is_metric(mesh.metric[cell[i]])) return -1;
    logs[i] = metric::log(mesh.metric[cell[i]]);
  }
  return metric::mean_ratio(mesh.points[cell[0]], mesh.points[cell[1]], mesh.points[cell[2]],
                            mesh.points[cell[3]], logs[0], logs[1], logs[2], logs[3]);
}

Colour cell_colour(const MeshView& mesh, const Cell<4>& cell, CutColours colours) {
  return quality_colour(colours == CutColours::kMetricMeanRatio ? metric_quality(mesh, cell)
                                                                : cell_quality(mesh.points, cell));
}
template <std::size_t N>
Colour cell_colour(const MeshView& mesh, const Cell<N>& cell, CutColours) {
  return quality_colour(cell_quality(mesh.points, cell));
}

/// Straight on, with as much of the plane as the window is wide.
Camera window_camera(const CutWindow& window, int width) {
  Camera camera;
  camera.toward = window.normal.normalized();
  // z, the patient's head, stays up; where one looks along it, the patient's front is below.
  const Vec3 across = Vec3::UnitZ().cross(camera.toward);
  camera.right = across.norm() > 1e-3 ? Vec3(across.normalized()) : Vec3::UnitX();
  camera.up = camera.toward.cross(camera.right);
  camera.centre_mm = window.centre_mm;
  camera.width = width;
  camera.height = static_cast<int>(std::lround(kWindowShape * width));
  camera.pixels_per_mm = width / window.width_mm;
  return camera;
}

CutWindow fullest_window(const MeshView& mesh, const CutPlane& plane, std::uint64_t max_cells) {
  std::vector<SectionPlace> places;
  const Camera axes = window_camera({plane.point_mm, plane.normal, 1}, 1);
  for_each_section(mesh, plane, [&](const auto&, const std::vector<Vec3>& section) {
    SectionPlace place;
    for (const Vec3& p : section) {
      place.right_mm += axes.right.dot(p) / static_cast<double>(section.size());
      place.up_mm += axes.up.dot(p) / static_cast<double>(section.size());
    }
    for (std::size_t i = 1; i + 1 < section.size(); ++i)
      place.area_mm2 += triangle_area(section[0], section[i], section[i + 1]);
    places.push_back(place);
  });
  const WindowPlace found = fullest_place(places, max_cells);
  const Vec3 centre =
      found.right_mm * axes.right + found.up_mm * axes.up + plane.normal.dot(plane.point_mm) * plane.normal;
  return {centre, plane.normal, found.width_mm};
}

/// The plane of a cut and from where it is seen.
struct CutView {
  CutPlane plane;
  Camera camera;
};

CutView choose_view(const MeshView& mesh, const MeshSurface& surface, CutDirection direction,
                    const CutOptions& options) {
  if (options.window) {
    const CutWindow& window = *options.window;
    return {{window.centre_mm, window.normal.normalized()}, window_camera(window, options.width)};
  }
  const std::vector<Vec3> points = surface_points(mesh, surface);
  const ViewAngles angles = best_view(points);
  SectionView section = widest_section(mesh, angles);
  if (direction == CutDirection::kSide)  // From the side also where the front is seen from high above.
    section = widest_section(mesh, {angles.azimuth_deg + 90, std::min(angles.elevation_deg, 15.0)},
                             section.plane.normal);
  CutView view = {section.plane, {}};
  if (options.enlarge_to_cells > 0) {
    const CutWindow window = fullest_window(mesh, view.plane, options.enlarge_to_cells);
    view.camera = window_camera(window, options.width);
    return view;
  }
  // Seen a little from the side, what lies behind the section shows its depth.
  view.camera = look_from(section.angles.azimuth_deg + 14, section.angles.elevation_deg + 10);
  std::vector<Vec3> kept;
  for (const Vec3& p : points)
    if (view.plane.normal.dot(p - view.plane.point_mm) <= 0) kept.push_back(p);
  frame_points(view.camera, kept.empty() ? points : kept, options.width);
  return view;
}

/// The surface behind the plane, in softened colours.
void add_surface_behind(const MeshView& mesh, const MeshSurface& surface, const CutView& view,
                        std::vector<ScreenTriangle>& out) {
  const Palette palette(mesh, surface);
  for_each_outer_triangle(mesh, surface, [&](std::size_t i, const std::array<Vec3, 3>& corners) {
    if (!in_view(view.camera, corners)) return;
    add_polygon(view.camera, clip(corners, view.plane), triangle_normal(corners[0], corners[1], corners[2]),
                softened(palette.of(surface.labels[i][0], surface.patches[i])), false, out);
  });
}

ColourScale cut_scale(CutColours colours) {
  return {fmt::format("{} ≤ {}",
                      colours == CutColours::kMetricMeanRatio ? "mean ratio in the metric" : "mean ratio",
                      kLowestColouredQuality),
          "1 (regular)", viridis_stops()};
}

}  // namespace

CutPicture draw_cut(const MeshView& mesh, const MeshSurface& surface, CutDirection direction,
                    const CutOptions& options) {
  LUMESH_ASSERT(options.colours == CutColours::kMeanRatio || mesh.metric.size() == mesh.points.size());
  const CutView view = choose_view(mesh, surface, direction, options);
  CutPicture result;
  const Vec3 middle = view.camera.centre_mm;
  result.point_mm = middle - view.plane.normal.dot(middle - view.plane.point_mm) * view.plane.normal;
  result.normal = view.plane.normal;
  result.width_mm = view.camera.width / view.camera.pixels_per_mm;
  result.scale = cut_scale(options.colours);
  std::vector<ScreenTriangle> triangles;
  add_surface_behind(mesh, surface, view, triangles);
  for_each_section(mesh, view.plane, [&](const auto& cell, const std::vector<Vec3>& section) {
    if (!in_view(view.camera, section)) return;
    ++result.cells;
    add_polygon(view.camera, section, view.plane.normal, cell_colour(mesh, cell, options.colours), true,
                triangles);
  });
  result.picture = rasterise(triangles, view.camera.width, view.camera.height, options.supersampling);
  return result;
}

}  // namespace lumesh::report
