#include "lumesh/domain/carried_section.hpp"

#include <algorithm>
#include <cmath>

namespace lumesh {

double CarriedSection::inside_section_mm(const Vec3& on_plane) const {
  const Vec3 off = on_plane - first_mm;
  const double x = off.dot(u) / step_mm, y = off.dot(v) / step_mm;
  const double column = std::clamp(x, 0.0, columns - 1.0), row = std::clamp(y, 0.0, rows - 1.0);
  const int i = std::min(static_cast<int>(column), std::max(columns - 2, 0));
  const int j = std::min(static_cast<int>(row), std::max(rows - 2, 0));
  const auto at = [&](int a, int b) {
    return static_cast<double>(
        inside[static_cast<std::size_t>(std::min(a, columns - 1)) +
               static_cast<std::size_t>(columns) * static_cast<std::size_t>(std::min(b, rows - 1))]);
  };
  const double s = column - i, t = row - j;
  const double low = (1 - s) * at(i, j) + s * at(i + 1, j);
  const double high = (1 - s) * at(i, j + 1) + s * at(i + 1, j + 1);
  return (1 - t) * low + t * high - step_mm * std::hypot(x - column, y - row);
}

double CarriedSection::inside_mm(const Vec3& x) const {
  return std::max(inside_section_mm(carried_back(x)), circle_mm - off_axis_mm(x));
}

}  // namespace lumesh
