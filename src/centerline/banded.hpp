#pragma once
/// @file Linear equations whose unknowns meet only near ones.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace lumesh::centerline {

/// A symmetric positive definite matrix with `kWidth` entries beside the diagonal.
template <std::size_t kWidth>
class BandedMatrix {
 public:
  explicit BandedMatrix(std::size_t size) : rows_(size, std::array<double, kWidth + 1>{}) {}

  /// Adds to entry (row, column) and its mirror image; row >= column >= row - kWidth.
  void add(std::size_t row, std::size_t column, double value) { rows_[row][column + kWidth - row] += value; }

  /// Solves for the right side given, by Cholesky's factors, which replace the matrix.
  [[nodiscard]] std::vector<double> solve(std::vector<double> x) && {
    factorise();
    const std::size_t size = rows_.size();
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t j = first(i); j < i; ++j) x[i] -= at(i, j) * x[j];
      x[i] /= at(i, i);
    }
    for (std::size_t i = size; i-- > 0;) {
      x[i] /= at(i, i);
      for (std::size_t j = first(i); j < i; ++j) x[j] -= at(i, j) * x[i];
    }
    return x;
  }

 private:
  [[nodiscard]] static std::size_t first(std::size_t row) { return row > kWidth ? row - kWidth : 0; }
  double& at(std::size_t row, std::size_t column) { return rows_[row][column + kWidth - row]; }

  void factorise() {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      for (std::size_t j = first(i); j <= i; ++j) {
        double sum = at(i, j);
        for (std::size_t k = std::max(first(i), first(j)); k < j; ++k) sum -= at(i, k) * at(j, k);
        at(i, j) = i == j ? std::sqrt(sum) : sum / at(j, j);
      }
    }
  }

  std::vector<std::array<double, kWidth + 1>> rows_;
};

}  // namespace lumesh::centerline
