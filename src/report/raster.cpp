#include "raster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lumesh/parallel/loops.hpp"

namespace lumesh::report {

namespace {

constexpr int kBandRows = 16;            // Output rows drawn by one task.
constexpr float kOutlinePixels = 0.42F;  // Half the width of an outline.
constexpr float kOutlineDarkness = 0.45F;
constexpr float kFar = -std::numeric_limits<float>::infinity();

using Float3 = std::array<float, 3>;

float dot(const Float3& a, const Float3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Float3 normalised(Float3 v) {
  const float length = std::sqrt(dot(v, v));
  for (float& x : v) x /= length;
  return v;
}

/// Colour of a triangle under a key light from the upper left, a fill light and a highlight, each channel in
/// [0, 1].
Float3 shade(const ScreenTriangle& triangle) {
  const Float3 base = {triangle.colour.red / 255.0F, triangle.colour.green / 255.0F,
                       triangle.colour.blue / 255.0F};
  if (triangle.matt) return base;
  Float3 n = triangle.normal;
  const bool inside = n[2] < 0;  // We look at the inner side of the wall.
  if (inside) n = {-n[0], -n[1], -n[2]};
  static const Float3 kKey = normalised({-0.45F, 0.65F, 0.75F}), kFill = normalised({0.7F, -0.1F, 0.5F}),
                      kHalf = normalised({-0.24F, 0.35F, 0.94F});
  const float light = 0.42F + 0.56F * std::max(0.0F, dot(n, kKey)) + 0.22F * std::max(0.0F, dot(n, kFill));
  const float highlight = inside ? 0.0F : 0.14F * std::pow(std::max(0.0F, dot(n, kHalf)), 24.0F);
  Float3 result;
  for (int c = 0; c < 3; ++c)
    result[c] = std::clamp((inside ? 0.72F : 1.0F) * light * base[c] + highlight, 0.0F, 1.0F);
  return result;
}

/// One output pixel while it is being made.
struct Pixel {
  Float3 colour = {0, 0, 0};  // Premultiplied by alpha.
  float alpha = 0;
  float depth = kFar;
  Float3 normal = {0, 0, 1};
};

struct Sample {
  float depth = kFar;
  std::uint32_t triangle = 0;
  float outline = 0;
};

/// A band of rows at full sampling.
class Band {
 public:
  Band(const std::vector<ScreenTriangle>& triangles, const std::vector<Float3>& shades, int width,
       int first_row, int rows, int supersampling)
      : triangles_(triangles),
        shades_(shades),
        width_(width * supersampling),
        first_row_(first_row * supersampling),
        rows_(rows * supersampling),
        sampling_(supersampling),
        samples_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(rows_)) {}

  void draw(std::uint32_t index) {
    const ScreenTriangle& t = triangles_[index];
    const auto s = static_cast<float>(sampling_);
    const std::array<float, 3> x = {t.corners[0][0] * s, t.corners[1][0] * s, t.corners[2][0] * s};
    const std::array<float, 3> y = {t.corners[0][1] * s, t.corners[1][1] * s, t.corners[2][1] * s};
    const float doubled_area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    if (!(std::abs(doubled_area) > 1e-6F)) return;
    const auto [low_x, high_x] = std::minmax({x[0], x[1], x[2]});
    const auto [low_y, high_y] = std::minmax({y[0], y[1], y[2]});
    const int begin_x = std::max(0, static_cast<int>(std::floor(low_x))),
              end_x = std::min(width_ - 1, static_cast<int>(high_x));
    const int begin_y = std::max(0, static_cast<int>(std::floor(low_y)) - first_row_),
              end_y = std::min(rows_ - 1, static_cast<int>(high_y) - first_row_);
    // Weight i is 1 in corner i and 0 on the side opposite; heights turn it into a distance from that side.
    Float3 height, along_x, along_y, start;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      along_x[i] = (y[j] - y[k]) / doubled_area;
      along_y[i] = (x[k] - x[j]) / doubled_area;
      start[i] = (x[j] * y[k] - x[k] * y[j]) / doubled_area;
      height[i] = std::abs(doubled_area) / std::hypot(x[k] - x[j], y[k] - y[j]);
    }
    const float strength = outline_strength(height);
    for (int row = begin_y; row <= end_y; ++row) {
      const float py = static_cast<float>(row + first_row_) + 0.5F;
      auto first = static_cast<float>(begin_x), last = static_cast<float>(end_x);
      Float3 offset;  // Weights at px = 0; those are >= 0 between two columns.
      for (int i = 0; i < 3; ++i) {
        offset[i] = start[i] + along_y[i] * py;
        const float zero = -offset[i] / along_x[i] - 0.5F;
        if (along_x[i] > 0) first = std::max(first, zero - 1);
        if (along_x[i] < 0) last = std::min(last, zero + 1);
      }
      for (int column = static_cast<int>(first); column <= static_cast<int>(last); ++column) {
        const float px = static_cast<float>(column) + 0.5F;
        const Float3 weights = {offset[0] + along_x[0] * px, offset[1] + along_x[1] * px,
                                offset[2] + along_x[2] * px};
        if (weights[0] < 0 || weights[1] < 0 || weights[2] < 0) continue;
        const float depth =
            weights[0] * t.corners[0][2] + weights[1] * t.corners[1][2] + weights[2] * t.corners[2][2];
        Sample& sample = samples_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                                  static_cast<std::size_t>(column)];
        if (!(depth > sample.depth)) continue;
        sample = {depth, index, on_outline(t, weights, height) ? strength : 0};
      }
    }
  }

  /// Averages the samples of one pixel.
  [[nodiscard]] Pixel resolve(int column, int row) const {
    Pixel pixel;
    Float3 normal = {0, 0, 0};
    for (int v = 0; v < sampling_; ++v)
      for (int u = 0; u < sampling_; ++u) {
        const Sample& sample =
            samples_[static_cast<std::size_t>(row * sampling_ + v) * static_cast<std::size_t>(width_) +
                     static_cast<std::size_t>(column * sampling_ + u)];
        if (sample.depth == kFar) continue;
        const float light = 1 - sample.outline;
        for (int c = 0; c < 3; ++c) {
          pixel.colour[c] += shades_[sample.triangle][c] * light;
          normal[c] += triangles_[sample.triangle].normal[c] *
                       (triangles_[sample.triangle].normal[2] < 0 ? -1.0F : 1.0F);
        }
        pixel.alpha += 1;
        pixel.depth = std::max(pixel.depth, sample.depth);
      }
    const auto samples = static_cast<float>(sampling_ * sampling_);
    if (dot(normal, normal) > 0) pixel.normal = normalised(normal);
    for (float& c : pixel.colour) c /= samples;
    pixel.alpha /= samples;
    return pixel;
  }

 private:
  /// Outlines fade where triangles get too small for them.
  [[nodiscard]] float outline_strength(const std::array<float, 3>& height) const {
    const float pixels = std::min({height[0], height[1], height[2]}) / static_cast<float>(sampling_);
    return kOutlineDarkness * std::clamp((pixels - 1) / 8, 0.0F, 1.0F);
  }
  [[nodiscard]] bool on_outline(const ScreenTriangle& t, const Float3& weights,
                                const std::array<float, 3>& height) const {
    for (int side = 0; side < 3; ++side) {
      const int opposite = (side + 2) % 3;
      if ((t.outlined >> side & 1) &&
          weights[opposite] * height[opposite] < kOutlinePixels * static_cast<float>(sampling_))
        return true;
    }
    return false;
  }

  const std::vector<ScreenTriangle>& triangles_;
  const std::vector<Float3>& shades_;
  int width_, first_row_, rows_, sampling_;
  std::vector<Sample> samples_;
};

constexpr int kAmbientSamples = 16;
constexpr int kAmbientPatterns =
    16;  // Differ from pixel to pixel: banding becomes fine noise, and the blur removes it.
using AmbientPatterns = std::array<std::array<std::array<int, 2>, kAmbientSamples>, kAmbientPatterns>;

/// Places around a pixel: spirals of the golden angle.
AmbientPatterns ambient_patterns(float reach) {
  constexpr float kGoldenAngle = 2.399963F;
  AmbientPatterns patterns;
  for (int pattern = 0; pattern < kAmbientPatterns; ++pattern)
    for (int i = 0; i < kAmbientSamples; ++i) {
      const float radius = reach * std::sqrt((static_cast<float>(i) + 0.5F) / kAmbientSamples);
      const float angle = kGoldenAngle * static_cast<float>(i + pattern);
      patterns[pattern][i] = {static_cast<int>(std::lround(radius * std::cos(angle))),
                              static_cast<int>(std::lround(radius * std::sin(angle)))};
    }
  return patterns;
}

/// Share of the light that reaches a pixel past its surroundings on the screen.
/// Source: McGuire et al. 2011, "The Alchemy screen-space ambient obscurance algorithm", HPG.
float ambient_obscurance(const std::vector<Pixel>& pixels, int width, int height,
                         const AmbientPatterns& patterns, float reach, int x, int y) {
  const auto at = [&](int u, int v) -> const Pixel& {
    return pixels[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(u)];
  };
  const Pixel& here = at(x, y);
  float blocked = 0;
  for (const auto& [dx, dy] : patterns[(x * 7 + y * 3) % kAmbientPatterns]) {
    const int u = x + dx, v = y + dy;
    if (u < 0 || v < 0 || u >= width || v >= height) continue;
    const Pixel& there = at(u, v);
    if (there.alpha == 0) continue;
    const Float3 way = {static_cast<float>(dx), static_cast<float>(-dy), there.depth - here.depth};
    const float squared = dot(way, way);
    blocked += std::max(0.0F, dot(way, here.normal) - 0.06F * std::sqrt(squared) - 0.5F) / (squared + 4);
  }
  return std::max(0.0F, 1 - 0.55F * reach * blocked / kAmbientSamples);
}

/// Averages seven pixels along a row (step 1) or a column (step width) that lie at about the same depth.
std::vector<float> blur(const std::vector<Pixel>& pixels, const std::vector<float>& values,
                        std::size_t step) {
  constexpr std::size_t kReach = 3;
  constexpr float kSameDepth = 12;  // Pixels.
  std::vector<float> smooth(values.size(), 1);
  parallel::for_each_index(values.size(), 8192, [&](std::size_t i) {
    const Pixel& here = pixels[i];
    if (here.alpha == 0) return;
    float sum = values[i], weight = 1;
    for (std::size_t k = 1; k <= kReach; ++k)
      for (const std::size_t j : {i - k * step, i + k * step}) {  // Below 0 wraps around beyond the end.
        if (j >= values.size() || pixels[j].alpha == 0 || std::abs(pixels[j].depth - here.depth) > kSameDepth)
          continue;
        sum += values[j];
        weight += 1;
      }
    smooth[i] = sum / weight;
  });
  return smooth;
}

std::vector<float> ambient(const std::vector<Pixel>& pixels, int width, int height) {
  const auto columns = static_cast<std::size_t>(width);
  std::vector<float> light(pixels.size(), 1);
  const float reach = static_cast<float>(width) / 28;
  const AmbientPatterns patterns = ambient_patterns(reach);
  parallel::for_each_index(static_cast<std::size_t>(height), 8, [&](std::size_t y) {
    for (std::size_t x = 0; x < columns; ++x)
      if (pixels[y * columns + x].alpha > 0)
        light[y * columns + x] = ambient_obscurance(pixels, width, height, patterns, reach,
                                                    static_cast<int>(x), static_cast<int>(y));
  });
  return blur(pixels, blur(pixels, light, 1), columns);
}

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0F, 1.0F)));
}

Picture finish(const std::vector<Pixel>& pixels, int width, int height) {
  const std::vector<float> light = ambient(pixels, width, height);
  Picture picture{width, height, std::vector<std::uint8_t>(4 * pixels.size(), 0)};
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Pixel& p = pixels[i];
    if (p.alpha == 0) continue;
    for (std::size_t c = 0; c < 3; ++c) picture.rgba[4 * i + c] = to_byte(p.colour[c] / p.alpha * light[i]);
    picture.rgba[4 * i + 3] = to_byte(p.alpha);
  }
  return picture;
}

/// Triangles that touch each band, in their order.
std::vector<std::vector<std::uint32_t>> deal_into_bands(const std::vector<ScreenTriangle>& triangles,
                                                        int bands) {
  std::vector<std::vector<std::uint32_t>> dealt(static_cast<std::size_t>(bands));
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const auto& c = triangles[t].corners;
    const auto [low, high] = std::minmax({c[0][1], c[1][1], c[2][1]});
    const int first = std::max(0, static_cast<int>(low) / kBandRows),
              last = std::min(bands - 1, static_cast<int>(high) / kBandRows);
    for (int b = first; b <= last; ++b) dealt[static_cast<std::size_t>(b)].push_back(t);
  }
  return dealt;
}

}  // namespace

Picture rasterise(const std::vector<ScreenTriangle>& triangles, int width, int height, int supersampling) {
  std::vector<Float3> shades(triangles.size());
  parallel::for_each_index(triangles.size(), [&](std::size_t t) { shades[t] = shade(triangles[t]); });
  const int bands = (height + kBandRows - 1) / kBandRows;
  const auto dealt = deal_into_bands(triangles, bands);
  std::vector<Pixel> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  parallel::for_each_index(static_cast<std::size_t>(bands), 1, [&](std::size_t b) {
    const int first_row = static_cast<int>(b) * kBandRows, rows = std::min(kBandRows, height - first_row);
    Band band(triangles, shades, width, first_row, rows, supersampling);
    for (const std::uint32_t t : dealt[b]) band.draw(t);
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < width; ++column)
        pixels[static_cast<std::size_t>(first_row + row) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(column)] = band.resolve(column, row);
  });
  return finish(pixels, width, height);
}

}  // namespace lumesh::report
