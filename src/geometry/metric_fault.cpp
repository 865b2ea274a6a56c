#include "lumesh/geometry/metric_fault.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lumesh {

namespace {

/// The pivots of L D L^T, each against the rounding of the entry it is taken from. Scaling an axis does not
/// change what this decides, so strong anisotropy along the axes costs nothing; the determinant and the
/// minors would under- or overflow.
bool positive_definite(const SymTensor& t) {
  constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
  if (!(t.xx > 0 && t.yy > 0 && t.zz > 0)) return false;
  const double l_yx = t.xy / t.xx;
  const double l_zx = t.xz / t.xx;
  const double pivot_y = t.yy - l_yx * t.xy;
  if (!(pivot_y > kRounding * t.yy)) return false;
  const double below = t.yz - l_zx * t.xy;
  const double pivot_z = t.zz - l_zx * t.xz - below / pivot_y * below;
  return pivot_z > kRounding * t.zz;
}

}  // namespace

std::string_view metric_fault(const SymTensor& tensor) {
  for (const double number : {tensor.xx, tensor.xy, tensor.xz, tensor.yy, tensor.yz, tensor.zz})
    if (!std::isfinite(number)) return "is not finite";
  return positive_definite(tensor) ? "" : "is not positive definite";
}

bool is_metric(const SymTensor& tensor) {
  constexpr double kMaxStretch = 1e30;  // Of inverse squares of sizes.
  const auto [min, max] = std::minmax({tensor.xx, tensor.yy, tensor.zz});
  return metric_fault(tensor).empty() && max <= kMaxStretch * min;
}

}  // namespace lumesh
