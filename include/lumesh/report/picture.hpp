#pragma once
/// @file Pictures of meshes, drawn in software: no display, no graphics library.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/quality/surface.hpp"

namespace lumesh::report {

/// 8-bit red, green, blue.
struct Colour {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;

  [[nodiscard]] std::string css() const;  ///< "#rrggbb"
};

/// Pixels row by row from the top: red, green, blue, alpha (not premultiplied).
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;
};

/// A picture and what its colours mean.
struct LegendItem {
  std::string name;
  Colour colour;
};
/// Colours at equal steps between two ends, and what the ends stand for.
struct ColourScale {
  std::string low;   ///< Such as "mean ratio ≤ 0.2".
  std::string high;  ///< Such as "1 (regular)".
  std::vector<Colour> stops;
};
/// In pixels from the upper left corner of a picture.
using PixelPlace = std::array<double, 2>;

/// The name of an opening beside it and an arrow to it.
struct PictureLabel {
  std::string text;
  PixelPlace at = {};      ///< The point of the arrow: in the middle of the opening; of a hidden one, where
                           ///< the line to it comes to the object.
  PixelPlace from = {};    ///< Its end, on the border of the text.
  PixelPlace low = {};     ///< Upper left corner of the text.
  PixelPlace high = {};    ///< Lower right corner.
  bool is_hidden = false;  ///< Something is in front of the opening, or it faces away.
};
struct PictureLabels {
  std::vector<PictureLabel> labels;
  double letter_pixels = 0;  ///< Height of a line; a letter is kLetterWidth of it wide, whichever it is.
};
inline constexpr double kLetterWidth = 0.6;
struct SurfacePicture {
  Picture picture;
  std::vector<LegendItem> legend;
  std::optional<ColourScale> scale = {};
  PictureLabels names = {};
};
struct CutPicture {
  Picture picture;
  Vec3 point_mm = Vec3::Zero();  ///< On the plane, in the middle of the picture.
  Vec3 normal = Vec3::UnitZ();   ///< Points to the viewer.
  double width_mm = 0;           ///< What the picture shows from left to right.
  std::uint64_t cells = 0;       ///< Cells cut, in the picture or beside it.
  ColourScale scale;
};

struct PictureOptions {
  int width = 1400;       ///< Pixels; the height follows the shape of the object, 0.45 to 1 of it.
  int supersampling = 3;  ///< Samples per pixel and direction.
};

/// The surface of the mesh against the outside, coloured by patch (one label) or by label (several), seen
/// from where the object spreads most, the patient's head up. Transparent background. The largest openings,
/// up to 40, get names around the object that do not overlap; they are not in the pixels, see with_names().
/// Threads: parallel inside, same pixels for every thread count. Cost: about 0.5 s for 100k triangles.
[[nodiscard]] SurfacePicture draw_surface(const MeshView& mesh, const quality::MeshSurface& surface,
                                          const PictureOptions& options = {});

/// How lines are drawn.
struct LinesOptions {
  int width = 1400;
  int supersampling = 3;
  double thickness_pixels = 9;  ///< Of the lines.
  std::string scalar =
      {};  ///< Name in Polylines::scalars, such as "radius"; empty, or not there: a colour per line.
  std::string scalar_name = {};  ///< What the scale says: "radius, mm".
};

/// The surface as through frosted glass with lines inside it, such as centerlines: each line has a colour of
/// its own, or the points of all are coloured by one of their scalars. What is nearer to the viewer hides
/// what is farther among the lines; the surface hides nothing. View, background, threads and cost as above.
[[nodiscard]] SurfacePicture draw_surface_with_lines(const MeshView& mesh,
                                                     const quality::MeshSurface& surface,
                                                     const Polylines& lines,
                                                     const LinesOptions& options = {});

/// The surface coloured by a value of its points, such as the size that is wanted there, on a logarithmic
/// scale from the 1st to the 99th percentile of its vertices' values.
/// @param values      One per point of the mesh, above 0 at vertices of the surface.
/// @param value_name  What the scale says: "edge length, mm".
[[nodiscard]] SurfacePicture draw_surface_values(const MeshView& mesh, const quality::MeshSurface& surface,
                                                 std::span<const double> values,
                                                 const std::string& value_name,
                                                 const PictureOptions& options = {});

/// The surface coloured by its discrete mean curvature (quality::wall_curvature()): blue where it is hollow,
/// grey where it is flat, red where it is convex. The scale ends at plus and minus area / volume, which is 2
/// / R of a straight vessel of radius R, whose own colour is a quarter of the way to red: stairs and ripples
/// stand out whatever else is in the picture. Openings have none and a colour of their own.
[[nodiscard]] SurfacePicture draw_surface_curvature(const MeshView& mesh, const quality::MeshSurface& surface,
                                                    const PictureOptions& options = {});

/// The outside of a mesh for pictures: from the boundary triangles that the mesh has where they enclose its
/// cells, which saves most of the time and memory of quality::extract_surface(); from that elsewhere.
[[nodiscard]] quality::MeshSurface surface_for_pictures(const MeshView& mesh);

/// Which way a cut view looks.
enum class CutDirection : std::uint8_t {
  kFront,  ///< From about where draw_surface() looks.
  kSide,   ///< About a quarter turn to the right, at least 45 degrees from the front.
};

/// What the colours of a cut tell.
enum class CutColours : std::uint8_t {
  kMeanRatio,        ///< Of the tetrahedra; other shapes: scaled Jacobian.
  kMetricMeanRatio,  ///< In the metric that the mesh carries; other shapes: scaled Jacobian.
};

/// A part of a plane.
struct CutWindow {
  Vec3 centre_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< Points to the viewer.
  double width_mm = 1;
};

/// What of a cut is shown, and how.
struct CutOptions {
  int width = 1400;
  int supersampling = 3;
  CutColours colours = CutColours::kMeanRatio;
  /// Enlarges that part of the section that is fullest until no more than so many cells are in it; 0: all of
  /// it is shown.
  std::uint64_t enlarge_to_cells = 0;
  /// Shows this part, whatever the direction: of two meshes the same place.
  std::optional<CutWindow> window = std::nullopt;
};

/// The mesh without the part in front of a plane: the cells on the plane as exact polygons with outlines,
/// coloured as quality_colour() says, and the surface behind. The plane is the one
/// with about the largest section of those that face the viewer within 40 degrees. Enlarged parts are seen
/// straight on, others a little from the side. Memory: 300 bytes per cell and triangle in the picture.
/// Threads: parallel inside, same pixels for every thread count.
[[nodiscard]] CutPicture draw_cut(const MeshView& mesh, const quality::MeshSurface& surface,
                                  CutDirection direction, const CutOptions& options = {});

/// Colour of a quality: from dark violet at 0.2 and below to yellow at 1 (the map "viridis", readable without
/// red-green vision and in print).
inline constexpr double kLowestColouredQuality = 0.2;
[[nodiscard]] Colour quality_colour(double quality);

/// The picture on a plain background.
[[nodiscard]] Picture on_background(const Picture& picture, Colour background);

/// The picture on a plain background with its names written into it.
[[nodiscard]] Picture with_names(const SurfacePicture& drawn, Colour background);

/// PNG file bytes.
[[nodiscard]] std::string encode_png(const Picture& picture);

}  // namespace lumesh::report
