#pragma once
/// @file Orders of the six numbers of a tensor in files, and the check that an array of tensors is a metric.

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "lumesh/core/types.hpp"

namespace lumesh::io {

/// The six numbers in the order of a file.
using TensorNumbers = std::array<double, 6>;

/// What VTK and ParaView call the components, in their order.
inline constexpr std::array<std::string_view, 6> kVtkTensorNames = {"XX", "YY", "ZZ", "XY", "YZ", "XZ"};

[[nodiscard]] constexpr TensorNumbers to_vtk_order(const SymTensor& t) {
  return {t.xx, t.yy, t.zz, t.xy, t.yz, t.xz};
}
[[nodiscard]] constexpr SymTensor from_vtk_order(const TensorNumbers& n) {
  return {.xx = n[0], .xy = n[3], .xz = n[5], .yy = n[1], .yz = n[4], .zz = n[2]};
}

/// Medit: the lower triangle by rows.
[[nodiscard]] constexpr TensorNumbers to_medit_order(const SymTensor& t) {
  return {t.xx, t.xy, t.yy, t.xz, t.yz, t.zz};
}
[[nodiscard]] constexpr SymTensor from_medit_order(const TensorNumbers& n) {
  return {.xx = n[0], .xy = n[1], .xz = n[3], .yy = n[2], .yz = n[4], .zz = n[5]};
}

/// The point array `metric` of a VTK file.
/// @param values      Tuple after tuple, of 6 numbers in VTK's order or of 9, the full matrix by rows.
/// @param components  Numbers per tuple.
/// @throws Error{kBadInput} naming `path` if there are other components, not as many tuples as points, or a
/// tensor that is not symmetric, finite and positive definite (the message counts points from 0, as VTK
/// does).
[[nodiscard]] std::vector<SymTensor> metric_from_vtk(const std::filesystem::path& path,
                                                     std::span<const double> values, std::size_t components,
                                                     std::size_t points);

}  // namespace lumesh::io
