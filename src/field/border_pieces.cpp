#include "border_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lumesh/core/squares.hpp"

namespace lumesh::field {

BorderLayer::BorderLayer(const LabelImage& image, int axis, bool is_upper, int depth)
    : size_(image.frame().size), axis_(axis), layer_(is_upper ? size_[axis] - 1 : 0), depth_(depth) {
  const auto [u, v] = axes_across(axis);
  const auto columns = static_cast<std::size_t>(size_[u]), rows = static_cast<std::size_t>(size_[v]);
  number_ =
      connected_squares(columns, columns * rows, [&](std::size_t at) { return image.at(voxel(at)) != 0; });
  collect();
  const Vec3& edges = image.frame().spacing_mm;
  window_.axis = axis, window_.is_upper = is_upper;
  window_.border = is_upper ? size_[axis] - 0.5 : -0.5;
  window_.step = std::max(1.0, std::cbrt(edges.prod()) / edges[axis]);
}

void BorderLayer::collect() {
  for (std::size_t at = 0; at < number_.size(); ++at) {
    if (number_[at] == 0) continue;
    const Index3 v = voxel(at);
    if (number_[at] > all_.size())
      all_.push_back({.window = window_, .voxels = {v, v}, .count = 0, .number = number_[at]});
    BorderPiece& piece = all_[number_[at] - 1];
    piece.voxels = {piece.voxels.low.cwiseMin(v), piece.voxels.high.cwiseMax(v)};
    ++piece.count;
  }
}

std::vector<BorderPiece> BorderLayer::pieces(double widest, int room) const {
  constexpr double kMinVoxels = 4, kMaxSlant = 1.6;  // Of a section, to one square to the axis.
  const double most = kMaxSlant * std::numbers::pi * widest * widest;
  std::vector<BorderPiece> result;
  if (size_[axis_] <= depth_ * window_.step + 1) return result;
  for (const BorderPiece& piece : all_) {
    const auto count = static_cast<double>(piece.count);
    if (count >= kMinVoxels && count <= most && is_clear(piece, room)) result.push_back(with_window(piece));
  }
  return result;
}

bool BorderLayer::is_clear(const BorderPiece& piece, int room) const {
  for (const int a : axes_across(axis_))
    if (piece.voxels.low[a] == 0 || piece.voxels.high[a] + 1 == size_[a]) return false;
  const IndexBox around = grown(piece.voxels, room);
  return !is_any_place(around.low, around.high,
                       [&](const Index3& v) { return number_at(v) != 0 && number_at(v) != piece.number; });
}

/// Sections further in lie beside the piece.
BorderPiece BorderLayer::with_window(BorderPiece piece) const {
  constexpr double kSteepest = 1.25;  // Slope of an axis against the layer's normal.
  const auto [u, v] = axes_across(axis_);
  const IndexBox around = grown(piece.voxels, 2 + static_cast<int>(kSteepest * depth_ * window_.step));
  piece.window = window_;
  piece.window.low = around.low;
  piece.window.columns = kSquaresPerVoxel * (around.high[u] - around.low[u] + 1);
  piece.window.rows = kSquaresPerVoxel * (around.high[v] - around.low[v] + 1);
  return piece;
}

std::vector<std::uint8_t> BorderLayer::squares_of(const BorderPiece& piece) const {
  std::vector<std::uint8_t> result(piece.window.count());
  for (std::size_t s = 0; s < result.size(); ++s)
    result[s] = number_at(piece.window.voxel(s)) == piece.number ? 1 : 0;
  return result;
}

Index3 BorderLayer::voxel(std::size_t at) const {
  const auto [u, v] = axes_across(axis_);
  const auto wide = static_cast<std::size_t>(size_[u]);
  Index3 result;
  result[axis_] = layer_, result[u] = static_cast<int>(at % wide), result[v] = static_cast<int>(at / wide);
  return result;
}

std::uint32_t BorderLayer::number_at(const Index3& voxel) const {
  const auto [u, v] = axes_across(axis_);
  return number_[static_cast<std::size_t>(voxel[u]) +
                 static_cast<std::size_t>(size_[u]) * static_cast<std::size_t>(voxel[v])];
}

/// A box and so many voxels around it in the layer.
IndexBox BorderLayer::grown(const IndexBox& box, int voxels) const {
  Index3 by = Index3::Constant(voxels);
  by[axis_] = 0;
  return {(box.low - by).cwiseMax(0), (box.high + by).cwiseMin(size_ - Index3::Ones())};
}

}  // namespace lumesh::field
