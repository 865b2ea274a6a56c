#pragma once
/// @file Lengths and shapes in a metric, as inline functions for hot loops.

#include <bit>
#include <cmath>
#include <cstdint>

#include "lumesh/core/types.hpp"

namespace lumesh::metric {

/// Logarithmic mean (a - b) / ln(a / b) of two numbers >= 0, a where they are equal; relative error below
/// 1e-8.
[[nodiscard]] inline double logarithmic_mean(double a, double b) {
  const double sum = a + b, x = (a - b) / sum, x2 = x * x;
  // ln(a / b) = 2 atanh(x); its series needs no logarithm where the numbers are less than 1.5 times apart.
  if (x2 < 0.04) return 0.5 * sum / (1 + x2 * (1.0 / 3 + x2 * (1.0 / 5 + x2 * (1.0 / 7 + x2 * (1.0 / 9)))));
  if (!(sum > 0) || !(a > 0) || !(b > 0)) return 0;
  return (a - b) / std::log(a / b);
}

/// Length of the edge from a to b when sizes vary geometrically along it. Source: Alauzet 2010,
/// doi:10.1016/j.finel.2009.06.028, page 185; "Metric Edge Length" of UGAWG's MEASURES.md; derived in
/// docs/stages/adapt.md, "Lengths and shapes".
[[nodiscard]] inline double edge_length(const Vec3& a, const SymTensor& metric_a, const Vec3& b,
                                        const SymTensor& metric_b) {
  const Vec3 edge = b - a;
  return logarithmic_mean(std::sqrt(metric_a.quadratic(edge)), std::sqrt(metric_b.quadratic(edge)));
}

/// Edges in this band count as of unit length.
inline constexpr double kShortestUnit = 0.70710678118654752, kLongestUnit = 1.41421356237309505;

/// exp(L) of a trace-free tensor L as its polynomial c0 + c1 L + c2 L^2.
struct ExpPolynomial {
  double c0, c1, c2;
};

/// By scaling, a Taylor polynomial and squarings in the ring of polynomials modulo the characteristic one: no
/// eigenvalues, no loops and no branches, so that compilers work on several tensors at a time. The relative
/// error of each eigenvalue is below 1e-6 for sizes up to 10^6 apart; tests/unit/metric compares it with
/// eigenvalues.
///
/// @param half_square_trace  Half the trace of L^2.
/// @param determinant        Of L.
[[nodiscard, gnu::always_inline]] inline ExpPolynomial exp_of_trace_free(double half_square_trace,
                                                                         double determinant) {
  // Cayley and Hamilton: N^3 = alpha N + beta for N = L / 64.
  constexpr double scale = 1.0 / 64;
  const double alpha = half_square_trace * (scale * scale), beta = determinant * (scale * scale * scale);
  double c0 = 1.0 / 720, c1 = 0, c2 = 0;
  const auto times_n_plus = [&](double next) {  // Horner's step.
    const double old_c0 = c0, old_c1 = c1;
    c0 = beta * c2 + next;
    c1 = old_c0 + alpha * c2;
    c2 = old_c1;
  };
  times_n_plus(1.0 / 120);
  times_n_plus(1.0 / 24);
  times_n_plus(1.0 / 6);
  times_n_plus(0.5);
  times_n_plus(1);
  times_n_plus(1);
  const auto square = [&] {
    const double p0 = c0 * c0, p1 = 2 * c0 * c1, p2 = c1 * c1 + 2 * c0 * c2, p3 = 2 * c1 * c2, p4 = c2 * c2;
    c0 = p0 + beta * p3;
    c1 = p1 + alpha * p3 + beta * p4;
    c2 = p2 + alpha * p4;
  };
  square(), square(), square(), square(), square(), square();
  return {c0, c1 * scale, c2 * scale * scale};
}

/// exp(L) for the trace-free part L of a tensor.
class TraceFreeExp {
 public:
  [[gnu::always_inline]] explicit TraceFreeExp(const SymTensor& tensor) : part_(tensor) {
    const double third = (tensor.xx + tensor.yy + tensor.zz) / 3;
    part_.xx -= third;
    part_.yy -= third;
    part_.zz -= third;
    const SymTensor& p = part_;
    square_ = {p.xx * p.xx + p.xy * p.xy + p.xz * p.xz, p.xx * p.xy + p.xy * p.yy + p.xz * p.yz,
               p.xx * p.xz + p.xy * p.yz + p.xz * p.zz, p.xy * p.xy + p.yy * p.yy + p.yz * p.yz,
               p.xy * p.xz + p.yy * p.yz + p.yz * p.zz, p.xz * p.xz + p.yz * p.yz + p.zz * p.zz};
    const double determinant = p.xx * (p.yy * p.zz - p.yz * p.yz) - p.xy * (p.xy * p.zz - p.yz * p.xz) +
                               p.xz * (p.xy * p.yz - p.yy * p.xz);
    polynomial_ = exp_of_trace_free(0.5 * (square_.xx + square_.yy + square_.zz), determinant);
  }

  /// trace(exp(L) S).
  [[nodiscard, gnu::always_inline]] double contraction_with(const SymTensor& s) const {
    const auto with = [&s](const SymTensor& a) {
      return a.xx * s.xx + a.yy * s.yy + a.zz * s.zz + 2 * (a.xy * s.xy + a.xz * s.xz + a.yz * s.yz);
    };
    return polynomial_.c0 * (s.xx + s.yy + s.zz) + polynomial_.c1 * with(part_) +
           polynomial_.c2 * with(square_);
  }
  [[nodiscard, gnu::always_inline]] SymTensor tensor() const {
    const auto& [c0, c1, c2] = polynomial_;
    return {c0 + c1 * part_.xx + c2 * square_.xx, c1 * part_.xy + c2 * square_.xy,
            c1 * part_.xz + c2 * square_.xz,      c0 + c1 * part_.yy + c2 * square_.yy,
            c1 * part_.yz + c2 * square_.yz,      c0 + c1 * part_.zz + c2 * square_.zz};
  }

 private:
  SymTensor part_, square_;
  ExpPolynomial polynomial_;
};

/// Mean of the logarithms of a tetrahedron's metrics.
[[nodiscard]] inline SymTensor mean_of_logs(const SymTensor& a, const SymTensor& b, const SymTensor& c,
                                            const SymTensor& d) {
  return 0.25 * (a + b + c + d);
}

/// Sum over the six edges e of e e^T, from the edges u, v, w at one vertex.
[[nodiscard, gnu::always_inline]] inline SymTensor sum_of_edge_squares(const Vec3& u, const Vec3& v,
                                                                       const Vec3& w) {
  const Vec3 s = u + v + w;
  const auto entry = [&](int i, int j) {
    return 4 * (u[i] * u[j] + v[i] * v[j] + w[i] * w[j]) - s[i] * s[j];
  };
  return {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)};
}

/// Six times the volume of the tetrahedron with the edges u, v, w at one vertex; by single numbers, which is
/// faster than cross().dot().
[[nodiscard]] inline double triple_product(const Vec3& u, const Vec3& v, const Vec3& w) {
  return (u[1] * v[2] - u[2] * v[1]) * w[0] + (u[2] * v[0] - u[0] * v[2]) * w[1] +
         (u[0] * v[1] - u[1] * v[0]) * w[2];
}

/// Cube of the mean ratio of (a, b, c, d), positively oriented, in the log-Euclidean mean of its vertices'
/// metrics, given by their logarithms; -1 for a flat or inverted tetrahedron. The cube spares a root where
/// qualities are only compared.
///
/// Mean ratio: 36 / 3^(1/3) (sqrt(det M) V)^(2/3) / sum of e^T M e; the determinant cancels against the trace
/// of log M. Sources: Liu and Joe 1994, doi:10.1007/BF01955874 (mean ratio); Alauzet 2010,
/// doi:10.1016/j.finel.2009.06.028 (in a metric, whose mean is section 2.3.2, eq. (3)); constant and trace:
/// docs/stages/adapt.md, "Lengths and shapes".
[[nodiscard]] inline double mean_ratio_cubed(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d,
                                             const SymTensor& log_a, const SymTensor& log_b,
                                             const SymTensor& log_c, const SymTensor& log_d) {
  const Vec3 u = b - a, v = c - a, w = d - a;
  const double six_volumes = triple_product(u, v, w);
  if (!(six_volumes > 0)) return -1;
  const TraceFreeExp metric(mean_of_logs(log_a, log_b, log_c, log_d));
  const double edges = metric.contraction_with(sum_of_edge_squares(u, v, w));
  // (36 / 3^(1/3))^3 V^2 / edges^3 with V = six_volumes / 6.
  return 432 * six_volumes * six_volumes / (edges * edges * edges);
}

[[nodiscard]] inline double cube(double x) {
  return x * x * x;
}

/// Cube root of a positive number; relative error below 1e-14. A quarter of std::cbrt's time.
[[nodiscard]] inline double cube_root(double x) {
  // A third of the exponent, then Halley's iteration, which triples the digits.
  double y = std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) / 3 + 0x2A9F7893782DA1CEull);
  for (int i = 0; i < 2; ++i) {
    const double cube = y * y * y;
    y *= (cube + 2 * x) / (2 * cube + x);
  }
  return y;
}

/// The mean ratio itself; negative for a flat or inverted tetrahedron.
[[nodiscard]] inline double mean_ratio(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d,
                                       const SymTensor& log_a, const SymTensor& log_b, const SymTensor& log_c,
                                       const SymTensor& log_d) {
  const double cubed = mean_ratio_cubed(a, b, c, d, log_a, log_b, log_c, log_d);
  return cubed > 0 ? cube_root(cubed) : cubed;
}

}  // namespace lumesh::metric
