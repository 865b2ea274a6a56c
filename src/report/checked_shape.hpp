#pragma once
/// @file What pictures of a checked file show: faces and lines, whole or near a place.

#include <array>
#include <cstdint>
#include <vector>

#include "camera.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/report/picture.hpp"
#include "raster.hpp"

namespace lumesh::report {

/// A triangle, seen from both sides.
struct ShapeFace {
  std::array<Vec3, 3> corners;
  Colour colour;
  std::uint8_t outlined = 7;    ///< As ScreenTriangle::outlined.
  bool has_inner_side = false;  ///< Its back has a colour of its own.
  bool matt = false;
};
struct ShapeLine {
  Vec3 from, to;
  Colour colour;
};
struct Shape {
  std::vector<ShapeFace> faces;
  std::vector<ShapeLine> lines;
  double inexact_mm = 0;  ///< How far faces may be from where they belong.
};

inline constexpr Colour kShapeColour = {196, 196, 192};
inline constexpr Colour kInnerColour = {132, 146, 176};
inline constexpr Colour kSectionColour = {240, 222, 190};
inline constexpr Colour kAtPlaceColour = {255, 138, 128};
inline constexpr Colour kOpenEdgeColour = {20, 70, 230};
inline constexpr Colour kCrowdedEdgeColour = {255, 135, 30};

/// Outer triangles, turned so that most look outwards, and edges that have not two of them. Equal points
/// count as one.
/// @throws Error{kBadInput} as quality::extract_surface() does.
[[nodiscard]] Shape shape_of(const MeshView& mesh);

/// Faces between labels and background, of blocks of voxels if more than 256 of these are in a row.
[[nodiscard]] Shape shape_of(const LabelImage& image);

/// What is within a distance of a place. @return  Faces that touch the place have the colour for that.
[[nodiscard]] Shape part_near(const Shape& shape, const Vec3& place, double reach_mm);

/// Voxels within a distance of one; its own faces have the colour for that, and it is there if it has no
/// label, too.
/// @param cut  If not zero, one of the image's axes or its opposite: voxels beyond that one are left out.
[[nodiscard]] Shape part_near(const LabelImage& image, const Index3& voxel, double reach_mm,
                              const Index3& cut);

/// Points of faces, three each, or fewer where there are very many.
[[nodiscard]] std::vector<Vec3> some_points(const Shape& shape);

/// @param line_pixels  Width of lines, which are drawn a little in front of what they lie on.
[[nodiscard]] std::vector<ScreenTriangle> on_screen(const Shape& shape, const Camera& camera,
                                                    double line_pixels);

}  // namespace lumesh::report
