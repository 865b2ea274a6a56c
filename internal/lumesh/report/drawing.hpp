#pragma once
/// @file Pictures of meshes, drawn in software: no display, no graphics library.

#include <cstdint>
#include <optional>
#include <string>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/quality/surface.hpp"
#include "lumesh/report/picture.hpp"

namespace lumesh::report {

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
  double thickness_pixels = 9;  ///< Thickness of the lines.
  std::string scalar =
      {};  ///< Name in Polylines::scalars, such as "radius"; empty, or not there: a colour per line.
  std::string scalar_name = {};  ///< Title of the scale: "radius, mm".
};

/// The surface as through frosted glass with lines inside it, such as centerlines: each line has a colour of
/// its own, or the points of all are coloured by one of their scalars. What is nearer to the viewer hides
/// what is farther among the lines; the surface hides nothing. View, background, threads and cost as above.
[[nodiscard]] SurfacePicture draw_surface_with_lines(const MeshView& mesh,
                                                     const quality::MeshSurface& surface,
                                                     const Polylines& lines,
                                                     const LinesOptions& options = {});

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

/// Quantity that the colours of a cut show.
enum class CutColours : std::uint8_t {
  kMeanRatio,        ///< Mean ratio of the tetrahedra; other shapes: scaled Jacobian.
  kMetricMeanRatio,  ///< In the metric that the mesh carries; other shapes: scaled Jacobian.
};

/// Choice of what a cut shows, and how.
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
