#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "lumesh/core/assert.hpp"
#include "lumesh/core/value_of_rank.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/sum.hpp"
#include "lumesh/quality/curvature.hpp"
#include "name_labels.hpp"
#include "scene.hpp"
#include "tubes.hpp"

namespace lumesh::report {

namespace {

using quality::MeshSurface;

/// Colours that stand for numbers must not change with the light.
enum class Finish : std::uint8_t { kLit, kMatt };

/// Calls visit(triangle index, corners, normal) for the outer triangles that face the viewer.
template <class Visit>
void for_each_facing(const MeshView& mesh, const MeshSurface& surface, const Camera& camera,
                     const Visit& visit) {
  for_each_outer_triangle(mesh, surface, [&](std::size_t i, const std::array<Vec3, 3>& corners) {
    const Vec3 normal = triangle_normal(corners[0], corners[1], corners[2]);
    if (normal.dot(camera.toward) > 0) visit(i, corners, normal);  // A closed surface hides its far side.
  });
}

/// The outer triangles that face the viewer, in the colours colour_of(triangle index), in light and shade or
/// matt.
template <class ColourOf>
std::vector<ScreenTriangle> facing_triangles(const MeshView& mesh, const MeshSurface& surface,
                                             const Camera& camera, Finish finish, const ColourOf& colour_of) {
  std::vector<ScreenTriangle> triangles;
  for_each_facing(mesh, surface, camera,
                  [&](std::size_t i, const std::array<Vec3, 3>& corners, const Vec3& normal) {
                    add_polygon(camera, corners, normal, colour_of(i), finish == Finish::kMatt, triangles);
                  });
  return triangles;
}

/// Colours of positive values, from the 1st to the 99th percentile in logarithmic steps.
class LogarithmicColours {
 public:
  explicit LogarithmicColours(std::vector<double> values) {
    std::erase_if(values, [](double v) { return !(v > 0 && std::isfinite(v)); });
    if (values.empty()) return;
    const auto percentile = [&](double share) {
      const double rank = share * static_cast<double>(values.size() - 1) + 0.5;
      return value_of_rank(values, static_cast<std::size_t>(rank));
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

/// Colours from blue by light grey to red for values around 0. Source: Moreland 2009,
/// doi:10.1007/978-3-642-10520-3_9 (the ends and the middle of the map).
class DivergingColours {
 public:
  explicit DivergingColours(double end) : end_(end) {}

  /// What is not a number has a colour of its own.
  [[nodiscard]] Colour of(double value) const {
    if (std::isnan(value)) return kNone;
    const double share = std::clamp(value / end_, -1.0, 1.0);
    const Colour& far = share < 0 ? kLow : kHigh;
    const auto mix = [&](std::uint8_t from, std::uint8_t to) {
      return static_cast<std::uint8_t>(std::lround(from + (to - from) * std::abs(share)));
    };
    return {mix(kMiddle.red, far.red), mix(kMiddle.green, far.green), mix(kMiddle.blue, far.blue)};
  }
  [[nodiscard]] ColourScale scale(const std::string& name, const std::string& unit) const {
    return {fmt::format("{} ≤ −{:.3g}", name, end_),
            fmt::format("≥ {:.3g} {}", end_, unit),
            {kLow, kMiddle, kHigh}};
  }

  static constexpr Colour kNone = {120, 126, 116};

 private:
  static constexpr Colour kLow = {59, 76, 192};
  static constexpr Colour kMiddle = {221, 221, 221};
  static constexpr Colour kHigh = {180, 4, 38};
  double end_;
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
  return fmt::format("branch {}, {:.0f} mm", line + 1, length_mm(lines, lines.lines[line]));
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
  return parallel::sum<double>(mesh.tetrahedra.size(), 8192, [&](std::size_t i) {
    const auto& [a, b, c, d] = mesh.tetrahedra[i];
    return tetrahedron_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]);
  });
}

/// Where the scale of curvature ends: area / volume, or if there is no volume the 98th percentile of its
/// size.
double curvature_end(const MeshView& mesh, const MeshSurface& surface,
                     const quality::WallCurvature& curvature) {
  double area = 0, six_volumes = 0;
  for_each_outer_triangle(mesh, surface, [&](std::size_t, const std::array<Vec3, 3>& corners) {
    const Vec3& origin = mesh.points[surface.triangles[0][0]];
    six_volumes += (corners[0] - origin).cross(corners[1] - origin).dot(corners[2] - origin);
  });
  for (const double part : curvature.area_mm2) area += part;
  if (six_volumes > 0 && area > 0) return 6 * area / six_volumes;
  const quality::CurvatureSummary summary = quality::summarise(curvature);
  const double end = std::max(std::abs(summary.p2_per_mm), std::abs(summary.p98_per_mm));
  return end > 0 ? end : 1;
}

/// Mean over the corners that have a curvature; not a number if none has.
double curvature_of(const Cell<3>& triangle, const quality::WallCurvature& curvature) {
  double sum = 0;
  int count = 0;
  for (const std::uint32_t v : triangle) {
    if (!(curvature.area_mm2[v] > 0)) continue;
    sum += curvature.mean_per_mm[v];
    ++count;
  }
  return sum / count;
}

/// The part of a triangle that is nearest to its corner `first`: up to the middles of its sides and of
/// itself. Only what lies on the triangle's sides is outlined.
void add_corner(const Camera& camera, const std::array<Vec3, 3>& corners, std::size_t first,
                const Vec3& normal, Colour colour, std::vector<ScreenTriangle>& out) {
  const Vec3 &p = corners[first], &next = corners[(first + 1) % 3], &last = corners[(first + 2) % 3];
  const std::array<Vec3, 4> part = {p, Vec3((p + next) / 2), triangle_centre(p, next, last),
                                    Vec3((p + last) / 2)};
  add_polygon(camera, part, normal, colour, true, out);
  out[out.size() - 2].outlined = 1;
  out[out.size() - 1].outlined = 4;
}

/// The outer triangles that face the viewer, each corner in the colour of its own curvature: means over
/// triangles would hide a ripple that goes from vertex to vertex. Triangles below a pixel have one colour.
std::vector<ScreenTriangle> curvature_triangles(const MeshView& mesh, const MeshSurface& surface,
                                                const quality::WallCurvature& curvature, const Camera& camera,
                                                const DivergingColours& colours) {
  std::vector<ScreenTriangle> triangles;
  for_each_facing(
      mesh, surface, camera, [&](std::size_t i, const std::array<Vec3, 3>& corners, const Vec3& normal) {
        const Cell<3>& ids = surface.triangles[i];
        const double mean = curvature_of(ids, curvature);
        const double pixels =
            triangle_area(corners[0], corners[1], corners[2]) * camera.pixels_per_mm * camera.pixels_per_mm;
        if (std::isnan(mean) || pixels < 1) {
          add_polygon(camera, corners, normal, colours.of(mean), true, triangles);
          return;
        }
        for (std::size_t corner = 0; corner < 3; ++corner) {
          const double own = curvature.mean_per_mm[ids[corner]];
          add_corner(camera, corners, corner, normal, colours.of(std::isnan(own) ? mean : own), triangles);
        }
      });
  return triangles;
}

/// True if the boundary triangles of the view are all there is to its surface.
bool has_whole_boundary(const MeshView& mesh) {
  if (mesh.triangles.empty() || mesh.cell_count() != mesh.tetrahedra.size()) return false;
  if (mesh.triangle_patches.size() != mesh.triangles.size()) return false;
  const std::size_t patches = mesh.info->patches.size();
  for (const std::int32_t patch : mesh.triangle_patches)
    if (patch < 0 || static_cast<std::size_t>(patch) >= patches) return false;
  const bool one_label = std::ranges::all_of(
      mesh.tetrahedron_labels, [&](Label label) { return label == mesh.tetrahedron_labels.front(); });
  const bool sides_known = std::ranges::all_of(
      mesh.info->patches, [](const Patch& patch) { return patch.labels[0] != kBackground; });
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
  const std::vector<Vec3> points = surface_points(mesh, surface);
  const std::vector<OpeningMark> openings = opening_marks(mesh, surface);
  Camera camera = best_camera(points, options.width);
  const double letter = letter_pixels(camera);
  frame_points(camera, points, options.width, margins_for(openings, letter));
  const Palette palette(mesh, surface);
  const std::vector<ScreenTriangle> triangles =
      facing_triangles(mesh, surface, camera, Finish::kLit,
                       [&](std::size_t i) { return palette.of(surface.labels[i][0], surface.patches[i]); });
  Picture picture = rasterise(triangles, camera.width, camera.height, options.supersampling);
  PictureLabels names = place_names(openings, camera, picture, triangles, letter_pixels(camera));
  return {std::move(picture), palette.legend(), {}, std::move(names)};
}

SurfacePicture draw_surface_curvature(const MeshView& mesh, const MeshSurface& surface,
                                      const PictureOptions& options) {
  const quality::WallCurvature curvature = quality::wall_curvature(mesh, surface);
  const DivergingColours colours(curvature_end(mesh, surface, curvature));
  const Camera camera = best_camera(surface_points(mesh, surface), options.width);
  SurfacePicture result = {rasterise(curvature_triangles(mesh, surface, curvature, camera, colours),
                                     camera.width, camera.height, options.supersampling),
                           {}};
  result.scale = colours.scale("mean curvature", "1/mm");
  const bool has_openings = std::ranges::any_of(surface.patches, [&](std::int32_t patch) {
    return patch >= 0 && static_cast<std::size_t>(patch) < mesh.info->patches.size() &&
           mesh.info->patches[static_cast<std::size_t>(patch)].kind == PatchKind::kOpening;
  });
  if (has_openings) result.legend = {{"openings: no curvature", DivergingColours::kNone}};
  return result;
}

SurfacePicture draw_surface_with_lines(const MeshView& mesh, const MeshSurface& surface,
                                       const Polylines& lines, const LinesOptions& options) {
  constexpr std::size_t kMaxNamedLines = 12;
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
    for (std::size_t line = 0; line < std::min(lines.lines.size(), kMaxNamedLines); ++line)
      result.legend.push_back({line_name(lines, line), distinct_colour(line + 1)});
  return result;
}

}  // namespace lumesh::report
