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

  /// Lets `change` alter the holds and their targets, and nothing else, between minimise() and minimise_on().
  template <class Change>
  void change_holds(FitState& state, const Change& change) {
    add_gradient_of_holds(1, state);
    change();
    add_gradient_of_holds(-1, state);
  }
  /// Goes on with the preconditioner of the last minimise(), which suits where few voxels' holds have
  /// changed.
  void minimise_on(double tolerance, FitState& state);

 private:
  void set_diagonals(FitState& state);
  /// Computes the residual.
  void start(FitState& state);
  /// Adds `sign` times what holds pull with to the residual.
  void add_gradient_of_holds(float sign, FitState& state);
  double precondition(FitState& state);

  LaneArray direction_;
  LaneArray root_;  // Factor of the finest level's preconditioner.
  LaneArray difference_diagonal_;
};

}  // namespace lumesh::field
