#include "angle_star.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "lumesh/operators/shape_measure.hpp"

namespace lumesh::operators {
namespace {

/// The shortest vector w in the convex hull of some: again and again the shortest one between w and the v
/// with the least v . w, until no v . w is below |w|^2. Source: Gilbert 1966, doi:10.1137/0304007.
Vec3 shortest_combination(const std::vector<Vec3>& vectors) {
  constexpr int kMaxRounds = 60;
  constexpr double kNearly = 1e-3;
  Vec3 shortest = vectors.front();
  for (int round = 0; round < kMaxRounds; ++round) {
    const Vec3* lowest = &vectors.front();
    for (const Vec3& v : vectors)
      if (v.dot(shortest) < lowest->dot(shortest)) lowest = &v;
    const Vec3 towards = *lowest - shortest;
    const double slope = -towards.dot(shortest);
    if (slope <= kNearly * shortest.squaredNorm()) break;
    shortest += std::min(1.0, slope / towards.squaredNorm()) * towards;
  }
  return shortest;
}

}  // namespace

double AngleStar::worst_at(const Vec3& x) const {
  double worst = 1;
  for (const auto& [a, b, c] : bases_) worst = std::min(worst, angle_quality(a, b, c, x, obtuse_weight_));
  return worst;
}

void AngleStar::differentiate(const Vec3& x) {
  terms_.clear();
  for (const auto& [a, b, c] : bases_) {
    const std::array<Vec3, 4> corners = {a, b, c, x};
    const auto normals = detail::tetrahedron_face_normals(a, b, c, x);
    const Vec3 base_normal = (b - a).cross(c - a);
    const double six_volumes = base_normal.dot(x - a);
    // Gradients of logarithms. A face over the edge from p to q has the normal (p - x) x (q - x).
    const Vec3 of_volume = base_normal / six_volumes;
    std::array<double, 4> areas{};
    std::array<Vec3, 4> of_area;
    for (int f = 0; f < 4; ++f) areas[f] = normals[f].norm();
    for (int f = 0; f < 3; ++f) {
      const Vec3 edge = corners[(f + 2) % 3] - corners[(f + 1) % 3];
      of_area[f] = normals[f].cross(edge) / (areas[f] * areas[f]);
    }
    of_area[3] = Vec3::Zero();
    for (int e = 0; e < 6; ++e) {
      const auto [i, j] = kTetEdges[e];
      const auto [k, l] = kTetEdges[5 - e];  // The faces at edge e are those opposite k and l.
      const Vec3 edge = corners[j] - corners[i];
      const double weight = normals[k].dot(normals[l]) > 0 ? obtuse_weight_ : 1;
      const double value = weight * six_volumes * edge.norm() / (areas[k] * areas[l]);
      Vec3 gradient = of_volume - of_area[k] - of_area[l];
      if (j == 3) gradient += edge / edge.squaredNorm();
      gradient -= normal_.dot(gradient) * normal_;
      terms_.push_back({value, value * gradient});
    }
  }
}

Vec3 AngleStar::ascent_direction(double worst) {
  constexpr double kAsBad = 1.01;
  // Of flat tetrahedra rounding may leave all terms above the worst quality; then the lowest of them count.
  double smallest = std::numeric_limits<double>::infinity();
  for (const Term& term : terms_) smallest = std::min(smallest, term.value);
  const double limit = kAsBad * std::max(worst, smallest);
  active_.clear();
  for (const Term& term : terms_)
    if (term.value <= limit) active_.push_back(term.gradient);
  return active_.empty() ? Vec3(Vec3::Zero()) : shortest_combination(active_);
}

/// As far as the terms that are the worst now will stay so, were all of them linear.
double AngleStar::first_step(const Vec3& direction, double worst) const {
  constexpr double kMaxGain = 0.5;
  const double rise = direction.squaredNorm();
  double step = kMaxGain / rise;
  for (const Term& term : terms_) {
    const double slope = rise - term.gradient.dot(direction);
    if (slope > 1e-3 * rise && term.value > 1.01 * worst) step = std::min(step, (term.value - worst) / slope);
  }
  return step;
}

double AngleStar::climb(Vec3& x, int max_steps) {
  constexpr int kHalvings = 5;
  constexpr double kMinGain = 1e-4;
  double worst = worst_at(x);
  for (int round = 0; round < max_steps && worst > 0; ++round) {
    differentiate(x);
    const Vec3 direction = ascent_direction(worst);
    if (!(direction.squaredNorm() > 0)) break;
    double step = first_step(direction, worst), best = worst;
    Vec3 best_place = x;
    for (int i = 0; i < kHalvings; ++i, step *= 0.5) {
      const Vec3 place = x + step * direction;
      const double found = worst_at(place);
      if (found <= best && best > worst) break;  // It was better farther out.
      if (found > best) best = found, best_place = place;
    }
    if (best < worst + kMinGain) break;
    x = best_place;
    worst = best;
  }
  return worst;
}

}  // namespace lumesh::operators
