#pragma once
/// @file Pictures of meshes with what their colours and names mean.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lumesh/core/types.hpp"

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

/// One colour of a picture and the name of what has it.
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
  double width_mm = 0;           ///< Width of what the picture shows.
  std::uint64_t cells = 0;       ///< Cells cut, in the picture or beside it.
  ColourScale scale;
};

struct PictureOptions {
  int width = 1400;       ///< Pixels; the height follows the shape of the object, 0.45 to 1 of it.
  int supersampling = 3;  ///< Samples per pixel and direction.
};

/// A part of a plane.
struct CutWindow {
  Vec3 centre_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< Points to the viewer.
  double width_mm = 1;
};

}  // namespace lumesh::report
