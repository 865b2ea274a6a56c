#pragma once
/// @file Algebra of metric tensors: symmetric positive definite, in 1/mm^2; a vector v has metric length
/// sqrt(v^T M v), so that a size h along a direction is the eigenvalue 1/h^2.
///
/// Means are taken of the matrix logarithms (log-Euclidean): sizes average geometrically and directions
/// turn, where a mean of the tensors themselves would shrink. Sources: Arsigny et al. 2006,
/// doi:10.1002/mrm.20965; Alauzet 2010, doi:10.1016/j.finel.2009.06.028, section 2.3.2, eq. (3).

#include "lumesh/core/types.hpp"

namespace lumesh::metric {

/// T = axes * diag(values) * axes^T with orthonormal columns; ascending values.
struct EigenSystem {
  Vec3 values;
  Mat3 axes;

  [[nodiscard]] SymTensor tensor() const {
    return SymTensor::from(axes * values.asDiagonal() * axes.transpose());
  }
};
[[nodiscard]] EigenSystem eigen_system(const SymTensor& tensor);

/// The metric with the given sizes in mm (> 0) along the columns of `axes` (orthonormal).
[[nodiscard]] SymTensor from_sizes(const Mat3& axes, const Vec3& sizes_mm);

/// Matrix logarithm of a metric, and the exponential, its inverse.
[[nodiscard]] SymTensor log(const SymTensor& metric);
[[nodiscard]] SymTensor exp(const SymTensor& log_metric);

/// The largest ellipsoid's metric that asks for no larger sizes than `a` and `b` do anywhere: >= both in the
/// Loewner order. By simultaneous diagonalisation of a^-1/2 b a^-1/2, which is symmetric and so stays
/// accurate at high anisotropy. Source: the simultaneous reduction of Alauzet 2010,
/// doi:10.1016/j.finel.2009.06.028; the symmetric form is derived in docs/stages/metric.md, "Intersection".
[[nodiscard]] SymTensor intersection(const SymTensor& a, const SymTensor& b);

}  // namespace lumesh::metric
