#include "lumesh/metric/tensor.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace lumesh::metric {
namespace {

template <class Function>
SymTensor on_eigenvalues(const SymTensor& tensor, const Function& function) {
  EigenSystem system = eigen_system(tensor);
  for (double& value : system.values) value = function(value);
  return system.tensor();
}

}  // namespace

EigenSystem eigen_system(const SymTensor& tensor) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(tensor.matrix());
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymTensor from_sizes(const Mat3& axes, const Vec3& sizes_mm) {
  const Vec3 values = sizes_mm.cwiseProduct(sizes_mm).cwiseInverse();
  return SymTensor::from(axes * values.asDiagonal() * axes.transpose());
}

SymTensor log(const SymTensor& metric) {
  return on_eigenvalues(metric, [](double value) { return std::log(value); });
}

SymTensor exp(const SymTensor& log_metric) {
  return on_eigenvalues(log_metric, [](double value) { return std::exp(value); });
}

SymTensor intersection(const SymTensor& a, const SymTensor& b) {
  const EigenSystem system = eigen_system(a);
  const Vec3 roots = system.values.cwiseSqrt();
  const Mat3 half = system.axes * roots.asDiagonal() * system.axes.transpose();
  const Mat3 inverse_half = system.axes * roots.cwiseInverse().asDiagonal() * system.axes.transpose();
  // In the frame where a is the identity: the larger of each eigenvalue and 1.
  EigenSystem relative = eigen_system(SymTensor::from(inverse_half * b.matrix() * inverse_half));
  relative.values = relative.values.cwiseMax(1);
  return SymTensor::from(half * relative.tensor().matrix() * half);
}

}  // namespace lumesh::metric
