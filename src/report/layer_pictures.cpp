#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/report/layers_report.hpp"
#include "scene.hpp"

namespace lumesh::report {

namespace {

constexpr Colour kInnerSide = {196, 196, 192};

SurfacePicture shares_seen_from(const LayerShares& surface, const ViewAngles& angles,
                                const PictureOptions& options) {
  Camera camera = look_from(angles.azimuth_deg, angles.elevation_deg);
  frame_points(camera, surface.points, options.width);
  std::vector<ScreenTriangle> triangles;
  triangles.reserve(surface.triangles.size());
  for (const auto& [a, b, c] : surface.triangles) {
    const std::array<Vec3, 3> corners = {surface.points[a], surface.points[b], surface.points[c]};
    const Vec3 normal = triangle_normal(corners[0], corners[1], corners[2]);
    const bool faces_viewer = normal.dot(camera.toward) > 0;
    const double share = (surface.of_points[a] + surface.of_points[b] + surface.of_points[c]) / 3;
    add_polygon(camera, corners, faces_viewer ? normal : Vec3(-normal),
                faces_viewer ? viridis(share) : kInnerSide, faces_viewer, triangles);
  }
  return {rasterise(triangles, camera.width, camera.height, options.supersampling),
          {},
          ColourScale{"0 %, no layers", "100 % of the thickness", viridis_stops()}};
}

}  // namespace

LayerPictures draw_layer_shares(const LayerShares& surface, const PictureOptions& options) {
  LUMESH_ASSERT(surface.of_points.size() == surface.points.size());
  const ViewAngles front = best_view(surface.points);
  const ViewAngles back = {front.azimuth_deg + 180, front.elevation_deg};
  return {shares_seen_from(surface, front, options), shares_seen_from(surface, back, options)};
}

}  // namespace lumesh::report
