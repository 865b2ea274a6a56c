#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"
#include "scene.hpp"
#include "tubes.hpp"

namespace lumesh::report {

namespace {

using quality::MeshSurface;

/// Colours that stand for numbers must not change with the light.
enum class Finish : std::uint8_t { kLit, kMatt };

/// The outer triangles that face the viewer, in the colours colour_of(triangle index), in light and shade or
/// matt.
template <class ColourOf>
std::vector<ScreenTriangle> facing_triangles(const MeshView& mesh, const MeshSurface& surface,
                                             const Camera& camera, Finish finish, const ColourOf& colour_of) {
  std::vector<ScreenTriangle> triangles;
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    if (surface.labels[i][1] != quality::kOutside) continue;
    const auto& [a, b, c] = surface.triangles[i];
    const std::array<Vec3, 3> corners = {mesh.points[a], mesh.points[b], mesh.points[c]};
    const Vec3 normal = triangle_normal(corners[0], corners[1], corners[2]);
    if (normal.dot(camera.toward) <= 0) continue;  // A closed surface hides its far side.
    add_polygon(camera, corners, normal, colour_of(i), finish == Finish::kMatt, triangles);
  }
  return triangles;
}

/// Lays one picture over another of the same size.
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

/// Colours of positive values, from the 1st to the 99th percentile in logarithmic steps.
class LogarithmicColours {
 public:
  explicit LogarithmicColours(std::vector<double> values) {
    std::erase_if(values, [](double v) { return !(v > 0 && std::isfinite(v)); });
    if (values.empty()) return;
    const auto percentile = [&](double share) {
      const auto at =
          values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
      std::nth_element(values.begin(), at, values.end());
      return *at;
    };
    low_ = percentile(0.01);
    high_ = percentile(0.99);
  }

  [[nodiscard]] Colour of(double value) const {
    return viridis(high_ > low_ ? std::log(value / low_) / std::log(high_ / low_) : 0.5);
  }
  [[nodiscard]] ColourScale scale(const std::string& name) const {
    return {fmt::format("{} {:.3g}", name, low_), fmt::format("{:.3g}, in equal ratios", high_),
            viridis_stops()};
  }

 private:
  double low_ = 1, high_ = 1;
};

/// Draws the lines alone, as tubes.
Picture draw_tubes(const Camera& camera, const Polylines& lines, const LinesOptions& options,
                   const std::optional<LogarithmicColours>& colours) {
  const std::vector<double>* values = colours ? &lines.scalars.at(options.scalar) : nullptr;
  std::vector<ScreenTriangle> triangles;
  for (std::size_t line = 0; line < lines.lines.size(); ++line)
    add_tube(
        camera, lines.points, lines.lines[line], options.thickness_pixels / 2,
        [&](std::uint32_t point) {
          return values ? colours->of((*values)[point]) : distinct_colour(line + 1);
        },
        triangles);
  return rasterise(triangles, camera.width, camera.height, options.supersampling);
}

std::string line_name(const Polylines& lines, std::size_t line) {
  double length_mm = 0;
  const std::vector<std::uint32_t>& points = lines.lines[line];
  for (std::size_t i = 1; i < points.size(); ++i)
    length_mm += (lines.points[points[i]] - lines.points[points[i - 1]]).norm();
  return fmt::format("branch {}, {:.0f} mm", line + 1, length_mm);
}

/// Volume inside the boundary triangles of the view that face the outside; interfaces are left out.
double enclosed_volume(const MeshView& mesh) {
  double six_volumes = 0;
  const Vec3 origin = mesh.points[mesh.triangles[0][0]];
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.info->patches[static_cast<std::size_t>(mesh.triangle_patches[i])].kind == PatchKind::kInterface)
      continue;
    const auto& [a, b, c] = mesh.triangles[i];
    six_volumes += (mesh.points[a] - origin).cross(mesh.points[b] - origin).dot(mesh.points[c] - origin);
  }
  return six_volumes / 6;
}

double volume_of_tetrahedra(const MeshView& mesh) {
  return parallel::reduce_blocks(
      mesh.tetrahedra.size(), 8192, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) {
          const auto& [a, b, c, d] = mesh.tetrahedra[i];
          sum += tetrahedron_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]);
        }
        return sum;
      },
      [](double a, double b) { return a + b; });
}

/// True if the boundary triangles of the view are all there is to its surface.
bool has_whole_boundary(const MeshView& mesh) {
  if (mesh.triangles.empty() || mesh.cell_count() != mesh.tetrahedra.size()) return false;
  if (mesh.triangle_patches.size() != mesh.triangles.size()) return false;
  const std::size_t patches = mesh.info->patches.size();
  for (const std::int32_t patch : mesh.triangle_patches)
    if (patch < 0 || static_cast<std::size_t>(patch) >= patches) return false;
  const bool one_label = std::all_of(mesh.tetrahedron_labels.begin(), mesh.tetrahedron_labels.end(),
                                     [&](Label label) { return label == mesh.tetrahedron_labels.front(); });
  const bool sides_known = std::all_of(mesh.info->patches.begin(), mesh.info->patches.end(),
                                       [](const Patch& patch) { return patch.labels[0] != kBackground; });
  if (!one_label && !sides_known) return false;
  const double volume = volume_of_tetrahedra(mesh);
  return std::abs(enclosed_volume(mesh) - volume) <= 1e-6 * std::abs(volume);
}

}  // namespace

MeshSurface surface_for_pictures(const MeshView& mesh) {
  if (!has_whole_boundary(mesh)) return quality::extract_surface(mesh);
  MeshSurface surface;
  surface.triangles.assign(mesh.triangles.begin(), mesh.triangles.end());
  surface.patches.assign(mesh.triangle_patches.begin(), mesh.triangle_patches.end());
  surface.labels.reserve(mesh.triangles.size());
  for (const std::int32_t p : mesh.triangle_patches) {
    const Patch& patch = mesh.info->patches[static_cast<std::size_t>(p)];
    const Label inside = patch.labels[0] != kBackground ? patch.labels[0] : mesh.tetrahedron_labels.front();
    const bool interface = patch.kind == PatchKind::kInterface;
    surface.labels.push_back({inside, interface ? patch.labels[1] : quality::kOutside});
  }
  return surface;
}

SurfacePicture draw_surface(const MeshView& mesh, const MeshSurface& surface, const PictureOptions& options) {
  const Camera camera = best_camera(surface_points(mesh, surface), options.width);
  const Palette palette(mesh, surface);
  const std::vector<ScreenTriangle> triangles =
      facing_triangles(mesh, surface, camera, Finish::kLit,
                       [&](std::size_t i) { return palette.of(surface.labels[i][0], surface.patches[i]); });
  return {rasterise(triangles, camera.width, camera.height, options.supersampling), palette.legend()};
}

SurfacePicture draw_surface_values(const MeshView& mesh, const MeshSurface& surface,
                                   std::span<const double> values, const std::string& value_name,
                                   const PictureOptions& options) {
  LUMESH_ASSERT(values.size() == mesh.points.size());
  const Camera camera = best_camera(surface_points(mesh, surface), options.width);
  std::vector<double> of_triangles;  // Geometric means.
  of_triangles.reserve(surface.triangles.size());
  for (const auto& [a, b, c] : surface.triangles)
    of_triangles.push_back(std::cbrt(values[a] * values[b] * values[c]));
  const LogarithmicColours colours(of_triangles);
  const std::vector<ScreenTriangle> triangles = facing_triangles(
      mesh, surface, camera, Finish::kMatt, [&](std::size_t i) { return colours.of(of_triangles[i]); });
  return {rasterise(triangles, camera.width, camera.height, options.supersampling),
          {},
          colours.scale(value_name)};
}

SurfacePicture draw_surface_with_lines(const MeshView& mesh, const MeshSurface& surface,
                                       const Polylines& lines, const LinesOptions& options) {
  constexpr std::size_t kMostNamedLines = 12;
  const Camera camera = best_camera(surface_points(mesh, surface), options.width);
  const Palette palette(mesh, surface);
  const std::vector<ScreenTriangle> triangles = facing_triangles(
      mesh, surface, camera, Finish::kLit,
      [&](std::size_t i) { return softened(palette.of(surface.labels[i][0], surface.patches[i])); });
  SurfacePicture result = {rasterise(triangles, camera.width, camera.height, options.supersampling), {}};
  for (std::size_t i = 3; i < result.picture.rgba.size(); i += 4)
    result.picture.rgba[i] = static_cast<std::uint8_t>(result.picture.rgba[i] * 0.55);
  std::optional<LogarithmicColours> colours;
  const auto scalar = lines.scalars.find(options.scalar);
  if (!options.scalar.empty() && scalar != lines.scalars.end()) {
    LUMESH_ASSERT(scalar->second.size() == lines.points.size());
    colours.emplace(scalar->second);
    result.scale = colours->scale(options.scalar_name.empty() ? options.scalar : options.scalar_name);
  }
  lay_over(result.picture, draw_tubes(camera, lines, options, colours));
  if (!colours)
    for (std::size_t line = 0; line < std::min(lines.lines.size(), kMostNamedLines); ++line)
      result.legend.push_back({line_name(lines, line), distinct_colour(line + 1)});
  return result;
}

}  // namespace lumesh::report
