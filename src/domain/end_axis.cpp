#include "end_axis.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "lumesh/core/squares.hpp"

namespace lumesh {
namespace {

struct SectionFound {
  Vec3 centre_mm = Vec3::Zero();
  double area_mm2 = 0;
  bool is_whole = true;  // Not cut off by the window.
};

/// Squares around a place of a plane.
class SectionWindow {
 public:
  SectionWindow(const Domain& domain, const Vec3& middle_mm, const Vec3& normal, double half_mm)
      : middle_(middle_mm), u_(normal.unitOrthogonal()), v_(normal.cross(u_)), step_(half_mm / kHalf) {
    is_object_.assign(std::size_t{kSide} * kSide, 0);
    for (std::size_t s = 0; s < is_object_.size(); ++s)
      is_object_[s] = domain.is_meshed(domain.material_at(place(s))) ? 1 : 0;
  }

  /// The connected part at the middle, or the nearest one, with what it surrounds: squares tell the centre of
  /// a thin ring, the section of a hollow wall, several times less well than that of its outline.
  [[nodiscard]] std::optional<SectionFound> find() {
    std::size_t best = is_object_.size();
    int least = std::numeric_limits<int>::max();
    for (std::size_t s = 0; s < is_object_.size(); ++s) {
      const int off = (column(s) - kHalf) * (column(s) - kHalf) + (row(s) - kHalf) * (row(s) - kHalf);
      if (is_object_[s] != 0 && off < least) least = off, best = s;
    }
    if (best == is_object_.size()) return std::nullopt;
    SectionFound found;
    std::vector<Square> squares(is_object_.size(), Square::kSurrounded);
    flood_squares(kSide, squares.size(), best, [&](std::size_t s) {
      if (is_object_[s] == 0 || squares[s] == Square::kPart) return false;
      squares[s] = Square::kPart;
      found.is_whole = found.is_whole && is_within(column(s)) && is_within(row(s));
      return true;
    });
    flood_squares(kSide, squares.size(), 0, [&](std::size_t s) {
      if (squares[s] != Square::kSurrounded) return false;
      squares[s] = Square::kAround;
      return true;
    });
    std::size_t count = 0;
    for (std::size_t s = 0; s < squares.size(); ++s)
      if (squares[s] != Square::kAround) found.centre_mm += place(s), ++count;
    found.centre_mm /= static_cast<double>(count);
    found.area_mm2 = static_cast<double>(count) * step_ * step_;
    return found;
  }

 private:
  static constexpr int kHalf = 24, kSide = 2 * kHalf + 1;
  enum class Square : std::uint8_t { kSurrounded, kPart, kAround };

  [[nodiscard]] static int column(std::size_t square) { return static_cast<int>(square) % kSide; }
  [[nodiscard]] static int row(std::size_t square) { return static_cast<int>(square) / kSide; }
  [[nodiscard]] static bool is_within(int along) { return along > 0 && along < kSide - 1; }
  [[nodiscard]] Vec3 place(std::size_t square) const {
    return middle_ + step_ * ((column(square) - kHalf) * u_ + (row(square) - kHalf) * v_);
  }

  Vec3 middle_, u_, v_;
  double step_;
  std::vector<std::uint8_t> is_object_;
};

/// Slope at 0 of the polynomial through places at depths, by the normal equations of least squares in powers
/// of depth / greatest depth. Why a parabola: docs/stages/domain.md, "Axis at an opening".
Vec3 slope_at_plane(const std::vector<double>& depths, const std::vector<Vec3>& places, int degree) {
  const auto count = static_cast<Eigen::Index>(depths.size());
  Eigen::MatrixXd powers(count, degree + 1), values(count, 3);
  for (Eigen::Index r = 0; r < count; ++r) {
    const auto i = static_cast<std::size_t>(r);
    for (int p = 0; p <= degree; ++p) powers(r, p) = std::pow(depths[i] / depths.back(), p);
    values.row(r) = places[i].transpose();
  }
  const Eigen::MatrixXd solved =
      (powers.transpose() * powers).ldlt().solve(Eigen::MatrixXd(powers.transpose() * values));
  return solved.row(1).transpose() / depths.back();
}

}  // namespace

std::optional<Vec3> end_axis(const Domain& domain, const EndSection& section, double depth_mm) {
  constexpr int kSections = 8, kMin = 4, kForCurve = 7;
  constexpr double kAlike = 1.5;  // Areas from one section to the first.
  // Cosines between axis and normal; below the second the places of centres, which slide along the wall, say
  // less of a bend than of the voxels.
  constexpr double kMinCos = 0.2, kMinCosForCurve = 0.55;
  const Vec3& normal = section.plane.normal;
  std::vector<double> depths;
  std::vector<Vec3> centres;
  double first_mm2 = 0;
  Vec3 middle = section.plane.point_mm;
  for (int i = 0; i < kSections; ++i) {
    // The first stands off the plane: beyond it are other materials.
    const double depth = depth_mm * (i + 0.1) / kSections;
    const Vec3 guess = middle - (middle - section.plane.point_mm).dot(normal) * normal - depth * normal;
    const auto found = SectionWindow(domain, guess, normal, 1.6 * section.reach_mm).find();
    if (!found || !found->is_whole) break;
    if (i == 0) first_mm2 = found->area_mm2;
    if (found->area_mm2 > kAlike * first_mm2 || kAlike * found->area_mm2 < first_mm2) break;
    depths.push_back(depth);
    centres.push_back(found->centre_mm);
    middle = found->centre_mm;
    if (i > 0) middle += found->centre_mm - centres[centres.size() - 2];
  }
  if (depths.size() < static_cast<std::size_t>(kMin)) return std::nullopt;
  const auto way_of = [&](int degree) { return Vec3(-slope_at_plane(depths, centres, degree).normalized()); };
  Vec3 way = way_of(1);
  if (depths.size() >= static_cast<std::size_t>(kForCurve) && way.dot(normal) > kMinCosForCurve)
    way = way_of(2);
  return way.dot(normal) < kMinCos ? std::nullopt : std::optional<Vec3>(way);
}

}  // namespace lumesh
