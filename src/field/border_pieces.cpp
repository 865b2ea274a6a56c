#include "border_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lumesh/core/squares.hpp"

namespace lumesh::field {

BorderLayer::BorderLayer(const LabelImage& image, BorderParts parts, int axis, bool is_upper, int depth)
    : image_(image),
      parts_(parts),
      size_(image.frame().size),
      axis_(axis),
      layer_(is_upper ? size_[axis] - 1 : 0),
      depth_(depth) {
  const auto [u, v] = axes_across(axis);
  const auto columns = static_cast<std::size_t>(size_[u]), rows = static_cast<std::size_t>(size_[v]);
  number_ = connected_squares(columns, columns * rows, [&](std::size_t at) { return part_at(voxel(at)); });
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
      all_.push_back({.window = window_, .voxels = {v, v}, .first = at, .number = number_[at]});
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
  for (BorderPiece piece : all_) {
    const auto count = static_cast<double>(piece.count);
    if (count < kMinVoxels || count > most || !is_clear(piece, room)) continue;
    if (parts_ == BorderParts::kEnclosedLabels) {
      piece.label = part_at(voxel(piece.first)), piece.around = label_around(piece);
      if (piece.around == 0) continue;
    }
    result.push_back(with_window(piece));
  }
  return result;
}

bool BorderLayer::is_clear(const BorderPiece& piece, int room) const {
  for (const int a : axes_across(axis_))
    if (piece.voxels.low[a] == 0 || piece.voxels.high[a] + 1 == size_[a]) return false;
  const LabelIndex part = part_at(voxel(piece.first));
  const IndexBox around = grown(piece.voxels, room);
  return !is_any_place(around.low, around.high,
                       [&](const Index3& v) { return part_at(v) == part && number_at(v) != piece.number; });
}

/// The label of a voxel, or 1 for all.
LabelIndex BorderLayer::part_at(const Index3& voxel) const {
  const LabelIndex label = image_.at(voxel);
  return parts_ == BorderParts::kObject && label != 0 ? LabelIndex{1} : label;
}

/// The only one beside a piece's voxels; 0 if there is background or another one, too.
LabelIndex BorderLayer::label_around(const BorderPiece& piece) const {
  LabelIndex found = 0;
  bool is_only = true;
  const IndexBox box = grown(piece.voxels, 1);
  for_each_place(box.low, box.high, [&](const Index3& v) {
    if (number_at(v) != piece.number) return;
    for (const int a : axes_across(axis_))
      for (const int step : {-1, 1}) {
        const LabelIndex label = image_.at(v + step * Index3::Unit(a));
        if (label == piece.label) continue;
        is_only = is_only && label != 0 && (found == 0 || found == label);
        found = label;
      }
  });
  return is_only ? found : LabelIndex{0};
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
