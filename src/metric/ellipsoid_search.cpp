#include "ellipsoid_search.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <utility>

#include "lumesh/core/assert.hpp"
#include "lumesh/metric/tensor.hpp"

namespace lumesh::metric {

/// {x : (x - centre)^T spread^-1 (x - centre) <= 1}.
template <int D>
struct EllipsoidSearch::Shape {
  Eigen::Matrix<double, D, 1> centre;
  Eigen::Matrix<double, D, D> spread;
};

/// The search for weights u of the points that make the determinant of X = sum u q q^T, q = (x, 1), as large
/// as it can be: its dual is the smallest ellipsoid. With kappa_i = q_i^T X^-1 q_i all kappa <= d + 1 at the
/// end.
template <int D>
class EllipsoidSearch::Ascent {
 public:
  using Point = Eigen::Matrix<double, D, 1>;
  using Lifted = Eigen::Matrix<double, D + 1, 1>;
  static constexpr double kLevel = D + 1;

  /// Coordinates of about 1 in size, along `kept`.
  Ascent(EllipsoidSearch& search, const std::array<int, 3>& kept)
      : count_(search.count_),
        weights_(search.weights_),
        kappa_(search.distances_),
        products_(search.products_) {
    for (int i = 0; i < D; ++i) along_[i] = search.along_[kept[i]].data();
  }

  Shape<D> run(double tolerance) {
    constexpr int kMaxSteps = 20000, kStepsBetweenRestarts = 64;
    weigh_extreme_points();
    for (int step = 0; step < kMaxSteps; ++step) {
      // Updates of the inverse drift.
      if (step % kStepsBetweenRestarts == 0) invert();
      const auto [nearest, farthest] = extremes();
      const double excess = kappa_[farthest] / kLevel - 1, lack = 1 - kappa_[nearest] / kLevel;
      if (excess <= tolerance) break;
      if (excess >= lack)
        move_weight(farthest, best_step(kappa_[farthest]));
      else
        move_away(nearest);
    }
    return shape();
  }

 private:
  [[nodiscard]] Lifted lifted(std::size_t i) const {
    Lifted q;
    for (int axis = 0; axis < D; ++axis) q[axis] = along_[axis][i];
    q[D] = 1;
    return q;
  }

  /// The ends of the set along directions that are orthogonal to what the ends before span.
  void weigh_extreme_points() {
    weights_.assign(count_, 0.0);
    kappa_.resize(count_);
    products_.resize(count_);
    Eigen::Matrix<double, D, D> free = Eigen::Matrix<double, D, D>::Identity();  // Projects off that span.
    for (int k = 0; k < D; ++k) {
      Eigen::Index column = 0;
      free.diagonal().maxCoeff(&column);
      const Point direction = free.col(column);
      std::size_t low = 0, high = 0;
      for (std::size_t i = 0; i < count_; ++i) {
        products_[i] = direction.dot(lifted(i).template head<D>());
        if (products_[i] < products_[low]) low = i;
        if (products_[i] > products_[high]) high = i;
      }
      weights_[low] += 0.5 / D;
      weights_[high] += 0.5 / D;
      const Point spanned = free * (lifted(high) - lifted(low)).template head<D>();
      free -= spanned * spanned.transpose() / spanned.squaredNorm();
    }
  }

  void invert() {
    Eigen::Matrix<double, D + 1, D + 1> sum = Eigen::Matrix<double, D + 1, D + 1>::Zero();
    for (std::size_t i = 0; i < count_; ++i)
      if (weights_[i] > 0) sum += weights_[i] * lifted(i) * lifted(i).transpose();
    inverse_ = sum.inverse();
    for (std::size_t i = 0; i < count_; ++i) kappa_[i] = lifted(i).dot(inverse_ * lifted(i));
  }

  /// The point deepest inside of those that have weight, and the one farthest out of all.
  [[nodiscard]] std::pair<std::size_t, std::size_t> extremes() const {
    std::size_t low = count_, high = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (kappa_[i] > kappa_[high]) high = i;
      if (weights_[i] > 0 && (low == count_ || kappa_[i] < kappa_[low])) low = i;
    }
    return {low, high};
  }

  /// Raises the determinant most. Todd and Yildirim 2007.
  [[nodiscard]] static double best_step(double kappa) { return (kappa - kLevel) / (kLevel * (kappa - 1)); }

  /// A step of negative length, at most so long that the point loses its weight.
  void move_away(std::size_t i) {
    const double longest = -weights_[i] / (1 - weights_[i]);
    constexpr double kAtCentre = 1 + 1e-12;  // kappa is 1 at the centre, where no step would be too long.
    const double wanted = kappa_[i] > kAtCentre ? best_step(kappa_[i]) : longest;
    move_weight(i, std::max(wanted, longest));
    if (wanted <= longest) weights_[i] = 0;
  }

  /// u <- (1 - step) u + step e_i; X^-1 by Sherman and Morrison.
  void move_weight(std::size_t i, double step) {
    const Lifted w = inverse_ * lifted(i);
    const double share = step / (1 - step + step * kappa_[i]), growth = 1 / (1 - step);
    for (std::size_t j = 0; j < count_; ++j) {
      double product = w[D];
      for (int axis = 0; axis < D; ++axis) product += w[axis] * along_[axis][j];
      kappa_[j] = growth * (kappa_[j] - share * product * product);
      weights_[j] *= 1 - step;
    }
    weights_[i] += step;
    inverse_ = growth * (inverse_ - share * w * w.transpose());
  }

  /// Grown until it holds the point farthest out.
  [[nodiscard]] Shape<D> shape() const {
    Shape<D> result{Point::Zero(), Eigen::Matrix<double, D, D>::Zero()};
    double sum = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      result.centre += weights_[i] * lifted(i).template head<D>();
      sum += weights_[i];
    }
    result.centre /= sum;
    for (std::size_t i = 0; i < count_; ++i) {
      const Point offset = lifted(i).template head<D>() - result.centre;
      result.spread += weights_[i] / sum * offset * offset.transpose();
    }
    const Eigen::Matrix<double, D, D> inverse = result.spread.inverse();
    double farthest = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const Point offset = lifted(i).template head<D>() - result.centre;
      farthest = std::max(farthest, offset.dot(inverse * offset));
    }
    result.spread *= farthest;
    return result;
  }

  std::size_t count_;
  std::array<const double*, D> along_{};
  std::vector<double>&weights_, &kappa_, &products_;
  Eigen::Matrix<double, D + 1, D + 1> inverse_;
};

void EllipsoidSearch::turn_to_principal_axes(std::span<const Vec3> points) {
  count_ = points.size();
  mean_.setZero();
  for (const Vec3& p : points) mean_ += p;
  mean_ /= static_cast<double>(count_);
  Mat3 covariance = Mat3::Zero();
  for (const Vec3& p : points) covariance += (p - mean_) * (p - mean_).transpose();
  axes_ = eigen_system(SymTensor::from(covariance)).axes;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double>& along = along_[axis];
    along.resize(count_);
    for (std::size_t i = 0; i < count_; ++i) along[i] = axes_.col(axis).dot(points[i] - mean_);
    const auto [low, high] = std::ranges::minmax_element(along);
    middle_[axis] = 0.5 * (*low + *high);
    half_range_[axis] = 0.5 * (*high - *low);
  }
}

template <int D>
void EllipsoidSearch::fill_across(const std::array<int, 3>& kept, Ellipsoid& ellipsoid) {
  Shape<D> shape{Eigen::Matrix<double, D, 1>::Zero(), Eigen::Matrix<double, D, D>::Identity()};
  if constexpr (D > 1) {
    for (int i = 0; i < D; ++i)
      for (double& x : along_[kept[i]]) x = (x - middle_[kept[i]]) / half_range_[kept[i]];
    shape = Ascent<D>(*this, kept).run(options_.tolerance);
  }
  Mat3 spread = Vec3::Constant(options_.floor_mm * options_.floor_mm).asDiagonal();
  Vec3 centre = middle_;
  for (int i = 0; i < D; ++i) {
    const int axis = kept[i];
    centre[axis] += half_range_[axis] * shape.centre[i];
    for (int j = 0; j < D; ++j)
      spread(axis, kept[j]) = half_range_[axis] * half_range_[kept[j]] * shape.spread(i, j);
  }
  const EigenSystem system = eigen_system(SymTensor::from(spread));
  ellipsoid.centre = mean_ + axes_ * centre;
  ellipsoid.axes = axes_ * system.axes;
  ellipsoid.semi_axes = system.values.cwiseMax(0).cwiseSqrt().cwiseMax(options_.floor_mm);
}

Ellipsoid EllipsoidSearch::around(std::span<const Vec3> points) {
  turn_to_principal_axes(points);
  // Below a share of the largest, squares would drown in the rounding of the largest one's.
  constexpr double kMinShare = 1e-7;
  const double smallest = std::max(options_.floor_mm, kMinShare * half_range_.maxCoeff());
  std::array<int, 3> kept{};
  std::size_t dimension = 0;
  for (int axis = 2; axis >= 0; --axis)
    if (half_range_[axis] > smallest) kept[dimension++] = axis;
  Ellipsoid ellipsoid;
  if (dimension == 3)
    fill_across<3>(kept, ellipsoid);
  else if (dimension == 2)
    fill_across<2>(kept, ellipsoid);
  else if (dimension == 1)
    fill_across<1>(kept, ellipsoid);
  else
    ellipsoid = {mean_ + axes_ * middle_, Mat3::Identity(), Vec3::Constant(options_.floor_mm)};
  return ellipsoid;
}

SymTensor Ellipsoid::metric() const {
  LUMESH_ASSERT(semi_axes.minCoeff() > 0);
  return from_sizes(axes, semi_axes);
}

}  // namespace lumesh::metric
