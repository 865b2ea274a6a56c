#include <algorithm>
#include <cmath>
#include <limits>

#include "lumesh/parallel/loops.hpp"
#include "value_grid.hpp"

namespace lumesh::delaunay {
namespace {

// Sizes ask surfaces, which know distances everywhere, for the last of a cell: their grid may be coarser.
constexpr double kMaxGridPoints = 2e6, kMaxGridPointsOfSurface = 2.5e5;
constexpr float kUnknown = std::numeric_limits<float>::infinity();

ValueGrid empty_grid(const Domain& domain) {
  const Box3 box = domain.bounds_mm();
  // At least two cells around, for sweeps and interpolation.
  const auto volume_with = [&](double spacing) { return (box.sizes().array() + 4 * spacing).prod(); };
  const double max_points =
      std::isinf(domain.clearance_limit_mm()) ? kMaxGridPointsOfSurface : kMaxGridPoints;
  double spacing = domain.resolution_mm();
  while (volume_with(spacing) > max_points * spacing * spacing * spacing) spacing *= 1.05;
  const Index3 size = (box.sizes() / spacing).array().ceil().cast<int>() + 5;
  return {box.min() - Vec3::Constant(2 * spacing), spacing, size};
}

/// Distance to the boundary at a place near it: to first order, by each boundary around. The clearance alone
/// would be too small across voxels that are longer than wide.
double distance_near_boundary(const Domain& domain, const Vec3& x, const Domain::Surroundings& around) {
  constexpr double kMinSlope = 0.25;  // Fields flatten where boundaries lie close together.
  constexpr double kCautious = 2.5;   // No nearest boundary of a surface is farther, in clearances.
  double smallest = std::numeric_limits<double>::infinity();
  const double limit_mm = domain.clearance_limit_mm();
  for (const Material other :
       domain.materials_near(x, std::isinf(limit_mm) ? kCautious * around.clearance_mm : limit_mm)) {
    if (other == around.material) continue;
    const FieldSample f = domain.separation(x, around.material, other);
    smallest = std::min(smallest, std::abs(f.value) / std::max(f.gradient.norm(), kMinSlope));
  }
  return std::isfinite(smallest) ? std::max(smallest, around.clearance_mm) : around.clearance_mm;
}

/// Distances that are measured at points of the grid.
class Measured {
 public:
  Measured(const Domain& domain, const ValueGrid& grid)
      : domain_(domain),
        grid_(grid),
        near_mm_(std::isinf(domain.clearance_limit_mm()) ? kNearCells * grid.spacing_mm()
                                                         : 0.5 * domain.clearance_limit_mm()) {}

  /// The distance near boundaries, kUnknown elsewhere.
  [[nodiscard]] float at(const Index3& place) const {
    const Vec3 x = grid_.point(place);
    const Domain::Surroundings around = domain_.surroundings(x);
    if (around.clearance_mm < near_mm_) return static_cast<float>(distance_near_boundary(domain_, x, around));
    return domain_.clearance_limit_mm() < grid_.spacing_mm() ? beside_other(place, around.material)
                                                             : kUnknown;
  }

 private:
  // Far from a surface its nearest triangle is dear to find: on the axis of a vessel all are equally near.
  static constexpr double kNearCells = 2.5;

  /// A coarse grid may step over all that the field knows of a boundary.
  [[nodiscard]] float beside_other(const Index3& place, Material mine) const {
    for (int a = 0; a < 3; ++a) {
      const Index3 next = place + Index3::Unit(a);
      if (next[a] < grid_.size()[a] && domain_.material_at(grid_.point(next)) != mine)
        return static_cast<float>(0.5 * grid_.spacing_mm());
    }
    return kUnknown;
  }

  const Domain& domain_;
  const ValueGrid& grid_;
  double near_mm_;
};

void fill_near_boundaries(const Domain& domain, ValueGrid& grid) {
  const Index3& size = grid.size();
  const Measured measured(domain, grid);
  parallel::for_each_index(grid_row_count(size), 1, [&](std::size_t row) {
    for (Index3 at = grid_row(size, row); at.x() < size.x(); ++at.x())
      grid.values()[grid.offset(at)] = measured.at(at);
  });
}

/// The distance that the nearest neighbours along the axes give: where |grad d| = 1, upwind. Source: Zhao
/// 2005, A fast sweeping method for eikonal equations, doi:10.1090/S0025-5718-04-01678-3, eq. (2.4).
double upwind(std::array<double, 3> d, double h) {
  std::ranges::sort(d);
  double u = d[0] + h;
  if (u <= d[1]) return u;
  u = 0.5 * (d[0] + d[1] + std::sqrt(2 * h * h - (d[0] - d[1]) * (d[0] - d[1])));
  if (u <= d[2]) return u;
  const double sum = d[0] + d[1] + d[2], squares = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  return (sum + std::sqrt(std::max(sum * sum - 3 * (squares - h * h), 0.0))) / 3;
}

/// One pass over the grid in the direction of `signs`; known distances stay where none smaller is found.
void sweep(ValueGrid& grid, const std::vector<std::uint8_t>& is_known, const Index3& signs) {
  const Index3& size = grid.size();
  const std::array<std::size_t, 3> strides = {1, grid.offset({0, 1, 0}), grid.offset({0, 0, 1})};
  std::vector<float>& values = grid.values();
  const auto place = [&](int a, int n) { return signs[a] > 0 ? n : size[a] - 1 - n; };
  for (int nk = 0; nk < size.z(); ++nk) {
    for (int nj = 0; nj < size.y(); ++nj) {
      for (int ni = 0; ni < size.x(); ++ni) {
        const Index3 at(place(0, ni), place(1, nj), place(2, nk));
        const std::size_t here = grid.offset(at);
        if (is_known[here] != 0) continue;
        std::array<double, 3> smallest = {};
        for (int a = 0; a < 3; ++a)
          smallest[a] = std::min(at[a] > 0 ? values[here - strides[a]] : kUnknown,
                                 at[a] + 1 < size[a] ? values[here + strides[a]] : kUnknown);
        if (std::isinf(std::min({smallest[0], smallest[1], smallest[2]}))) continue;
        values[here] = std::min(values[here], static_cast<float>(upwind(smallest, grid.spacing_mm())));
      }
    }
  }
}

}  // namespace

ValueGrid boundary_distances(const Domain& domain) {
  ValueGrid grid = empty_grid(domain);
  fill_near_boundaries(domain, grid);
  std::vector<std::uint8_t> is_known(grid.values().size());
  std::transform(grid.values().begin(), grid.values().end(), is_known.begin(),
                 [](float d) { return static_cast<std::uint8_t>(std::isfinite(d)); });
  for (int octant = 0; octant < 8; ++octant)
    sweep(grid, is_known,
          Index3((octant & 1) != 0 ? 1 : -1, (octant & 2) != 0 ? 1 : -1, (octant & 4) != 0 ? 1 : -1));
  return grid;
}

}  // namespace lumesh::delaunay
