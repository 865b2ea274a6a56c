#include "conjugate_gradients.hpp"

#include <algorithm>

#include "lumesh/core/wide.hpp"
#include "segment_loops.hpp"
#include "stencil.hpp"

namespace lumesh::field {

namespace {

/// inverse: of the estimated diagonal. `mass` holds the weights of single voxels, without the holds at first.
LUMESH_WIDE_LOOPS void diagonal_block(const Band& band, const LaneArray& difference_diagonal,
                                      const LaneArray& face_diagonal, const LaneArray& hold, int begin,
                                      int end, LaneArray& mass, LaneArray& inverse) {
  for (int s = begin; s < end; ++s) {
    const Lanes h = load(hold.at(s));
    add_to(mass.at(s), h);
    const Lanes whole = load(difference_diagonal.at(s)) + load(face_diagonal.at(s)) + h;
    store(inverse.at(s), keep(1.0F / whole, mask_of(band.alive(s))));
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

LUMESH_WIDE_LOOPS void residual_of_holds(const LaneArray& values, const LaneArray& hold,
                                         const LaneArray& target, int begin, int end, LaneArray& out) {
  for (int s = begin; s < end; ++s)
    store(out.at(s), keep_numbers(load(hold.at(s)) * (load(values.at(s)) - load(target.at(s)))));
}

/// residual = -product; returns the sum of residual^2 / diagonal.
LUMESH_WIDE_LOOPS double negate_block(const LaneArray& product, const LaneArray& inverse, int begin, int end,
                                      LaneArray& residual) {
  Lanes total = {};
  for (int s = begin; s < end; ++s) {
    const Lanes r = -load(product.at(s));
    store(residual.at(s), r);
    total += r * r * load(inverse.at(s));
  }
  return static_cast<double>(sum(total));
}

/// direction = M residual + beta direction; product = hold * direction, its part of A direction.
LUMESH_WIDE_LOOPS void direction_block(const Transfer& finest, const LaneArray& residual,
                                       const LaneArray& inverse, const LaneArray& hold, float beta, int begin,
                                       int end, LaneArray& direction, LaneArray& product) {
  for (int s = begin; s < end; ++s) {
    const Lanes z = load(residual.at(s)) * load(inverse.at(s)) + finest.load_fine(s);
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

/// values += step * direction, residual -= step * product; returns the sum of residual^2 / diagonal.
LUMESH_WIDE_LOOPS double advance_block(float step, const LaneArray& direction, const LaneArray& product,
                                       const LaneArray& inverse, int begin, int end, LaneArray& values,
                                       LaneArray& residual) {
  Lanes total = {};
  for (int s = begin; s < end; ++s) {
    store(values.at(s), load(values.at(s)) + step * load(direction.at(s)));
    const Lanes r = load(residual.at(s)) - step * load(product.at(s));
    store(residual.at(s), r);
    total += r * r * load(inverse.at(s));
  }
  return static_cast<double>(sum(total));
}

void add_saddles(const FitState& state, const LaneArray& x, float offset, LaneArray& y) {
  for (std::size_t i = 0; i < state.saddle_hold.size(); ++i) {
    const float weight = state.saddle_hold[i];
    if (!(weight > 0)) continue;
    const auto& voxels = state.band.saddles()[i].voxel;
    float mean = offset;
    for (const Lane v : voxels) mean += 0.25F * x.data()[v];
    for (const Lane v : voxels) y.data()[v] += 0.25F * weight * mean;
  }
}

}  // namespace

ConjugateGradients::ConjugateGradients(const FitState& state)
    : residual_(state.band.end()),
      direction_(state.values),
      product_(state.band.end()),
      inverse_diagonal_(state.band.end()),
      difference_diagonal_(state.band.end()) {
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
  LaneArray &mass = residual_, &diagonal = product_;
  for_each_segment_block(band.end(), [&](int begin, int end) {
    std::fill(mass.at(begin), mass.at(end), 0.0F);
    std::fill(diagonal.at(begin), diagonal.at(end), 0.0F);
  });
  add_faces(band, state.energy.faces, mass, diagonal);
  for (std::size_t i = 0; i < state.saddle_hold.size(); ++i)
    for (const Lane v : band.saddles()[i].voxel) diagonal.data()[v] += state.saddle_hold[i] / 16;
  for_each_segment_block(band.end(), [&](int begin, int end) {
    diagonal_block(band, difference_diagonal_, diagonal, state.hold, begin, end, mass, inverse_diagonal_);
  });
  state.levels.set_energy(state.energy.stiffness, mass, kThird, kSecond, band.edges());
}

/// The residual; returns residual^2 / diagonal, summed.
double ConjugateGradients::start(FitState& state) {
  const Band& band = state.band;
  for_each_segment_block(band.end(), [&](int begin, int end) {
    residual_of_holds(state.values, state.hold, state.target, begin, end, product_);
  });
  apply_residual(state.energy, state.values, product_);
  add_saddles(state, state.values, kThinDepth, product_);
  return sum_over_segment_blocks(band.end(), [&](int begin, int end) {
    return negate_block(product_, inverse_diagonal_, begin, end, residual_);
  });
}

void ConjugateGradients::minimise(double tolerance, FitState& state) {
  const Band& band = state.band;
  set_diagonals(state);
  double error = start(state);
  error += state.levels.precondition(residual_);
  const double enough =
      tolerance * tolerance * static_cast<double>(std::max<std::size_t>(1, band.face_count()));
  float beta = 0;
  for (int count = 0; count < kMaxIterations && error > enough; ++count) {
    for_each_segment_block(band.end(), [&](int begin, int end) {
      direction_block(state.levels.finest(), residual_, inverse_diagonal_, state.hold, beta, begin, end,
                      direction_, product_);
    });
    apply(state.energy, direction_, product_);
    add_saddles(state, direction_, 0, product_);
    const double curvature = sum_over_segment_blocks(
        band.end(), [&](int begin, int end) { return dot_block(direction_, product_, begin, end); });
    if (!(curvature > 0)) break;
    const auto step = static_cast<float>(error / curvature);
    double next = sum_over_segment_blocks(band.end(), [&](int begin, int end) {
      return advance_block(step, direction_, product_, inverse_diagonal_, begin, end, state.values,
                           residual_);
    });
    next += state.levels.precondition(residual_);
    beta = static_cast<float>(next / error);
    error = next;
  }
}

}  // namespace lumesh::field
