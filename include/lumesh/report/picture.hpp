#pragma once
/// @file Pictures of meshes, drawn in software: no display, no graphics library.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
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
struct SurfacePicture {
  Picture picture;
  std::vector<LegendItem> legend;
};
struct CutPicture {
  Picture picture;
  Vec3 point_mm = Vec3::Zero();  ///< On the plane.
  Vec3 normal = Vec3::UnitZ();   ///< Points to the viewer.
  std::uint64_t cells = 0;       ///< Cells cut.
};

struct PictureOptions {
  int width = 1400;       ///< Pixels; the height follows the shape of the object, 0.45 to 1 of it.
  int supersampling = 3;  ///< Samples per pixel and direction.
};

/// The surface of the mesh against the outside, coloured by patch (one label) or by label (several), seen
/// from where the object spreads most, the patient's head up. Transparent background. Threads: parallel
/// inside, same pixels for every thread count. Cost: about 0.5 s for 100k triangles.
[[nodiscard]] SurfacePicture draw_surface(const MeshView& mesh, const quality::MeshSurface& surface,
                                          const PictureOptions& options = {});

/// Which way a cut view looks.
enum class CutDirection : std::uint8_t {
  kFront,  ///< From where draw_surface() looks.
  kSide,   ///< A quarter turn to the right.
};

/// The mesh without the part in front of a plane: the cells on the plane as exact polygons, coloured by mean
/// ratio (other shapes than tetrahedra: by scaled Jacobian) as quality_colour() says, and the surface behind.
/// The plane faces the viewer at the place of the largest section.
[[nodiscard]] CutPicture draw_cut(const MeshView& mesh, const quality::MeshSurface& surface,
                                  CutDirection direction, const PictureOptions& options = {});

/// Colour of a quality: from dark violet at 0.2 and below to yellow at 1 (the map "viridis", readable without
/// red-green vision and in print).
inline constexpr double kLowestColouredQuality = 0.2;
[[nodiscard]] Colour quality_colour(double quality);

/// The picture on a plain background.
[[nodiscard]] Picture on_background(const Picture& picture, Colour background);

/// PNG file bytes.
[[nodiscard]] std::string encode_png(const Picture& picture);

/// Writes a file beside its target and renames it when complete.
/// @throws Error{kBadInput} if it cannot be written; nothing is left behind then.
void write_file(const std::filesystem::path& path, std::string_view content);

}  // namespace lumesh::report
