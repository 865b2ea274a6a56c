#pragma once
// The linear solves of a fit.

#include "fit_state.hpp"

namespace lumesh::field {

/// Preconditioned conjugate gradients on the energy with the present weights, from the present function.
class ConjugateGradients {
 public:
  explicit ConjugateGradients(const FitState& state);
  /// To be called when the stiffness has changed.
  void take_stiffness(const FitState& state);

  /// Iterates until the energy norm of the estimated error per face is below the tolerance, or
  /// kMaxIterations times.
  void minimise(double tolerance, FitState& state);
  static constexpr int kMaxIterations = 80;

 private:
  void set_diagonals(FitState& state);
  double start(FitState& state);

  LaneArray residual_, direction_, product_, inverse_diagonal_;
  LaneArray difference_diagonal_;
};

}  // namespace lumesh::field
