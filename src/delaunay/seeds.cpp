#include "seeds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lumesh/core/grid.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"
#include "thinning.hpp"

namespace lumesh::delaunay {
namespace {

/// Lattice constant in units of the wanted edge length: of the 14 edges at a point of the lattice six have
/// that length and eight are sqrt(3) / 2 of it.
constexpr double kConstantPerSize = 1.087;

/// Distance of points of a surface in units of what rule R1 asks for, so that few gaps are left for it:
/// candidates stand about so densely.
constexpr double kSeedSpacing = 0.9;

/// Spacings below this share of the domain's resolution are not looked for.
constexpr double kMinSpacing = 0.4;

/// From where curves and corners are looked for, in spacings.
constexpr double kCurveReach = 0.5;

/// Cells up to this size are seen from their middle, in units of how far the domain sees: what hides in a
/// corner is much smaller than a voxel.
constexpr double kSeen = 1.25;

/// Cells that are cut finer than wanted, for the sake of close points on a boundary, are 0.85 to 1.7 of their
/// spacings large, as it happens. Below the first of these numbers of spacings their inner points are thinned
/// out, to the second number apart: else there would be eight times as many of them as in the largest ones.
constexpr double kCrowded = 1.25, kCrowdedApart = 1.1;

/// How far inner points stay from boundaries, in lattice constants.
constexpr double kMargin = 0.5;
constexpr double kHalfDiagonal = 0.867;  // Of a cube with edges of length 1.

/// Spread over [-1, 1]; the same for the same number.
double scattered(std::uint64_t x) {
  x = (x ^ x >> 31) * 0xBF58476D1CE4E5B9ull;
  x = (x ^ x >> 29) * 0x94D049BB133111EBull;
  return static_cast<double>(x >> 11) * 0x1p-52 - 1;
}

/// The edges of an end that have one triangle of it, in the order of precedes().
std::vector<std::array<Vec3, 2>> edges_around(const FlatEnd& end) {
  std::vector<std::array<Vec3, 2>> edges;
  for (const std::array<Vec3, 3>& t : end.triangles_mm)
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 &a = t[i], &b = t[(i + 1) % 3];
      edges.push_back(precedes(a, b) ? std::array{a, b} : std::array{b, a});
    }
  std::ranges::sort(edges, [](const auto& e, const auto& f) {
    return e[0] == f[0] ? precedes(e[1], f[1]) : precedes(e[0], f[0]);
  });
  std::vector<std::array<Vec3, 2>> around;
  for (std::size_t i = 0; i < edges.size(); ++i)
    if ((i == 0 || edges[i] != edges[i - 1]) && (i + 1 == edges.size() || edges[i] != edges[i + 1]))
      around.push_back(edges[i]);
  return around;
}

class LatticeDescent {
 public:
  explicit LatticeDescent(const Spacing& spacing)
      : spacing_(spacing), domain_(spacing.domain()), reach_mm_(domain_.clearance_limit_mm()) {
    // Halved, it comes down to the edges of surfaces, and what grows from there is not cut finer than wanted.
    const double size_mm = spacing.size_mm(), edge_mm = kEdgePerSpacing * spacing.delta_mm();
    root_mm_ = kConstantPerSize * (spacing.is_constant() ? size_mm : std::min(size_mm, edge_mm));
    const double min_mm =
        std::max(8 * domain_.resolution_mm(), std::min(size_mm / 2, box_.diagonal().norm()));
    while (root_mm_ < min_mm) root_mm_ *= 2;
    // Off the grid of voxels, on which boundaries like to lie.
    origin_ = box_.min() - root_mm_ * Vec3(1.8143, 1.7571, 1.7877);
    for (int axis = 0; axis < 3; ++axis)
      cells_[axis] = static_cast<int>(std::ceil((box_.max()[axis] - origin_[axis]) / root_mm_)) + 2;
  }

  [[nodiscard]] Seeds run() const {
    const auto roots =
        parallel::collect<Index3>(grid_count(cells_), [&](std::size_t i, std::vector<Index3>& out) {
          const Index3 cell = grid_place(cells_, i);
          if (holds_object(low_of(cell), root_mm_)) out.push_back(cell);
        });
    const auto around =
        parallel::collect<Vec3>(grid_count(cells_), [&](std::size_t i, std::vector<Vec3>& out) {
          const Index3 cell = grid_place(cells_, i);
          if (!holds_object(low_of(cell), root_mm_) &&
              domain_.may_hold_object(low_of(cell) - Vec3::Constant(root_mm_),
                                      low_of(cell) + Vec3::Constant(2 * root_mm_)))
            out.push_back(perturbed(low_of(cell) + Vec3::Constant(0.5 * root_mm_), root_mm_));
        });
    const auto parts = parallel::collect_parts<Seeds>(
        roots.size(), kRootsPerPart, [&](std::size_t begin, std::size_t end, std::vector<Seeds>& out) {
          out.emplace_back();
          for (std::size_t i = begin; i < end; ++i)
            descend(low_of(roots[i]), root_mm_, kNoSpacing, out.back());
        });
    Seeds all;
    all.outer = around;
    for (const auto& part : parts) {
      all.inner.insert(all.inner.end(), part[0].inner.begin(), part[0].inner.end());
      all.outer.insert(all.outer.end(), part[0].outer.begin(), part[0].outer.end());
      all.boundary.insert(all.boundary.end(), part[0].boundary.begin(), part[0].boundary.end());
      all.crowded.insert(all.crowded.end(), part[0].crowded.begin(), part[0].crowded.end());
    }
    for (const std::uint32_t one : poisson_disk_subset(all.crowded))
      all.inner.push_back(all.crowded[one].point);
    for (const std::vector<BoundaryCandidate>& more :
         {rim_candidates(), end_rim_candidates(), fixed_candidates()})
      all.boundary.insert(all.boundary.end(), more.begin(), more.end());
    return all;
  }

 private:
  static constexpr std::size_t kRootsPerPart = 16;
  static constexpr double kNoSpacing = std::numeric_limits<double>::infinity();

  /// All along the rims of openings: where the wall slants, cells that look for boundaries may see none of
  /// it.
  [[nodiscard]] std::vector<BoundaryCandidate> rim_candidates() const {
    constexpr double kMinStep = 0.1, kMaxStep = 0.4;  // Voxels.
    constexpr double kStep = 0.3;                     // Of delta.
    const double voxel_mm = domain_.resolution_mm();
    const std::vector<RimPlace> places = find_rim_places(
        domain_, std::clamp(kStep * spacing_.delta_mm(), kMinStep * voxel_mm, kMaxStep * voxel_mm));
    return parallel::collect<BoundaryCandidate>(places.size(), [&](std::size_t i,
                                                                   std::vector<BoundaryCandidate>& out) {
      const auto& [place, materials] = places[i];
      const double spacing = kSeedSpacing * spacing_.surface_spacing_at(place, materials[0], materials[1]);
      add_curve_candidate(place, {materials[0], materials[1], materials[2]}, spacing, out);
    });
  }

  /// Candidates on rims of flat ends that are so small that these rims are to be finer than the surface.
  [[nodiscard]] std::vector<BoundaryCandidate> end_rim_candidates() const {
    constexpr double kStep = 0.3;  // Of the spacing wanted.
    const double on_it_mm = 1e-3 * domain_.resolution_mm();
    std::vector<BoundaryCandidate> found;
    for (const FlatEnd& end : domain_.flat_ends()) {
      const double wanted_mm = kSpacingPerEndRadius * circle_radius(end.area_mm2);
      if (wanted_mm >= spacing_.delta_mm()) continue;
      for (const auto& [a, b] : edges_around(end)) {
        const int count = static_cast<int>(std::ceil((b - a).norm() / (kStep * wanted_mm)));
        for (int i = 0; i < count; ++i) {
          const Vec3 place = a + (i + 0.5) / count * (b - a);
          const MaterialSet there = domain_.materials_near(place, on_it_mm);
          if (there.size() == 3 && is_seam(there)) add_curve_candidate(place, there, wanted_mm, found);
        }
      }
    }
    return found;
  }

  [[nodiscard]] std::vector<BoundaryCandidate> fixed_candidates() const {
    const std::span<const Vec3> fixed = domain_.fixed_points();
    const double on_it_mm = 1e-6 * domain_.resolution_mm();
    return parallel::collect<BoundaryCandidate>(
        fixed.size(), [&](std::size_t i, std::vector<BoundaryCandidate>& out) {
          const MaterialSet there = domain_.materials_near(fixed[i], on_it_mm);
          if (there.size() < 2) return;
          const auto [inside, other] = meshed_pair_of(there);
          out.push_back(
              {fixed[i], there, kSeedSpacing * spacing_.surface_spacing_at(fixed[i], inside, other), true});
        });
  }
  [[nodiscard]] std::pair<Material, Material> meshed_pair_of(const MaterialSet& set) const {
    const std::size_t inside = domain_.is_meshed(set[0]) ? 0 : 1;
    return {set[inside], set[1 - inside]};
  }

  [[nodiscard]] Vec3 low_of(const Index3& cell) const { return origin_ + root_mm_ * cell.cast<double>(); }
  [[nodiscard]] bool holds_object(const Vec3& low, double size) const {
    return domain_.may_hold_object(low - Vec3::Constant(0.5 * size), low + Vec3::Constant(1.5 * size));
  }
  [[nodiscard]] double wanted_constant(const Vec3& low, double size) const {
    if (spacing_.is_constant()) return kConstantPerSize * spacing_.size_mm();
    const Vec3 middle = low + Vec3::Constant(0.5 * size);
    const Material m = domain_.material_at(middle);
    return kConstantPerSize * spacing_.size_at(middle, domain_.is_meshed(m) ? m : 1);
  }

  /// @param around  Spacing of points of a thin part that a cell around this one was divided for.
  /// @return false if nothing of the object, nor of what is near its boundary, is in the cell.
  bool descend(const Vec3& low, double size, double around, Seeds& out) const {
    if (!holds_object(low, size)) return false;
    const Domain::Surroundings here = domain_.surroundings(low + Vec3::Constant(0.5 * size));
    if (is_small_enough(low, size)) {
      constexpr double kMaxSpacings = 1.7;
      const Closeness closeness = closeness_in(low, size, here, size / kMaxSpacings);
      if (size <= kMaxSpacings * closeness.spacing)
        return add_leaf(low, size, here, {closeness.spacing, around}, out);
      if (closeness.is_thin) around = std::min(around, closeness.spacing);
    }
    const bool is_of_one = here.clearance_mm >= kHalfDiagonal * size + kMargin * size;
    if (is_of_one && !domain_.is_meshed(here.material)) return false;
    const auto descend_to = [&](int child) {
      const Vec3 low_of_it = low_of_child(low, size, child);
      return is_of_one ? fill(low_of_it, 0.5 * size, out) : descend(low_of_it, 0.5 * size, around, out);
    };
    std::array<bool, 8> holds{};
    for (int child = 0; child < 8; ++child) holds[static_cast<std::size_t>(child)] = descend_to(child);
    if (std::ranges::none_of(holds, [](bool h) { return h; })) return false;
    add_outer(low, size, holds, out);
    return true;
  }

  /// The lattice in a cell that is inside as a whole, far from boundaries.
  bool fill(const Vec3& low, double size, Seeds& out) const {
    if (is_small_enough(low, size)) {
      out.inner.push_back(perturbed(low, size));
      out.inner.push_back(perturbed(low + Vec3::Constant(0.5 * size), size));
    } else {
      for (int child = 0; child < 8; ++child) fill(low_of_child(low, size, child), 0.5 * size, out);
    }
    return true;
  }

  /// One point for all empty leaves of a cell, one for each larger empty part.
  void add_outer(const Vec3& low, double size, const std::array<bool, 8>& holds, Seeds& out) const {
    for (int child = 0; child < 8; ++child) {
      if (holds[static_cast<std::size_t>(child)]) continue;
      const Vec3 low_of_it = low_of_child(low, size, child);
      out.outer.push_back(perturbed(low_of_it + Vec3::Constant(0.25 * size), 0.5 * size));
      if (is_small_enough(low_of_it, 0.5 * size)) return;
    }
  }

  /// Whether points of a boundary stand closer than sizes ask for.
  [[nodiscard]] bool is_for_shapes(double spacing, const Vec3& low, double size) const {
    constexpr double kCloser = 0.85;
    return spacing < kCloser * wanted_constant(low, size) / (kConstantPerSize * kEdgePerSpacing);
  }
  [[nodiscard]] bool is_small_enough(const Vec3& low, double size) const {
    constexpr double kMaxFiner = 4;  // Finer wants are left to the rules: they may have no end.
    constexpr double kShare = 0.8;   // Cells a little too large cost fewer points if the rules split them.
    const double max_size = std::sqrt(2.0) * wanted_constant(low, size);
    return size <= max_size &&
           (size * kMaxFiner <= max_size || !spacing_.wants_finer(lattice_tet(low, kShare * size)));
  }
  /// One of the tetrahedra of the lattice in a cell; they are all alike.
  static std::array<Vec3, 4> lattice_tet(const Vec3& low, double size) {
    return {low, low + size * Vec3(1, 0, 0), low + 0.5 * size * Vec3(1, 1, 1),
            low + 0.5 * size * Vec3(1, -1, 1)};
  }

  /// How close points of a boundary in a cell stand.
  struct Closeness {
    double spacing = kNoSpacing;
    bool is_thin = false;  ///< Closer than sizes ask for, before a thin part of what is meshed.
  };

  /// No spacing if there is no boundary, or none that is finer than the lattice would have it.
  /// @param here  Around its middle. @param fine  Less is not told apart: parts of a cell too large to be
  /// seen as a whole are looked at until one has so little.
  [[nodiscard]] Closeness closeness_in(const Vec3& low, double size, const Domain::Surroundings& here,
                                       double fine) const {
    Closeness closest;
    if (here.clearance_mm > kHalfDiagonal * size) return closest;
    if (size > kSeen * reach_mm_) {
      for (int child = 0; child < 8 && closest.spacing >= fine; ++child) {
        const Vec3 low_of_it = low_of_child(low, size, child);
        if (!box_.intersects(Box3(low_of_it, low_of_it + Vec3::Constant(0.5 * size)))) continue;
        const Domain::Surroundings there = domain_.surroundings(low_of_it + Vec3::Constant(0.25 * size));
        const Closeness of_child = closeness_in(low_of_it, 0.5 * size, there, fine);
        if (of_child.spacing < closest.spacing) closest = of_child;
      }
      return closest;
    }
    const Vec3 middle = low + Vec3::Constant(0.5 * size);
    for (const Material other : domain_.materials_near(middle, kHalfDiagonal * size)) {
      if (other == here.material || !(domain_.is_meshed(other) || domain_.is_meshed(here.material))) continue;
      const auto x = domain_.project(middle, {here.material, other}, size);
      if (!x) continue;
      const double spacing = spacing_.surface_spacing_at(*x, here.material, other);
      if (spacing >= closest.spacing) continue;
      closest = {spacing, is_for_shapes(spacing, low, size) && spacing_.is_thin_at(*x, here.material, other)};
    }
    closest.spacing = std::max(closest.spacing, kMinSpacing * domain_.resolution_mm());
    return closest;
  }
  [[nodiscard]] static Vec3 low_of_child(const Vec3& low, double size, int child) {
    return low + 0.5 * size * Vec3(child & 1, child >> 1 & 1, child >> 2);
  }

  /// Spacings of points of a boundary.
  struct LeafSpacings {
    double here;    ///< In the cell.
    double around;  ///< The spacing of a thin part that a cell around it was divided for.
  };

  bool add_leaf(const Vec3& low, double size, const Domain::Surroundings& here, const LeafSpacings& spacings,
                Seeds& out) const {
    const double spacing = spacings.here;
    const Vec3 middle = low + Vec3::Constant(0.5 * size);
    const bool is_meshed = domain_.is_meshed(here.material);
    // Where the clearance reaches over the whole cell, its corner is like its middle.
    if (!is_meshed && here.clearance_mm > kHalfDiagonal * size) return false;
    // Inner points nearer to a boundary than this would be corners of its faces.
    constexpr double kMarginSpacings = 0.7;
    const double margin = std::max(kMargin * size, std::isfinite(spacing) ? kMarginSpacings * spacing : 0.0);
    add_lattice_point(middle, here, size, margin, spacings.around, out);
    const bool has_low =
        add_lattice_point(low, domain_.surroundings(low), size, margin, spacings.around, out);
    const bool may_be_near = here.clearance_mm <= 0.95 * size || here.clearance_mm >= 0.99 * reach_mm_;
    const bool is_known = size > kSeen * reach_mm_ && !std::isfinite(spacing);  // closeness_in() saw none.
    if (!may_be_near || is_known) return is_meshed || has_low;
    // So many that few gaps stay between them.
    constexpr double kCandidateSpacing = 0.72;
    const int along = std::max(size > 2 * kCandidateSpacing * spacing ? 3 : 2,
                               static_cast<int>(std::ceil(size / (kSeen * reach_mm_))));
    const double part = size / along;
    for (int k = 0; k < along; ++k)
      for (int j = 0; j < along; ++j)
        for (int i = 0; i < along; ++i)
          add_candidates(low + part * Vec3(i + 0.5, j + 0.5, k + 0.5), 0.52 * part, out);
    return true;
  }

  bool add_lattice_point(const Vec3& place, const Domain::Surroundings& here, double size, double margin,
                         double around, Seeds& out) const {
    if (!domain_.is_meshed(here.material) || here.clearance_mm < std::min(margin, 0.99 * reach_mm_))
      return false;
    if (size < kCrowded * around && std::isfinite(around))
      out.crowded.push_back({perturbed(place, size), {here.material}, kCrowdedApart * around});
    else
      out.inner.push_back(perturbed(place, size));
    return true;
  }

  /// A little off the place, so that few of the points are on one plane or sphere.
  static Vec3 perturbed(const Vec3& place, double size) {
    constexpr double kPerturbation = 1e-3;
    std::uint64_t seed = 0x9E3779B97F4A7C15ull;
    for (int axis = 0; axis < 3; ++axis)
      seed = seed * 0xD1342543DE82EF95ull + static_cast<std::uint64_t>(std::llround(place[axis] / size * 64));
    return place + kPerturbation * size * Vec3(scattered(seed), scattered(seed + 1), scattered(seed + 2));
  }

  /// What lies on boundaries nearest to a place within a distance.
  void add_candidates(const Vec3& place, double distance, Seeds& out) const {
    const Domain::Surroundings here = domain_.surroundings(place);
    if (here.clearance_mm > distance) return;
    const MaterialSet near = domain_.materials_near(place, 2 * distance);
    for (const Material other : near)
      if (other != here.material) add_candidate(place, {here.material, other}, 2 * distance, out);
  }

  void add_candidate(const Vec3& place, const MaterialSet& pair, double distance, Seeds& out) const {
    if (!domain_.is_meshed(pair[0]) && !domain_.is_meshed(pair[1])) return;
    const auto x = domain_.project(place, pair, distance);
    if (!x) return;
    const double spacing = kSeedSpacing * spacing_.surface_spacing_at(*x, pair[0], pair[1]);
    const MaterialSet there = domain_.materials_near(*x, 1e-3 * domain_.resolution_mm());
    if (there.contains_all(pair)) out.boundary.push_back({*x, pair, spacing});
    add_curve_candidates(*x, pair, spacing, out);
  }

  /// Where the boundary between two materials meets a third near by, and where such curves meet. Candidates
  /// stand close: those farther from curves need not look.
  void add_curve_candidates(const Vec3& x, const MaterialSet& pair, double spacing, Seeds& out) const {
    for (const Material third : domain_.materials_near(x, kCurveReach * spacing)) {
      if (pair.contains(third)) continue;
      MaterialSet triple = pair;
      triple.insert(third);
      if (is_seam(triple)) add_curve_candidate(x, triple, spacing, out.boundary);
    }
  }

  void add_curve_candidate(const Vec3& x, const MaterialSet& triple, double spacing,
                           std::vector<BoundaryCandidate>& out) const {
    const auto y = domain_.project(x, triple, 2 * kCurveReach * spacing);
    if (!y || !domain_.materials_near(*y, 1e-2 * domain_.resolution_mm()).contains_all(triple)) return;
    out.push_back({*y, triple, spacing_.curve_spacing_at(*y, triple, spacing)});
    for (const Material fourth : domain_.materials_near(*y, kCurveReach * spacing)) {
      if (triple.contains(fourth)) continue;
      MaterialSet all = triple;
      all.insert(fourth);
      const auto z = domain_.project(*y, all, 2 * kCurveReach * spacing);
      if (z && domain_.materials_near(*z, 2e-2 * domain_.resolution_mm()).contains_all(all))
        out.push_back({*z, all, spacing});
    }
  }

  /// True if at least two different boundaries of the mesh meet where these materials do.
  [[nodiscard]] bool is_seam(const MaterialSet& set) const {
    for (const Material m : set)
      if (domain_.is_meshed(m)) return true;
    return false;
  }

  const Spacing& spacing_;
  const Domain& domain_;
  Box3 box_ = domain_.bounds_mm();
  double reach_mm_, root_mm_ = 0;
  Vec3 origin_ = Vec3::Zero();
  Index3 cells_ = Index3::Zero();
};

}  // namespace

Seeds lattice_seeds(const Spacing& spacing) {
  return LatticeDescent(spacing).run();
}

}  // namespace lumesh::delaunay
