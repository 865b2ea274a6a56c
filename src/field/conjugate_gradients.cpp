#include "conjugate_gradients.hpp"

#include <algorithm>

#include "lumesh/core/wide.hpp"
#include "segment_loops.hpp"
#include "stencil.hpp"

namespace lumesh::field {

namespace {

// Of the finest level's part of the preconditioner, Q (1 + kCoupling N) Q with Q^2 = kFinest / diagonal,
// where N adds up the six voxels beside one: the differences cost functions that change from voxel to voxel
// up to 200 times as much as those that the next level has, which the diagonal alone cannot tell. Below 1/6
// it is positive definite. With the diagonal alone solves take twice the iterations; both numbers are those
// that leave fewest on the carotid phantom and on balls.
constexpr float kFinest = 3, kCoupling = 0.15F;

/// root: Q, from the estimated diagonal. `mass` holds the weights of single voxels, without the holds at
/// first.
LUMESH_WIDE_LOOPS void diagonal_block(const Band& band, const LaneArray& difference_diagonal,
                                      const LaneArray& face_diagonal, const LaneArray& hold, int begin,
                                      int end, LaneArray& mass, LaneArray& root) {
  for (int s = begin; s < end; ++s) {
    const Lanes h = load(hold.at(s));
    add_to(mass.at(s), h);
    const Lanes whole = load(difference_diagonal.at(s)) + load(face_diagonal.at(s)) + h;
    store(root.at(s), keep(square_root(kFinest / whole), mask_of(band.alive(s))));
  }
}

/// What the faces add to the diagonal, and to the mass of the coarse levels' splines. What their slopes' rows
/// give the voxels beside the two of a face, these two get.
void add_faces(const Band& band, const FaceWeights& faces, LaneArray& mass, LaneArray& diagonal) {
  for (int s = 1; s < band.end(); ++s) {
    int entry = band.first_entry(s);
    for (int axis = 0; axis < 3; ++axis) {
      if (band.faces(s, axis) == 0) continue;
      const auto part = [&](FaceWeights::Part p) { return load(faces.at(entry, p)); };
      const Lanes place = part(FaceWeights::kPlace), own = part(FaceWeights::kOwn),
                  first = part(FaceWeights::kFirst), second = part(FaceWeights::kSecond);
      const Lanes half = 0.5F * place;
      const Lanes both =
          (kFaceInner * kFaceInner) * place + own * own + 2.0F * (first * first + second * second);
      const auto across = [&](LaneArray& a) {
        return axis == 0 ? a.at(s) + 1 : a.at(band.rows(s)[axis == 1 ? kY1 : kZ1]);
      };
      add_to(mass.at(s), half), add_to(across(mass), half);
      add_to(diagonal.at(s), both), add_to(across(diagonal), both);
      ++entry;
    }
  }
}

/// out += sign * gradient of the holds.
LUMESH_WIDE_LOOPS void add_holds_block(const LaneArray& values, const LaneArray& hold,
                                       const LaneArray& target, float sign, int begin, int end,
                                       LaneArray& out) {
  for (int s = begin; s < end; ++s)
    add_to(out.at(s), keep_numbers(sign * load(hold.at(s)) * (load(values.at(s)) - load(target.at(s)))));
}

LUMESH_WIDE_LOOPS void negate_block(const LaneArray& product, int begin, int end, LaneArray& residual) {
  for (int s = begin; s < end; ++s) store(residual.at(s), -load(product.at(s)));
}

/// smoothed = (1 + kCoupling N) Q residual; returns the finest level's part of residual . M residual.
LUMESH_WIDE_LOOPS double smooth_block(const Band& band, const LaneArray& residual, const LaneArray& root,
                                      int begin, int end, LaneArray& smoothed) {
  Lanes total = {};
  for (int s = begin; s < end; ++s) {
    const auto& rows = band.rows(s);
    const auto at = [&](std::ptrdiff_t lane) __attribute__((always_inline)) {
      return load(residual.data() + lane) * load(root.data() + lane);
    };
    const std::ptrdiff_t lane = std::ptrdiff_t{s} * kLanes;
    const auto row = [&](Row r) __attribute__((always_inline)) {
      return at(std::ptrdiff_t{rows[r]} * kLanes);
    };
    const Lanes own = at(lane);
    const Lanes around = (at(lane - 1) + at(lane + 1)) + ((row(kY1) + row(kYm)) + (row(kZ1) + row(kZm)));
    const Lanes mixed = own + kCoupling * around;
    store(smoothed.at(s), mixed);
    total += own * mixed;
  }
  return static_cast<double>(sum(total));
}

/// direction = M residual + beta direction; product = hold * direction, its part of A direction, instead of
/// what smooth_block() has left there.
LUMESH_WIDE_LOOPS void direction_block(const Transfer& finest, const LaneArray& root, const LaneArray& hold,
                                       float beta, int begin, int end, LaneArray& direction,
                                       LaneArray& product) {
  for (int s = begin; s < end; ++s) {
    const Lanes z = load(root.at(s)) * load(product.at(s)) + finest.load_fine(s);
    const Lanes d = z + beta * load(direction.at(s));
    store(direction.at(s), d);
    store(product.at(s), keep_numbers(load(hold.at(s)) * d));
  }
}

LUMESH_WIDE_LOOPS double dot_block(const LaneArray& direction, const LaneArray& product, int begin, int end) {
  Lanes total = {};
  for (int s = begin; s < end; ++s) total += keep_numbers(load(direction.at(s)) * load(product.at(s)));
  return static_cast<double>(sum(total));
}

/// values += step * direction, residual -= step * product.
LUMESH_WIDE_LOOPS void advance_block(float step, const LaneArray& direction, const LaneArray& product,
                                     int begin, int end, LaneArray& values, LaneArray& residual) {
  for (int s = begin; s < end; ++s) {
    store(values.at(s), load(values.at(s)) + step * load(direction.at(s)));
    store(residual.at(s), load(residual.at(s)) - step * load(product.at(s)));
  }
}

void add_saddles(const FitState& state, const LaneArray& x, float offset, float sign, LaneArray& y) {
  for (std::size_t i = 0; i < state.saddle_hold.size(); ++i) {
    const float weight = sign * state.saddle_hold[i];
    if (weight == 0) continue;
    const auto& voxels = state.band.saddles()[i].voxel;
    float mean = offset;
    for (const Lane v : voxels) mean += 0.25F * x.data()[v];
    for (const Lane v : voxels) y.data()[v] += 0.25F * weight * mean;
  }
}

}  // namespace

ConjugateGradients::ConjugateGradients(const FitState& state)
    : direction_(state.values), root_(state.band.end()), difference_diagonal_(state.band.end()) {
  take_stiffness(state);
}

void ConjugateGradients::take_stiffness(const FitState& state) {
  for_each_segment_block(state.band.end(), [&](int begin, int end) {
    std::fill(difference_diagonal_.at(begin), difference_diagonal_.at(end), 0.0F);
  });
  add_difference_diagonal(state.energy, state.values, difference_diagonal_);
}

void ConjugateGradients::set_diagonals(FitState& state) {
  const Band& band = state.band;
  LaneArray &mass = state.residual, &diagonal = state.product;
  for_each_segment_block(band.end(), [&](int begin, int end) {
    std::fill(mass.at(begin), mass.at(end), 0.0F);
    std::fill(diagonal.at(begin), diagonal.at(end), 0.0F);
  });
  add_faces(band, state.energy.faces, mass, diagonal);
  for (std::size_t i = 0; i < state.saddle_hold.size(); ++i)
    for (const Lane v : band.saddles()[i].voxel) diagonal.data()[v] += state.saddle_hold[i] / 16;
  for_each_segment_block(band.end(), [&](int begin, int end) {
    diagonal_block(band, difference_diagonal_, diagonal, state.hold, begin, end, mass, root_);
  });
  state.levels.set_energy(difference_diagonal_, whole_diagonal(state.energy.differences), mass, kThird,
                          kSecond, band.edges());
}

void ConjugateGradients::start(FitState& state) {
  const Band& band = state.band;
  for_each_segment_block(band.end(), [&](int begin, int end) {
    std::fill(state.product.at(begin), state.product.at(end), 0.0F);
  });
  apply_residual(state.energy, state.values, state.product);
  for_each_segment_block(
      band.end(), [&](int begin, int end) { negate_block(state.product, begin, end, state.residual); });
  add_gradient_of_holds(-1, state);
}

void ConjugateGradients::add_gradient_of_holds(float sign, FitState& state) {
  for_each_segment_block(state.band.end(), [&](int begin, int end) {
    add_holds_block(state.values, state.hold, state.target, sign, begin, end, state.residual);
  });
  add_saddles(state, state.values, kThinDepth, sign, state.residual);
}

/// Leaves the parts of M residual in the product and the levels; returns residual . M residual.
double ConjugateGradients::precondition(FitState& state) {
  const Band& band = state.band;
  const double finest = sum_over_segment_blocks(band.end(), [&](int begin, int end) {
    return smooth_block(band, state.residual, root_, begin, end, state.product);
  });
  return finest + state.levels.precondition(state.residual);
}

void ConjugateGradients::minimise(double tolerance, FitState& state) {
  set_diagonals(state);
  start(state);
  minimise_on(tolerance, state);
}

void ConjugateGradients::minimise_on(double tolerance, FitState& state) {
  const Band& band = state.band;
  double error = precondition(state);
  const double enough =
      tolerance * tolerance * static_cast<double>(std::max<std::size_t>(1, band.face_count()));
  float beta = 0;
  for (int count = 0; count < kMaxIterations && error > enough; ++count) {
    for_each_segment_block(band.end(), [&](int begin, int end) {
      direction_block(state.levels.finest(), root_, state.hold, beta, begin, end, direction_, state.product);
    });
    apply(state.energy, direction_, state.product);
    add_saddles(state, direction_, 0, 1, state.product);
    const double curvature = sum_over_segment_blocks(
        band.end(), [&](int begin, int end) { return dot_block(direction_, state.product, begin, end); });
    if (!(curvature > 0)) break;
    const auto step = static_cast<float>(error / curvature);
    for_each_segment_block(band.end(), [&](int begin, int end) {
      advance_block(step, direction_, state.product, begin, end, state.values, state.residual);
    });
    const double next = precondition(state);
    beta = static_cast<float>(next / error);
    error = next;
  }
}

}  // namespace lumesh::field
