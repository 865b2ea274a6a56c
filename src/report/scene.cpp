#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "camera.hpp"
#include "cut_cells.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/report/picture.hpp"

namespace lumesh::report {

namespace {

using quality::kOutside;
using quality::MeshSurface;

constexpr std::size_t kMostLegendItems = 14;
constexpr Colour kWallColour = {208, 103, 91};
constexpr std::array<Colour, 6> kOpeningColours = {
    {{59, 130, 196}, {47, 165, 142}, {224, 160, 58}, {138, 99, 184}, {124, 152, 52}, {194, 85, 143}}};
constexpr std::array<Colour, 12> kLabelColours = {{{208, 103, 91},
                                                   {91, 143, 208},
                                                   {224, 176, 74},
                                                   {107, 179, 138},
                                                   {154, 120, 194},
                                                   {217, 139, 74},
                                                   {92, 181, 196},
                                                   {196, 109, 155},
                                                   {155, 176, 77},
                                                   {138, 127, 116},
                                                   {77, 111, 176},
                                                   {176, 88, 77}}};

/// Colours of the outer triangles, and what they mean.
class Palette {
 public:
  Palette(const MeshView& mesh, const MeshSurface& surface) : mesh_(mesh) {
    for (const auto& [inside, outside] : surface.labels)
      if (std::find(labels_.begin(), labels_.end(), inside) == labels_.end()) labels_.push_back(inside);
    std::sort(labels_.begin(), labels_.end());
    std::size_t openings = 0;
    for (const Patch& patch : mesh.info->patches)
      patch_colours_.push_back(patch.kind == PatchKind::kOpening
                                   ? kOpeningColours[openings++ % kOpeningColours.size()]
                                   : kWallColour);
  }

  [[nodiscard]] Colour of(Label label, std::int32_t patch) const {
    if (labels_.size() > 1) {
      const auto at = std::lower_bound(labels_.begin(), labels_.end(), label) - labels_.begin();
      return kLabelColours[static_cast<std::size_t>(at) % kLabelColours.size()];
    }
    const bool known = patch >= 0 && static_cast<std::size_t>(patch) < patch_colours_.size();
    return known ? patch_colours_[static_cast<std::size_t>(patch)] : kWallColour;
  }

  [[nodiscard]] std::vector<LegendItem> legend() const {
    std::vector<LegendItem> items;
    if (labels_.size() > 1) {
      for (const Label label : labels_) {
        const auto name = mesh_.info->label_names.find(label);
        items.push_back(
            {name != mesh_.info->label_names.end() ? name->second : "label " + std::to_string(label),
             of(label, -1)});
      }
    } else {
      for (std::size_t p = 0; p < patch_colours_.size(); ++p)
        items.push_back({mesh_.info->patches[p].name, patch_colours_[p]});
    }
    if (items.size() > kMostLegendItems) items.resize(kMostLegendItems);
    return items;
  }

 private:
  const MeshView& mesh_;
  std::vector<Label> labels_;
  std::vector<Colour> patch_colours_;
};

/// Between a colour and a light grey, for what is only context.
Colour soften(Colour c) {
  const auto mix = [](std::uint8_t v) { return static_cast<std::uint8_t>(v * 0.30 + 205 * 0.70); };
  return {mix(c.red), mix(c.green), mix(c.blue)};
}

std::vector<Vec3> surface_points(const MeshView& mesh, const MeshSurface& surface) {
  std::vector<char> used(mesh.points.size(), 0);
  for (std::size_t i = 0; i < surface.triangles.size(); ++i)
    if (surface.labels[i][1] == kOutside)
      for (const std::uint32_t v : surface.triangles[i]) used[v] = 1;
  std::vector<Vec3> points;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v]) points.push_back(mesh.points[v]);
  return points;
}

/// A convex polygon as a fan; all its sides but the fan's inner ones are outlined.
void add_polygon(const Camera& camera, std::span<const Vec3> corners, const Vec3& normal, Colour colour,
                 bool matt, std::vector<ScreenTriangle>& out) {
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    ScreenTriangle triangle;
    triangle.corners = {camera.project(corners[0]), camera.project(corners[i]),
                        camera.project(corners[i + 1])};
    triangle.normal = camera.direction(normal);
    triangle.colour = colour;
    triangle.matt = matt;
    triangle.outlined = static_cast<std::uint8_t>((i == 1 ? 1 : 0) | 2 | (i + 2 == corners.size() ? 4 : 0));
    out.push_back(triangle);
  }
}

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

/// Offset along `normal` where the section is largest, by volume per slice.
CutPlane widest_section(const MeshView& mesh, const Vec3& normal) {
  constexpr std::size_t kSlices = 64;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec3& p : mesh.points) {
    low = std::min(low, normal.dot(p));
    high = std::max(high, normal.dot(p));
  }
  const double thickness = std::max(high - low, 1e-12) / kSlices;
  std::array<double, kSlices> volume = {};
  for_each_cell(mesh, [&](const auto& cell, const auto&) {
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest, middle = 0;
    for (const std::uint32_t v : cell) {
      const double offset = normal.dot(mesh.points[v]);
      lowest = std::min(lowest, offset);
      highest = std::max(highest, offset);
      middle += offset / static_cast<double>(cell.size());
    }
    const auto slice = static_cast<std::size_t>(std::clamp((middle - low) / thickness, 0.0, kSlices - 1.0));
    volume[slice] +=
        std::pow(highest - lowest, 3);  // Grows like the volume, and is good enough to choose a place.
  });
  std::array<double, kSlices> smooth = {};
  for (std::size_t i = 0; i < kSlices; ++i)
    for (std::size_t j = i < 2 ? 0 : i - 2; j <= std::min(i + 2, kSlices - 1); ++j) smooth[i] += volume[j];
  const auto best = static_cast<double>(std::max_element(smooth.begin(), smooth.end()) - smooth.begin());
  // A little off the slice's middle: lattice planes would give flat slivers of sections.
  return {(low + (best + 0.5137) * thickness) * normal, normal};
}

}  // namespace

Colour quality_colour(double value) {
  static constexpr std::array<Colour, 9> kViridis = {{{68, 1, 84},
                                                      {71, 44, 122},
                                                      {59, 81, 139},
                                                      {44, 113, 142},
                                                      {33, 144, 141},
                                                      {39, 173, 129},
                                                      {92, 200, 99},
                                                      {170, 220, 50},
                                                      {253, 231, 37}}};
  const double at = std::clamp((value - kLowestColouredQuality) / (1 - kLowestColouredQuality), 0.0, 1.0) *
                    (kViridis.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), kViridis.size() - 2);
  const double share = at - static_cast<double>(low);
  const auto mix = [&](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround(a + (b - a) * share));
  };
  const Colour &a = kViridis[low], &b = kViridis[low + 1];
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

SurfacePicture draw_surface(const MeshView& mesh, const MeshSurface& surface, const PictureOptions& options) {
  const std::vector<Vec3> points = surface_points(mesh, surface);
  const ViewAngles angles = best_view(points);
  Camera camera = look_from(angles.azimuth_deg, angles.elevation_deg);
  frame_points(camera, points, options.width);
  const Palette palette(mesh, surface);
  std::vector<ScreenTriangle> triangles;
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    if (surface.labels[i][1] != kOutside) continue;
    const auto& [a, b, c] = surface.triangles[i];
    const std::array<Vec3, 3> corners = {mesh.points[a], mesh.points[b], mesh.points[c]};
    const Vec3 normal = triangle_normal(corners[0], corners[1], corners[2]);
    if (normal.dot(camera.toward) <= 0) continue;  // A closed surface hides its far side.
    add_polygon(camera, corners, normal, palette.of(surface.labels[i][0], surface.patches[i]), false,
                triangles);
  }
  return {rasterise(triangles, camera.width, camera.height, options.supersampling), palette.legend()};
}

CutPicture draw_cut(const MeshView& mesh, const MeshSurface& surface, CutDirection direction,
                    const PictureOptions& options) {
  const std::vector<Vec3> points = surface_points(mesh, surface);
  const ViewAngles angles = best_view(points);
  const double turn = direction == CutDirection::kSide ? 90 : 0;
  Camera camera = look_from(angles.azimuth_deg + turn, angles.elevation_deg);
  const CutPlane plane = widest_section(mesh, camera.toward);
  // Seen a little from the side, what lies behind the section shows its depth.
  camera = look_from(angles.azimuth_deg + turn + 14, angles.elevation_deg + 10);
  std::vector<Vec3> kept;
  for (const Vec3& p : points)
    if (plane.normal.dot(p - plane.point_mm) <= 0) kept.push_back(p);
  frame_points(camera, kept.empty() ? points : kept, options.width);

  CutPicture result;
  const Vec3 middle = camera.centre_mm;
  result.point_mm = middle - plane.normal.dot(middle - plane.point_mm) * plane.normal;
  result.normal = plane.normal;
  const Palette palette(mesh, surface);
  std::vector<ScreenTriangle> triangles;
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    if (surface.labels[i][1] != kOutside) continue;
    const auto& [a, b, c] = surface.triangles[i];
    const std::array<Vec3, 3> corners = {mesh.points[a], mesh.points[b], mesh.points[c]};
    add_polygon(camera, clip(corners, plane), triangle_normal(corners[0], corners[1], corners[2]),
                soften(palette.of(surface.labels[i][0], surface.patches[i])), false, triangles);
  }
  for_each_cell(mesh, [&](const auto& cell, const auto& edges) {
    const std::vector<Vec3> section = cut_cell(mesh.points, cell, edges, plane);
    if (section.size() < 3) return;
    ++result.cells;
    add_polygon(camera, section, plane.normal, quality_colour(cell_quality(mesh.points, cell)), true,
                triangles);
  });
  result.picture = rasterise(triangles, camera.width, camera.height, options.supersampling);
  return result;
}

}  // namespace lumesh::report
