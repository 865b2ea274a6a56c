#include <algorithm>
#include <cmath>
#include <string_view>

#include "lumesh/report/drawing.hpp"
#include "lumesh/report/picture.hpp"

namespace lumesh::report {

namespace {

/// Letters that names have, as lines between points "xy" on a grid of a tenth of the height of a line; x from
/// 0 to 4, y upwards with the foot of letters at 2. A point twice is a dot.
struct Letter {
  char letter;
  std::string_view strokes;
};
constexpr std::array<Letter, 66> kLetters = {{
    {'a', "47 42,46 37 17 06 03 12 32 43"},
    {'b', "09 02,06 17 37 46 43 32 12 03"},
    {'c', "46 37 17 06 03 12 32 43"},
    {'d', "49 42,46 37 17 06 03 12 32 43"},
    {'e', "05 45 46 37 17 06 03 12 32 43"},
    {'f', "49 29 18 12,07 37"},
    {'g', "47 41 30 10,46 37 17 06 03 12 32 43"},
    {'h', "09 02,06 17 37 46 42"},
    {'i', "17 27 22,29 29,12 32"},
    {'j', "27 37 31 20 10,39 39"},
    {'k', "09 02,47 04,15 42"},
    {'l', "19 29 23 32 42"},
    {'m', "07 02,06 17 26 22,26 37 46 42"},
    {'n', "07 02,06 17 37 46 42"},
    {'o', "03 06 17 37 46 43 32 12 03"},
    {'p', "07 00,06 17 37 46 43 32 12 03"},
    {'q', "47 40,46 37 17 06 03 12 32 43"},
    {'r', "17 12,15 27 37 46"},
    {'s', "46 37 17 06 15 34 43 32 12 03"},
    {'t', "19 13 22 32 43,07 37"},
    {'u', "07 03 12 32 43,47 42"},
    {'v', "07 22 47"},
    {'w', "07 12 26 32 47"},
    {'x', "07 42,02 47"},
    {'y', "07 22,47 10 00"},
    {'z', "07 47 02 42"},
    {'A', "02 29 42,14 34"},
    {'B', "02 09 39 48 47 36 06,36 45 43 32 02"},
    {'C', "48 39 19 08 03 12 32 43"},
    {'D', "02 09 29 47 44 22 02"},
    {'E', "49 09 02 42,06 36"},
    {'F', "49 09 02,06 36"},
    {'G', "48 39 19 08 03 12 32 43 45 25"},
    {'H', "09 02,49 42,06 46"},
    {'I', "19 39,29 22,12 32"},
    {'J', "49 43 32 12 03"},
    {'K', "09 02,49 05,16 42"},
    {'L', "09 02 42"},
    {'M', "02 09 25 49 42"},
    {'N', "02 09 42 49"},
    {'O', "03 08 19 39 48 43 32 12 03"},
    {'P', "02 09 39 48 46 35 05"},
    {'Q', "03 08 19 39 48 43 32 12 03,24 42"},
    {'R', "02 09 39 48 46 35 05,25 42"},
    {'S', "48 39 19 08 07 16 36 45 43 32 12 03"},
    {'T', "09 49,29 22"},
    {'U', "09 03 12 32 43 49"},
    {'V', "09 22 49"},
    {'W', "09 12 26 32 49"},
    {'X', "09 42,02 49"},
    {'Y', "09 26 49,26 22"},
    {'Z', "09 49 02 42"},
    {'0', "03 08 19 39 48 43 32 12 03,25 26"},
    {'1', "07 29 22,12 32"},
    {'2', "08 19 39 48 46 02 42"},
    {'3', "08 19 39 48 47 36 16,36 45 43 32 12 03"},
    {'4', "32 39 04 44"},
    {'5', "49 09 06 36 45 43 32 12 03"},
    {'6', "48 39 19 08 03 12 32 43 45 36 16 05"},
    {'7', "09 49 22"},
    {'8', "16 07 08 19 39 48 47 36 16 05 03 12 32 43 45 36"},
    {'9', "03 12 32 43 48 39 19 08 06 15 35 46"},
    {'_', "01 41"},
    {'-', "05 45"},
    {'.', "22 22"},
    {' ', ""},
}};
constexpr std::string_view kUnknown = "02 09 49 42 02";
constexpr Colour kInk = {29, 33, 38};

std::string_view strokes_of(char letter) {
  const auto* const found =
      std::ranges::find_if(kLetters, [&](const Letter& known) { return known.letter == letter; });
  return found == kLetters.end() ? kUnknown : found->strokes;
}

/// A pen with a round tip on an opaque picture.
struct Pen {
  Picture& picture;
  double width = 1;
  Colour colour;

  void draw_line(const PixelPlace& a, const PixelPlace& b) const {
    const double reach = width / 2 + 1;
    const int begin_x = std::max(0, static_cast<int>(std::min(a[0], b[0]) - reach)),
              end_x = std::min(picture.width, static_cast<int>(std::max(a[0], b[0]) + reach) + 1),
              begin_y = std::max(0, static_cast<int>(std::min(a[1], b[1]) - reach)),
              end_y = std::min(picture.height, static_cast<int>(std::max(a[1], b[1]) + reach) + 1);
    for (int y = begin_y; y < end_y; ++y)
      for (int x = begin_x; x < end_x; ++x)
        blend(x, y, std::clamp(width / 2 + 0.5 - distance({x + 0.5, y + 0.5}, a, b), 0.0, 1.0));
  }

 private:
  static double distance(const PixelPlace& p, const PixelPlace& a, const PixelPlace& b) {
    const PixelPlace along = {b[0] - a[0], b[1] - a[1]}, way = {p[0] - a[0], p[1] - a[1]};
    const double squared = along[0] * along[0] + along[1] * along[1];
    const double share =
        squared > 0 ? std::clamp((way[0] * along[0] + way[1] * along[1]) / squared, 0.0, 1.0) : 0.0;
    return std::hypot(way[0] - share * along[0], way[1] - share * along[1]);
  }
  void blend(int x, int y, double share) const {
    const std::size_t pixel = 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                                   static_cast<std::size_t>(x));
    const std::array<std::uint8_t, 3> to = {colour.red, colour.green, colour.blue};
    for (std::size_t c = 0; c < 3; ++c) {
      const double from = picture.rgba[pixel + c];
      picture.rgba[pixel + c] = static_cast<std::uint8_t>(std::lround(from + share * (to[c] - from)));
    }
  }
};

void write_text(const Pen& pen, const PictureLabel& label, double letter) {
  PixelPlace origin = {label.low[0] + 0.3 * letter, (label.low[1] + label.high[1]) / 2 + 0.55 * letter};
  for (const char c : label.text) {
    if ((c & 0xC0) == 0x80) continue;  // The rest of a letter beyond ASCII.
    const std::string_view strokes = strokes_of(c);
    const auto point = [&](std::size_t i) {
      return PixelPlace{origin[0] + (strokes[i] - '0') * letter / 10,
                        origin[1] - (strokes[i + 1] - '0') * letter / 10};
    };
    for (std::size_t i = 0; i + 4 < strokes.size(); i += 3)
      if (strokes[i + 2] == ' ') pen.draw_line(point(i), point(i + 3));
    origin[0] += kLetterWidth * letter;
  }
}

/// Dashed where the opening is hidden.
void draw_arrow(const Pen& pen, const PictureLabel& label, double letter) {
  const PixelPlace way = {label.from[0] - label.at[0], label.from[1] - label.at[1]};
  const double length = std::max(std::hypot(way[0], way[1]), 1e-9);
  const PixelPlace along = {way[0] / length * letter, way[1] / length * letter};
  const auto point = [&](double out, double aside) {
    return PixelPlace{label.at[0] + out * along[0] - aside * along[1],
                      label.at[1] + out * along[1] + aside * along[0]};
  };
  for (const double side : {-0.22, 0.22}) pen.draw_line(point(0, 0), point(0.55, side));
  const double end = length / letter;
  for (double out = 0; out < end; out += label.is_hidden ? 0.5 : end)
    pen.draw_line(point(out, 0), point(label.is_hidden ? std::min(out + 0.25, end) : end, 0));
}

}  // namespace

Picture with_names(const SurfacePicture& drawn, Colour background) {
  Picture picture = on_background(drawn.picture, background);
  const double letter = drawn.names.letter_pixels;
  const Pen halo = {picture, 0.3 * letter, background};
  for (const PictureLabel& label : drawn.names.labels) draw_arrow(halo, label, letter);
  for (const PictureLabel& label : drawn.names.labels)
    draw_arrow({picture, 0.085 * letter, kInk}, label, letter);
  for (const PictureLabel& label : drawn.names.labels) write_text(halo, label, letter);
  for (const PictureLabel& label : drawn.names.labels)
    write_text({picture, 0.105 * letter, kInk}, label, letter);
  return picture;
}

}  // namespace lumesh::report
