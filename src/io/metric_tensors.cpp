#include "metric_tensors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "file_fault.hpp"
#include "lumesh/geometry/metric_fault.hpp"

namespace lumesh::io {

namespace {

constexpr std::size_t kFullMatrix = 9;

/// Half the difference of the entries may be rounding of single precision, no more.
bool is_symmetric(std::span<const double> matrix) {
  constexpr double kTolerance = 1e-5;
  double largest = 0;
  for (const double entry : matrix) largest = std::max(largest, std::abs(entry));
  const auto close = [&](std::size_t a, std::size_t b) {
    return !(std::abs(matrix[a] - matrix[b]) > kTolerance * largest);
  };
  return close(1, 3) && close(2, 6) && close(5, 7);
}

SymTensor from_full_matrix(std::span<const double> m) {
  return {m[0], (m[1] + m[3]) / 2, (m[2] + m[6]) / 2, m[4], (m[5] + m[7]) / 2, m[8]};
}

}  // namespace

std::vector<SymTensor> metric_from_vtk(const std::filesystem::path& path, std::span<const double> values,
                                       std::size_t components, std::size_t points) {
  constexpr std::string_view kRemedy = "rename the array if it is no metric";
  const std::size_t six = TensorNumbers{}.size();
  if (components != six && components != kFullMatrix)
    fail(path, fmt::format("the point array metric has {} components instead of 6 ({}) or 9; {}", components,
                           fmt::join(kVtkTensorNames, " "), kRemedy));
  if (values.size() != components * points)
    fail(path, fmt::format("the point array metric has {} tensors, the mesh has {} points; write it again",
                           values.size() / components, points));
  std::vector<SymTensor> metric(points);
  for (std::size_t p = 0; p < points; ++p) {
    const auto tuple = values.subspan(p * components, components);
    if (components == kFullMatrix && !is_symmetric(tuple))
      fail(path, fmt::format("the metric at point {} is not symmetric; {}", p, kRemedy));
    if (components == kFullMatrix) {
      metric[p] = from_full_matrix(tuple);
    } else {
      TensorNumbers numbers{};
      std::copy(tuple.begin(), tuple.end(), numbers.begin());
      metric[p] = from_vtk_order(numbers);
    }
    if (const std::string_view fault = metric_fault(metric[p]); !fault.empty())
      fail(path, fmt::format("the metric at point {} {}; the order is {}, {}", p, fault,
                             fmt::join(kVtkTensorNames, " "), kRemedy));
  }
  return metric;
}

}  // namespace lumesh::io
