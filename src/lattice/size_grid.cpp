#include "size_grid.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numbers>

#include "lumesh/core/error.hpp"
#include "lumesh/core/memory.hpp"
#include "lumesh/domain/usual_edge.hpp"
#include "lumesh/field/boundary_bricks.hpp"
#include "lumesh/image/neighbourhood.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh {

namespace {

constexpr int kRidgeCount = 11;  // of the 27 voxels around; fewer on edges, at ends and in clefts
constexpr double kEdgesAround = 8;

/// Edge of which so many go around an ellipse with these widths.
double edge_around(double width, double breadth) {
  return std::numbers::pi / 2 * (width + breadth) / kEdgesAround;
}

/// Wanted edges along diameters become spacings. In tubes of 3 to 12 voxels in radius the mean edge of the
/// wall is this share of the spacing.
constexpr double kEdgeOfSpacing = 0.88;
/// Spacings may be so many times too large: chords of voxels scatter, and the smallest ones near by would
/// halve the spacing all along a vessel.
constexpr double kSlack = 1.15;

/// Numbers of boundary voxels that want each spacing, by the octaves that it is below the usual one.
struct WantedSpacings {
  static constexpr int kBinsPerOctave = 16, kOctaves = 8;

  std::array<std::uint64_t, kBinsPerOctave* kOctaves> counts = {};

  void add(double octaves) {
    const double bin = std::clamp(std::round(octaves * kBinsPerOctave), 0.0, counts.size() - 1.0);
    ++counts[static_cast<std::size_t>(bin)];
  }
  /// Mean distance in bins, times the voxels, between what is wanted and what halving gives, from this many
  /// bins below the usual spacing on.
  [[nodiscard]] std::uint64_t distance_from(int shift, int max_halvings) const {
    const int slack = static_cast<int>(kBinsPerOctave * std::log2(kSlack));
    std::uint64_t sum = 0;
    for (int bin = 0; bin < std::ssize(counts); ++bin) {
      int made = shift;
      for (int k = 0; k < max_halvings && made < bin - slack; ++k) made += kBinsPerOctave;
      sum += counts[static_cast<std::size_t>(bin)] * static_cast<std::uint64_t>(std::abs(made - bin));
    }
    return sum;
  }
  /// Octaves below the usual spacing, less than one, from which halving comes nearest.
  [[nodiscard]] double best_shift(int max_halvings) const {
    int best = 0;
    for (int shift = 1; shift < kBinsPerOctave; ++shift)
      if (distance_from(shift, max_halvings) < distance_from(best, max_halvings)) best = shift;
    return static_cast<double>(best) / kBinsPerOctave;
  }
};

/// The largest width at which that edge can be shorter.
double width_for_edge(double edge) {
  return 2 / std::numbers::pi * kEdgesAround * edge;
}

}  // namespace

SizeGrid::SizeGrid(const LabelImage& image, const ImageDomain& domain, const LatticeOptions& options,
                   double coarsest_mm)
    : image_(image),
      domain_(domain),
      coarsest_mm_(coarsest_mm),
      min_level_(options.coarsening),
      max_level_(options.coarsening + options.max_refinement),
      cap_(max_level_),
      has_cells_(options.cells_per_diameter > 0),
      cells_((image.frame().size + Index3::Constant(kCell - 1)) / kCell) {
  for (const Label label : image.values()) {
    const auto own = options.label_fidelity.find(label);
    const double fidelity = own == options.label_fidelity.end() ? options.fidelity : own->second;
    const bool is_by_cells =
        options.cells_per_diameter > 0 && label != kBackground && own == options.label_fidelity.end();
    // 4 (1 - F) of half the chord
    thickness_factor_.push_back(is_by_cells ? kSlack / (kEdgeOfSpacing * options.cells_per_diameter)
                                            : 2 * (1 - fidelity));
    firm_.push_back(own == options.label_fidelity.end() ? 0 : kFirm);
  }
}

SizeGrid::SizeGrid(const LabelImage& image, const ImageDomain& domain, const LatticeOptions& options,
                   double coarsest_mm, std::size_t object_voxels, const OpeningSizes& at_openings)
    : SizeGrid(image, domain, options, coarsest_mm) {
  wanted_.resize(grid_count(cells_));
  parallel::for_each_index(brick_count(image), 16, [&](std::size_t b) {
    for_each_voxel_near_boundary(image_, domain_.field(), b, [&](const Index3& voxel) { note_voxel(voxel); });
  });
  for (const Opening& opening : at_openings.openings()) note_opening(opening);
  for (const OpeningSize& size : at_openings.sizes()) note_size(size);
  coarsen_to(options.max_tetrahedra, object_voxels);
}

/// A vessel that an edge of the image cuts is wider than its openings.
void SizeGrid::note_opening(const Opening& opening) {
  constexpr double kOfShare = 1.15;  // Edges at boundaries are shorter than the spacing.
  constexpr double kOfWidth = 0.65;  // In coarser lattices narrow ones lose area.
  const double perimeter_mm = opening.perimeter_mm(), width_mm = 4 * opening.area_mm2 / perimeter_mm;
  const int level = level_for(std::min(kOfShare * perimeter_mm / kEdgesAround, kOfWidth * width_mm));
  const Box3 voxels = voxel_box(image_.frame(), opening.box_mm);
  const IndexBox box = cells_between(voxels.min(), voxels.max());
  for_each_place(box.low, box.high, [&](const Index3& cell) { note_level(cell, level, 0); });
}

/// A level more for each halving than a cell wants already.
void SizeGrid::note_size(const OpeningSize& size) {
  constexpr double kReach = 2;  // Edges, from the disc.
  const double half_cell_mm = 0.5 * kCell * image_.frame().spacing_mm.norm();
  const double reach_mm = kReach * size.edge_mm + half_cell_mm;
  const IndexBox box = cells_around(size.centre_mm, size.radius_mm + reach_mm);
  for_each_place(box.low, box.high, [&](const Index3& cell) {
    const Vec3 middle = kCell * cell.cast<double>() + Vec3::Constant(0.5 * (kCell - 1));
    if (size.distance_mm(image_.frame().to_physical(middle)) > reach_mm) return;
    const int level = (wanted_[cell_number(cell)] & ~kFirm) - 1;
    note_level(cell, std::min(level + size.halvings, max_level_), kFirm);
  });
}

void SizeGrid::note_level(const Index3& cell, int level, std::uint8_t firm) {
  std::uint8_t& wanted = wanted_[cell_number(cell)];
  if (wanted == 0) return;
  const int most = std::max<int>(wanted & ~kFirm, level + 1);
  wanted = static_cast<std::uint8_t>(most | ((wanted | firm) & kFirm));
}

int SizeGrid::level_for(double edge_mm) const {
  int level = min_level_;
  while (level < max_level_ && coarsest_mm_ / std::exp2(level) > edge_mm) ++level;
  return level;
}

/// A cell at level l takes its volume over a lattice tetrahedron's, h^3 / 12; about half of it lies in the
/// object. The rest of the object is filled at the coarsest spacing.
double SizeGrid::predict(int cap, double object_mm3) const {
  const double cell_mm3 = image_.frame().voxel_volume_mm3() * kCell * kCell * kCell;
  const auto sum = parallel::sum<double>(wanted_.size(), 65536, [&](std::size_t c) {
    if (wanted_[c] == 0) return 0.0;
    const int level = (wanted_[c] & kFirm) != 0 ? (wanted_[c] & ~kFirm) - 1 : std::min(cap, wanted_[c] - 1);
    return std::exp2(3 * level);
  });
  const double per_mm3 = 12 / (coarsest_mm_ * coarsest_mm_ * coarsest_mm_);
  return per_mm3 * (object_mm3 + 0.75 * cell_mm3 * sum);
}

void SizeGrid::coarsen_to(std::size_t max_tetrahedra, std::size_t object_voxels) {
  const double object_mm3 = static_cast<double>(object_voxels) * image_.frame().voxel_volume_mm3();
  double predicted = predict(cap_, object_mm3);
  while (predicted > static_cast<double>(max_tetrahedra) && cap_ > min_level_)
    predicted = predict(--cap_, object_mm3);
  constexpr double kBytesEach =
      900;  // measured: lattice, numbering and fit together, per tetrahedron of the mesh
  const double free_bytes = static_cast<double>(available_memory_bytes());
  if (predicted * kBytesEach > free_bytes) {
    throw Error(
        ErrorKind::kMemory,
        fmt::format("about {:.2g} tetrahedra would need {:.2g} GB of memory and {:.2g} GB are free; choose a "
                    "larger `edge_length`",
                    predicted, predicted * kBytesEach / 1e9, free_bytes / 1e9));
  }
  for (std::uint8_t& cell : wanted_) {
    cell = (cell & kFirm) != 0 ? static_cast<std::uint8_t>(cell & ~kFirm)
                               : std::min(cell, static_cast<std::uint8_t>(cap_ + 1));
  }
}

void SizeGrid::note_voxel(const Index3& voxel) {
  const int level = voxel_level(voxel);
  if (level < 0) return;
  std::uint8_t& cell = wanted_[cell_number(voxel / kCell)];
  const std::uint8_t firm = static_cast<std::uint8_t>((cell | firm_[image_.at(voxel)]) & kFirm);
  const int most = std::max<int>(cell & ~kFirm, level + 1);
  cell = static_cast<std::uint8_t>(most | firm);
}

std::optional<double> SizeGrid::allowed_mm(const Index3& voxel) const {
  const ImageFrame& frame = image_.frame();
  const LabelImage::Index own = image_.at(voxel);
  bool boundary = false;
  for (int axis = 0; axis < 3 && !boundary; ++axis) {
    for (const int d : {-1, 1}) {
      Index3 next = voxel;
      next[axis] += d;
      boundary |= frame.contains(next) ? image_.at(next) != own : own != 0;
    }
  }
  if (!boundary) return std::nullopt;
  const double factor = thickness_factor_[own];
  const double widest_mm = coarsest_mm_ / std::exp2(min_level_);
  const double chord_limit_mm =
      std::max(1.01 * (has_cells_ ? kSlack : 1) * widest_mm / factor, width_for_edge(widest_mm));
  const std::optional<Vec3> inwards = inwards_at(voxel, own);
  const double chord =
      inwards ? chord_mm(voxel, *inwards, own, chord_limit_mm) : shortest_run_mm(voxel, own, chord_limit_mm);
  double allowed_mm = factor * chord;
  if (own != 0 && inwards && chord < chord_limit_mm)
    allowed_mm = std::min(allowed_mm, edge_around_section_mm(voxel, *inwards, chord, own, chord_limit_mm));
  return allowed_mm;
}

int SizeGrid::voxel_level(const Index3& voxel) const {
  const std::optional<double> allowed = allowed_mm(voxel);
  if (!allowed) return -1;
  int level = level_for(*allowed);
  // Rims of openings count as edges: with a number of edges across they are as fine as asked for.
  const bool may_be_ridge = !has_cells_ && level == min_level_ && level < max_level_;
  if (may_be_ridge && same_label_count(image_, voxel) <= kRidgeCount) ++level;
  return level;
}

std::optional<Vec3> SizeGrid::inwards_at(const Index3& voxel, LabelImage::Index label) const {
  const Vec3 gradient =
      domain_.field().sample(voxel.cast<double>(), label).gradient.cwiseQuotient(image_.frame().spacing_mm);
  if (gradient.norm() < 1e-3) return std::nullopt;
  return gradient.normalized();
}

const CutPlane* SizeGrid::faced_cut(const Vec3& direction) const {
  constexpr double kNearlyNormal =
      0.8;  // Cosine; vessels that meet a plane at less than 53 degrees have none.
  const std::span<const CutPlane> cuts = domain_.cut_planes();
  const auto faced = std::ranges::find_if(
      cuts, [&](const CutPlane& cut) { return cut.normal.dot(direction) > kNearlyNormal; });
  return faced == cuts.end() ? nullptr : &*faced;
}

double SizeGrid::chord_mm(const Index3& voxel, const Vec3& inwards, LabelImage::Index label,
                          double limit_mm) const {
  const ImageFrame& frame = image_.frame();
  const Vec3 start = voxel.cast<double>();
  const Vec3 step = inwards.cwiseQuotient(frame.spacing_mm);
  const double step_mm = 0.5 * frame.spacing_mm.minCoeff();
  const double behind_mm = 0.5 * step_mm + 0.25 * frame.spacing_mm.minCoeff();
  const CutPlane* const faced = faced_cut(frame.direction * inwards);
  for (double t = step_mm; t + behind_mm < limit_mm; t += step_mm) {
    if (faced != nullptr && faced->beyond_mm(frame.to_physical(start + t * step)) > 0) return t + behind_mm;
    const Index3 v = (start + t * step).array().round().cast<int>();
    if (!frame.contains(v)) return limit_mm;
    if (image_.at(v) != label) return t + behind_mm;
  }
  return limit_mm;
}

double SizeGrid::ray_mm(const Vec3& start_mm, const Vec3& direction, LabelImage::Index label,
                        double limit_mm) const {
  const double step_mm = 0.1 * domain_.resolution_mm();
  for (double t = 0; t < limit_mm;) {
    const Domain::Surroundings here = domain_.surroundings(start_mm + t * direction);
    if (domain_.is_cut(here.material)) return limit_mm;
    if (here.material != label) return t;
    t += std::max(here.clearance_mm, step_mm);
  }
  return limit_mm;
}

double SizeGrid::edge_around_section_mm(const Index3& voxel, const Vec3& inwards, double chord_mm,
                                        LabelImage::Index label, double limit_mm) const {
  const ImageFrame& frame = image_.frame();
  const Vec3 through = frame.direction * inwards;
  Vec3 middle_mm = frame.to_physical(voxel.cast<double>()) + 0.5 * chord_mm * through;
  if (domain_.material_at(middle_mm) != label) return limit_mm;  // the voxel is the wall's, or noise
  const double forth_mm = ray_mm(middle_mm, through, label, limit_mm);
  const double back_mm = ray_mm(middle_mm, -through, label, limit_mm);
  const double width_mm = forth_mm + back_mm;
  middle_mm += 0.5 * (forth_mm - back_mm) * through;
  // The shortest way through the middle at a right angle: 8 % too long at most where the section is round.
  constexpr int kDirections = 4;  // over half a turn
  const Vec3 first = through.unitOrthogonal();
  const Vec3 second = through.cross(first);
  double breadth_mm = limit_mm;
  for (int d = 0; d < kDirections; ++d) {
    const double angle = std::numbers::pi * d / kDirections;
    const Vec3 direction = std::cos(angle) * first + std::sin(angle) * second;
    const double one_mm = ray_mm(middle_mm, direction, label, breadth_mm);
    if (one_mm < breadth_mm)
      breadth_mm = std::min(breadth_mm, one_mm + ray_mm(middle_mm, -direction, label, breadth_mm));
  }
  return edge_around(width_mm, breadth_mm);
}

double SizeGrid::shortest_run_mm(const Index3& voxel, LabelImage::Index label, double limit_mm) const {
  const ImageFrame& frame = image_.frame();
  double shortest_mm = limit_mm;
  for (int axis = 0; axis < 3; ++axis) {
    double run_mm = frame.spacing_mm[axis];
    for (const int d : {-1, 1}) {
      Index3 at = voxel + d * Index3::Unit(axis);
      while (run_mm < shortest_mm && frame.contains(at) && image_.at(at) == label) {
        run_mm += frame.spacing_mm[axis];
        at[axis] += d;
      }
      if (!frame.contains(at)) run_mm = limit_mm;  // goes on beyond the border
    }
    shortest_mm = std::min(shortest_mm, run_mm);
  }
  return shortest_mm;
}

IndexBox SizeGrid::cells_around(const Vec3& point_mm, double radius_mm) const {
  const Vec3 centre = image_.frame().to_index(point_mm);
  const Vec3 radius = radius_mm * image_.frame().spacing_mm.cwiseInverse();
  return cells_between(centre - radius, centre + radius);
}

IndexBox SizeGrid::cells_between(const Vec3& low, const Vec3& high) const {
  IndexBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cell = [&](double at) {
      return std::clamp(static_cast<int>(std::floor(at / kCell)), 0, cells_[axis] - 1);
    };
    box.low[axis] = cell(low[axis]);
    box.high[axis] = cell(high[axis]);
  }
  return box;
}

template <class IsFound>
bool SizeGrid::any_cell(const IndexBox& box, const IsFound& is_found) const {
  for (int k = box.low.z(); k <= box.high.z(); ++k)
    for (int j = box.low.y(); j <= box.high.y(); ++j) {
      const std::uint8_t* const row = &wanted_[cell_number({0, j, k})];
      if (std::any_of(row + box.low.x(), row + box.high.x() + 1, is_found)) return true;
    }
  return false;
}

int SizeGrid::level_wanted(const Vec3& point_mm, double radius_mm) const {
  std::uint8_t most = 0;
  any_cell(cells_around(point_mm, radius_mm), [&](std::uint8_t cell) {
    most = std::max(most, cell);
    return false;
  });
  return static_cast<int>(most) - 1;
}

bool SizeGrid::boundary_within(const Vec3& point_mm, double radius_mm) const {
  // The grid knows the voxels at boundaries; the domain's boundary is hardly ever more than one farther out.
  return any_cell(cells_around(point_mm, radius_mm + image_.frame().spacing_mm.minCoeff()),
                  [](std::uint8_t cell) { return cell != 0; });
}

double SizeGrid::boundary_spacing_mm(const LabelImage& image, const ImageDomain& domain,
                                     const LatticeOptions& options) {
  const double usual_mm = options.spacing_mm > 0 ? options.spacing_mm : kUsualEdge * domain.voxel_size_mm();
  if (!(options.cells_per_diameter > 0)) return usual_mm;
  const SizeGrid sizes(image, domain, options, usual_mm * std::exp2(options.coarsening));
  const auto wanted = parallel::reduce(
      brick_count(image), 16, WantedSpacings{},
      [&](WantedSpacings& all, std::size_t b) {
        for_each_voxel_near_boundary(image, domain.field(), b, [&](const Index3& voxel) {
          if (image.at(voxel) == 0) return;
          const std::optional<double> allowed = sizes.allowed_mm(voxel);
          if (allowed) all.add(std::log2(usual_mm * kSlack / std::min(*allowed, usual_mm * kSlack)));
        });
      },
      [](WantedSpacings a, const WantedSpacings& b) {
        for (std::size_t i = 0; i < a.counts.size(); ++i) a.counts[i] += b.counts[i];
        return a;
      });
  return usual_mm / std::exp2(wanted.best_shift(options.max_refinement));
}

}  // namespace lumesh
