#include "scene.hpp"

#include <algorithm>
#include <cmath>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/mesh/points_in_use.hpp"

namespace lumesh::report {

namespace {

using quality::MeshSurface;

constexpr std::size_t kMaxLegendItems = 60;
/// Each two differ by 0.13 in OKLab (Ottosson 2020) at least, also to eyes without red or without green cones
/// (Machado et al. 2009, doi:10.1109/TVCG.2009.113, severity 1): found by exchanging one after the other for
/// the colour that is farthest from the rest. The first is that of walls.
constexpr std::array<Colour, 13> kDistinctColours = {{{208, 103, 91},
                                                      {60, 75, 195},
                                                      {255, 210, 0},
                                                      {0, 210, 165},
                                                      {90, 15, 120},
                                                      {75, 240, 255},
                                                      {165, 60, 0},
                                                      {105, 120, 240},
                                                      {120, 0, 30},
                                                      {90, 150, 180},
                                                      {255, 135, 30},
                                                      {90, 90, 120},
                                                      {15, 195, 255}}};
constexpr Colour kWallColour = kDistinctColours[0];
/// Colour of an opening; colours repeat, without that of walls.
Colour opening_colour(std::size_t index) {
  return kDistinctColours[1 + index % (kDistinctColours.size() - 1)];
}

constexpr std::array<Colour, 9> kViridis = {{{68, 1, 84},
                                             {71, 44, 122},
                                             {59, 81, 139},
                                             {44, 113, 142},
                                             {33, 144, 141},
                                             {39, 173, 129},
                                             {92, 200, 99},
                                             {170, 220, 50},
                                             {253, 231, 37}}};

}  // namespace

Palette::Palette(const MeshView& mesh, const MeshSurface& surface) : mesh_(mesh) {
  for (const auto& [inside, outside] : surface.labels)
    if (std::ranges::find(labels_, inside) == labels_.end()) labels_.push_back(inside);
  std::ranges::sort(labels_);
  std::size_t openings = 0;
  for (const Patch& patch : mesh.info->patches)
    patch_colours_.push_back(is_plane(patch.kind) ? opening_colour(openings++) : kWallColour);
}

Colour Palette::of(Label label, std::int32_t patch) const {
  if (labels_.size() > 1) return distinct_colour(rank_in(labels_, label));
  const bool known = patch >= 0 && static_cast<std::size_t>(patch) < patch_colours_.size();
  return known ? patch_colours_[static_cast<std::size_t>(patch)] : kWallColour;
}

std::vector<LegendItem> Palette::legend() const {
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
  if (items.size() > kMaxLegendItems) items.resize(kMaxLegendItems);
  return items;
}

Colour distinct_colour(std::size_t index) {
  return kDistinctColours[index % kDistinctColours.size()];
}

Colour viridis(double value) {
  const double at = std::clamp(value, 0.0, 1.0) * (kViridis.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), kViridis.size() - 2);
  const double share = at - static_cast<double>(low);
  const auto mix = [&](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround(a + (b - a) * share));
  };
  const Colour &a = kViridis[low], &b = kViridis[low + 1];
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

std::vector<Colour> viridis_stops() {
  return {kViridis.begin(), kViridis.end()};
}

Colour quality_colour(double quality) {
  return viridis((quality - kLowestColouredQuality) / (1 - kLowestColouredQuality));
}

Colour softened(Colour c) {
  const auto mix = [](std::uint8_t v) { return static_cast<std::uint8_t>(v * 0.30 + 205 * 0.70); };
  return {mix(c.red), mix(c.green), mix(c.blue)};
}

std::vector<Vec3> surface_points(const MeshView& mesh, const MeshSurface& surface) {
  const std::vector<std::uint8_t> used = points_in_use(mesh.points.size(), surface.outer());
  std::vector<Vec3> points;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v] != 0) points.push_back(mesh.points[v]);
  return points;
}

CutColours cut_colours(const MeshView& mesh) {
  return !mesh.metric.empty() && mesh.metric.size() == mesh.points.size() ? CutColours::kMetricMeanRatio
                                                                          : CutColours::kMeanRatio;
}

CutOptions cut_options(const MeshView& mesh, const PictureOptions& options, std::uint64_t enlarge_to_cells) {
  return {.width = options.width,
          .supersampling = options.supersampling,
          .colours = cut_colours(mesh),
          .enlarge_to_cells = enlarge_to_cells};
}

void lay_over(Picture& below, const Picture& above) {
  for (std::size_t i = 0; i < below.rgba.size(); i += 4) {
    const double over = above.rgba[i + 3] / 255.0, under = below.rgba[i + 3] / 255.0 * (1 - over);
    const double alpha = over + under;
    if (alpha <= 0) continue;
    for (std::size_t c = 0; c < 3; ++c)
      below.rgba[i + c] = static_cast<std::uint8_t>(
          std::lround((above.rgba[i + c] * over + below.rgba[i + c] * under) / alpha));
    below.rgba[i + 3] = static_cast<std::uint8_t>(std::lround(255 * alpha));
  }
}

Camera best_camera(std::span<const Vec3> points, int width) {
  const ViewAngles angles = best_view(points);
  Camera camera = look_from(angles.azimuth_deg, angles.elevation_deg);
  frame_points(camera, points, width);
  return camera;
}

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

bool in_view(const Camera& camera, std::span<const Vec3> points) {
  bool left = true, right = true, above = true, below = true;  // All points are.
  for (const Vec3& p : points) {
    const auto [x, y, z] = camera.project(p);
    left &= x < 0;
    right &= x > static_cast<float>(camera.width);
    above &= y < 0;
    below &= y > static_cast<float>(camera.height);
  }
  return !(left || right || above || below);
}

}  // namespace lumesh::report
