#pragma once
/// @file What all pictures of meshes have in common: colours, points of the surface, polygons on the screen.

#include <array>
#include <span>
#include <vector>

#include "camera.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/quality/surface.hpp"
#include "lumesh/report/drawing.hpp"
#include "lumesh/report/picture.hpp"
#include "raster.hpp"

namespace lumesh::report {

/// Colours of the outer triangles, and what they mean.
class Palette {
 public:
  Palette(const MeshView& mesh, const quality::MeshSurface& surface);

  [[nodiscard]] Colour of(Label label, std::int32_t patch) const;
  [[nodiscard]] std::vector<LegendItem> legend() const;

 private:
  const MeshView& mesh_;
  std::vector<Label> labels_;
  std::vector<Colour> patch_colours_;
};

/// Colours for things that only have to differ, such as labels and branches; they repeat.
[[nodiscard]] Colour distinct_colour(std::size_t index);

/// The map "viridis": 0 is dark violet, 1 is yellow; what lies outside has the colour of the end.
[[nodiscard]] Colour viridis(double share);
/// It as nine steps.
[[nodiscard]] std::vector<Colour> viridis_stops();

/// Between a colour and a light grey, for what is only context.
[[nodiscard]] Colour softened(Colour colour);

/// In the metric where the mesh has one.
[[nodiscard]] CutColours cut_colours(const MeshView& mesh);

/// A cut of a report in these colours. @param enlarge_to_cells  CutOptions::enlarge_to_cells.
[[nodiscard]] CutOptions cut_options(const MeshView& mesh, const PictureOptions& options,
                                     std::uint64_t enlarge_to_cells = 0);
inline constexpr std::uint64_t kCellsOfEnlargedCut = 1200;  ///< So that each can be seen.

/// Calls visit(index, corners) for the triangles against the outside.
template <class Visit>
void for_each_outer_triangle(const MeshView& mesh, const quality::MeshSurface& surface, const Visit& visit) {
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    const auto& [a, b, c] = surface.triangles[i];
    if (surface.labels[i][1] == quality::kOutside)
      visit(i, std::array<Vec3, 3>{mesh.points[a], mesh.points[b], mesh.points[c]});
  }
}

/// Points of the triangles against the outside, each once, ascending.
[[nodiscard]] std::vector<Vec3> surface_points(const MeshView& mesh, const quality::MeshSurface& surface);

/// Looks at the points from where they cover most of the picture.
[[nodiscard]] Camera best_camera(std::span<const Vec3> points, int width);

/// A convex polygon as a fan; all its sides but the fan's inner ones are outlined.
void add_polygon(const Camera& camera, std::span<const Vec3> corners, const Vec3& normal, Colour colour,
                 bool matt, std::vector<ScreenTriangle>& out);

/// Lays one picture over another of the same size.
void lay_over(Picture& below, const Picture& above);

/// True if the camera sees a part of the box around the points.
[[nodiscard]] bool in_view(const Camera& camera, std::span<const Vec3> points);

}  // namespace lumesh::report
