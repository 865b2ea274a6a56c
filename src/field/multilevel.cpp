#include "multilevel.hpp"

#include <cmath>

#include "lumesh/core/wide.hpp"
#include "lumesh/parallel/loops.hpp"
#include "segment_loops.hpp"

namespace lumesh::field {

namespace {

/// Weight of each of the six splines beside one in its energy. Where a stiff part has no more than the rim
/// of a spline, its derivatives there are not as small as its values are, by which the energy alone would be
/// too small by orders of magnitude: solves would take twice the iterations and more.
constexpr float kNeighbourShare = 0.05F;
/// Splines of a smaller share of a whole one's energy are left out. What they would correct costs next to
/// nothing, as the lean of a line of one voxel does, and rounding would decide on it.
constexpr float kLeastShare = 0.0002F;
/// Weight of single voxels' terms in a spline's energy: its own values squared (0.23), and some of its
/// neighbours'.
constexpr float kMass = 0.4F;

/// Nodes of a coarse grid whose splines reach a fine node.
struct NodeRange {
  int first = 0, last = 0;
};
NodeRange nodes_over(int fine) {
  return fine % 2 != 0 ? NodeRange{(fine + 1) / 2, (fine + 1) / 2 + 1} : NodeRange{fine / 2, fine / 2 + 2};
}

/// Weights 1 4 6 4 1 (over 8) of the nodes around every second one of 24 in a row.
[[gnu::always_inline]] inline Lanes restrict_row(const Lanes& a, const Lanes& b, const Lanes& c) {
  const Lanes even_ab = __builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14);
  const Lanes even_bc = __builtin_shufflevector(b, c, 0, 2, 4, 6, 8, 10, 12, 14);
  const Lanes odd_ab = __builtin_shufflevector(a, b, 1, 3, 5, 7, 9, 11, 13, 15);
  const Lanes odd_bc = __builtin_shufflevector(b, c, 1, 3, 5, 7, 9, 11, 13, 15);
  const Lanes centre = __builtin_shufflevector(even_ab, even_bc, 3, 8, 9, 10, 11, 12, 13, 14);
  const Lanes before2 = __builtin_shufflevector(even_ab, even_bc, 2, 3, 8, 9, 10, 11, 12, 13);
  const Lanes before = __builtin_shufflevector(odd_ab, odd_bc, 2, 3, 8, 9, 10, 11, 12, 13);
  const Lanes after = __builtin_shufflevector(odd_ab, odd_bc, 3, 8, 9, 10, 11, 12, 13, 14);
  return 0.75F * centre + (0.5F * (before + after) + 0.125F * (before2 + even_bc));
}

/// The sum of both neighbours along x of the nodes of a segment, given with the segments before and after.
[[gnu::always_inline]] inline Lanes beside_along_x(const Lanes& before, const Lanes& own,
                                                   const Lanes& after) {
  return __builtin_shufflevector(before, own, 7, 8, 9, 10, 11, 12, 13, 14) +
         __builtin_shufflevector(own, after, 1, 2, 3, 4, 5, 6, 7, 8);
}

[[gnu::always_inline]] inline Lanes weigh_five(const std::int32_t* segments, int stride,
                                               const LaneArray& values) {
  const auto at = [&](int i) __attribute__((always_inline)) {
    return load(values.at(segments[i * stride]));
  };
  return 0.75F * at(2) + (0.5F * (at(1) + at(3)) + 0.125F * (at(0) + at(4)));
}

}  // namespace

/// The loops over segments of a transfer, compiled for wide vectors too.
struct TransferLoops {
  static LUMESH_WIDE_LOOPS void along_x(Transfer& t, const LaneArray& fine, int begin, int end) {
    for (int s = begin; s < end; ++s) {
      const auto& from = t.source_[static_cast<std::size_t>(s)];
      store(t.half_way_.at(s),
            restrict_row(load(fine.at(from[0])), load(fine.at(from[1])), load(fine.at(from[2]))));
    }
  }
  static LUMESH_WIDE_LOOPS void along_y_and_z(const Transfer& t, LaneArray& coarse, int begin, int end) {
    for (int s = begin; s < end; ++s) {
      const std::int32_t* const from = t.gather_[static_cast<std::size_t>(s)].data();
      std::array<Lanes, 5> rows;
      for (int z = 0; z < 5; ++z)
        rows[static_cast<std::size_t>(z)] = weigh_five(from + 5 * z, 1, t.half_way_);
      store(coarse.at(s), 0.75F * rows[2] + (0.5F * (rows[1] + rows[3]) + 0.125F * (rows[0] + rows[4])));
    }
  }
  static LUMESH_WIDE_LOOPS void spread(Transfer& t, const LaneArray& coarse, int begin, int end) {
    for (int s = begin; s < end; ++s) {
      const auto& from = t.spread_[static_cast<std::size_t>(s)];
      const auto at = [&](std::size_t n) __attribute__((always_inline)) {
        return load(coarse.at(from[n]));
      };
      const auto three = [&](std::size_t n) __attribute__((always_inline)) {
        return 0.75F * at(n + 1) + 0.125F * (at(n) + at(n + 2));
      };
      const auto two = [&](std::size_t n) __attribute__((always_inline)) {
        return 0.5F * (at(n) + at(n + 1));
      };
      Lanes v;
      switch (t.parity_[static_cast<std::size_t>(s)]) {
        case 0:
          v = 0.75F * three(3) + 0.125F * (three(0) + three(6));
          break;
        case 1:
          v = 0.75F * two(2) + 0.125F * (two(0) + two(4));
          break;
        case 2:
          v = 0.5F * (three(0) + three(3));
          break;
        default:
          v = 0.5F * (two(0) + two(2));
      }
      store(t.half_way_.at(s), v);
    }
  }
};

namespace {

/// correction = inverse * residual; returns their product summed.
LUMESH_WIDE_LOOPS double scale_block(const LaneArray& residual, const LaneArray& inverse,
                                     LaneArray& correction, int begin, int end) {
  Lanes total = {};
  for (int s = begin; s < end; ++s) {
    const Lanes r = load(residual.at(s)), z = r * load(inverse.at(s));
    store(correction.at(s), z);
    total += r * z;
  }
  return static_cast<double>(sum(total));
}

/// inverse = 1 / energies of splines, from the sums of the diagonal and of the weights of single voxels over
/// them. @param energy  For each unit of the diagonal's. @param least  Of these; 0 where they are less.
LUMESH_WIDE_LOOPS void invert_energy(const std::vector<std::array<std::int32_t, 6>>& beside, float energy,
                                     float least, const LaneArray& diagonal, const LaneArray& mass, int begin,
                                     int end, LaneArray& inverse) {
  for (int s = begin; s < end; ++s) {
    const auto& segments = beside[static_cast<std::size_t>(s)];
    const auto at = [&](std::size_t n) __attribute__((always_inline)) {
      return load(diagonal.at(segments[n]));
    };
    const Lanes own = load(diagonal.at(s));
    const Lanes around = beside_along_x(at(0), own, at(1)) + ((at(2) + at(3)) + (at(4) + at(5)));
    const Lanes seen = (own + kNeighbourShare * around) * (1 / (1 + 6 * kNeighbourShare));
    const Lanes weight = energy * seen + kMass * load(mass.at(s)) + 1e-12F;
    store(inverse.at(s), keep(1.0F / weight, own > Lanes{} + least));
  }
}

LUMESH_WIDE_LOOPS void add_fine(const Transfer& t, LaneArray& fine, int begin, int end) {
  for (int s = begin; s < end; ++s) {
    add_to(fine.at(s), t.load_fine(s));
  }
}

LUMESH_WIDE_LOOPS void copy_alive(const std::vector<std::uint8_t>& alive, const Transfer& t, LaneArray& out,
                                  int begin, int end) {
  for (int s = begin; s < end; ++s) {
    store(out.at(s), keep(t.load_fine(s), mask_of(alive[static_cast<std::size_t>(s)])));
  }
}

}  // namespace

Transfer::Transfer(const SegmentGrid& fine) {
  const int nodes_x = fine.size_x() * kLanes / 2 + 3;
  along_x_ = SegmentGrid((nodes_x + kLanes - 1) / kLanes, fine.size_y(), fine.size_z());
  for (int s = 1; s < fine.end(); ++s) {
    if (!fine.exists(s)) continue;
    const SegmentPlace& p = fine.place(s);
    const int first = 4 * p.x / kLanes, last = (4 * p.x + 5) / kLanes;
    along_x_.insert({first, p.y, p.z});
    if (last != first && last < along_x_.size_x()) along_x_.insert({last, p.y, p.z});
  }
  along_x_.number();
  half_way_.assign(along_x_.end(), 0);
  find_nodes();
  find_sources(fine);
}

void Transfer::find_nodes() {
  coarse_ = SegmentGrid(along_x_.size_x(), along_x_.size_y() / 2 + 3, along_x_.size_z() / 2 + 3);
  for (int s = 1; s < along_x_.end(); ++s) {
    const SegmentPlace& p = along_x_.place(s);
    const NodeRange y = nodes_over(p.y), z = nodes_over(p.z);
    for (int k = z.first; k <= z.last; ++k)
      for (int j = y.first; j <= y.last; ++j) coarse_.insert({p.x, j, k});
  }
  coarse_.number();
}

void Transfer::find_sources(const SegmentGrid& fine) {
  const auto half = static_cast<std::size_t>(along_x_.end());
  source_.assign(half, {}), spread_.assign(half, {}), parity_.assign(half, 0);
  parallel::for_each_index(half - 1, [&](std::size_t i) {
    const SegmentPlace& p = along_x_.place(static_cast<int>(i) + 1);
    for (int d = 0; d < 3; ++d)
      source_[i + 1][static_cast<std::size_t>(d)] = fine.find({2 * p.x - 1 + d, p.y, p.z});
    const NodeRange y = nodes_over(p.y), z = nodes_over(p.z);
    std::size_t n = 0;
    for (int k = z.first; k <= z.last; ++k)
      for (int j = y.first; j <= y.last; ++j) spread_[i + 1][n++] = coarse_.find({p.x, j, k});
    parity_[i + 1] = static_cast<std::uint8_t>(p.y % 2 + 2 * (p.z % 2));
  });
  gather_.assign(static_cast<std::size_t>(coarse_.end()), {});
  parallel::for_each_index(gather_.size() - 1, [&](std::size_t i) {
    const SegmentPlace& p = coarse_.place(static_cast<int>(i) + 1);
    for (int k = 0; k < 5; ++k)
      for (int j = 0; j < 5; ++j)
        gather_[i + 1][static_cast<std::size_t>(5 * k + j)] =
            along_x_.find({p.x, 2 * p.y - 4 + j, 2 * p.z - 4 + k});
  });
  offset_.assign(static_cast<std::size_t>(fine.end()), 0);
  for (int s = 1; s < fine.end(); ++s) {
    if (!fine.exists(s)) continue;
    const SegmentPlace& p = fine.place(s);
    offset_[static_cast<std::size_t>(s)] =
        kLanes * along_x_.find({4 * p.x / kLanes, p.y, p.z}) + 4 * p.x % kLanes;
  }
}

void Transfer::restrict_to_coarse(const LaneArray& fine, LaneArray& coarse) {
  for_each_segment_block(along_x_.end(),
                         [&](int begin, int end) { TransferLoops::along_x(*this, fine, begin, end); });
  for_each_segment_block(
      coarse_.end(), [&](int begin, int end) { TransferLoops::along_y_and_z(*this, coarse, begin, end); });
}

void Transfer::prolong(const LaneArray& coarse) {
  for_each_segment_block(along_x_.end(),
                         [&](int begin, int end) { TransferLoops::spread(*this, coarse, begin, end); });
}

Multilevel::Level::Level(const SegmentGrid& fine)
    : transfer(fine),
      residual(transfer.coarse().end()),
      correction(transfer.coarse().end()),
      inverse(transfer.coarse().end()) {}

void Multilevel::Level::find_beside() {
  if (!beside.empty()) return;
  beside.resize(static_cast<std::size_t>(transfer.coarse().end()));
  const SegmentGrid& grid = transfer.coarse();
  parallel::for_each_index(beside.size() - 1, [&](std::size_t i) {
    const SegmentPlace& p = grid.place(static_cast<int>(i) + 1);
    beside[i + 1] = {grid.find({p.x - 1, p.y, p.z}), grid.find({p.x + 1, p.y, p.z}),
                     grid.find({p.x, p.y - 1, p.z}), grid.find({p.x, p.y + 1, p.z}),
                     grid.find({p.x, p.y, p.z - 1}), grid.find({p.x, p.y, p.z + 1})};
  });
}

Multilevel::Multilevel(const SegmentGrid& grid, const std::vector<std::uint8_t>& alive, int levels)
    : alive_(alive) {
  levels_.reserve(static_cast<std::size_t>(levels));
  for (int l = 0; l < levels; ++l) levels_.emplace_back(l == 0 ? grid : levels_.back().transfer.coarse());
}

void Multilevel::set_energy(const LaneArray& diagonal, float whole, const LaneArray& mass, double third,
                            double second, const Vec3& edges) {
  // Integrals of the squares of a cubic B-spline and of its first three derivatives.
  constexpr double kValue = 0.4794, kSlope = 2.0 / 3, kBend = 8.0 / 3, kTwist = 20;
  const Vec3 i = edges.cwiseProduct(edges).cwiseInverse();
  double cubes = 0, mixed = 0, squares = 0, products = 0;
  for (int a = 0; a < 3; ++a) {
    cubes += i[a] * i[a] * i[a];
    squares += i[a] * i[a];
    products += i[a] * i[(a + 1) % 3];
    for (int b = 0; b < 3; ++b) mixed += a == b ? 0 : i[a] * i[a] * i[b];
  }
  const double volume = edges.prod();
  const double of_third = third * volume *
                          (cubes * kTwist * kValue * kValue + 3 * mixed * kBend * kSlope * kValue +
                           6 * i.prod() * kSlope * kSlope * kSlope);
  const double of_second =
      second * volume * (squares * kBend * kValue * kValue + 2 * products * kSlope * kSlope * kValue);
  for (int l = 0; l < kLevels; ++l) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    const Level* const finer = l == 0 ? nullptr : &levels_[static_cast<std::size_t>(l - 1)];
    level.transfer.restrict_to_coarse(finer == nullptr ? mass : finer->residual, level.residual);
    level.transfer.restrict_to_coarse(finer == nullptr ? diagonal : finer->correction, level.correction);
    level.find_beside();
    const double spacing = std::exp2(l + 1);
    const double whole_spline = static_cast<double>(whole) * std::pow(spacing, 3);  // What it sums up to.
    const auto energy =
        static_cast<float>((of_third / std::pow(spacing, 3) + of_second / spacing) / whole_spline);
    const float least = kLeastShare * static_cast<float>(whole_spline);
    for_each_segment_block(level.transfer.coarse().end(), [&](int begin, int end) {
      invert_energy(level.beside, energy, least, level.correction, level.residual, begin, end, level.inverse);
    });
  }
}

double Multilevel::precondition(const LaneArray& residual) {
  double product = 0;
  for (int l = 0; l < kLevels; ++l) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    level.transfer.restrict_to_coarse(l == 0 ? residual : levels_[static_cast<std::size_t>(l - 1)].residual,
                                      level.residual);
    product += sum_over_segment_blocks(level.transfer.coarse().end(), [&](int begin, int end) {
      return scale_block(level.residual, level.inverse, level.correction, begin, end);
    });
  }
  for (int l = kLevels - 1; l >= 0; --l) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    level.transfer.prolong(level.correction);
    if (l == 0) break;
    LaneArray& finer = levels_[static_cast<std::size_t>(l - 1)].correction;
    for_each_segment_block(levels_[static_cast<std::size_t>(l - 1)].transfer.coarse().end(),
                           [&](int begin, int end) { add_fine(level.transfer, finer, begin, end); });
  }
  return product;
}

void Multilevel::smooth(const LaneArray& values, int levels, LaneArray& out) {
  for (int l = 0; l < levels; ++l) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    level.transfer.restrict_to_coarse(l == 0 ? values : levels_[static_cast<std::size_t>(l - 1)].residual,
                                      level.residual);
  }
  for (int l = levels - 1; l >= 0; --l) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    level.transfer.prolong(level.residual);
    LaneArray& finer = l == 0 ? out : levels_[static_cast<std::size_t>(l - 1)].residual;
    for_each_segment_block(l == 0 ? static_cast<int>(alive_.size())
                                  : levels_[static_cast<std::size_t>(l - 1)].transfer.coarse().end(),
                           [&](int begin, int end) {
                             if (l == 0) {
                               copy_alive(alive_, level.transfer, finer, begin, end);
                               return;
                             }
                             for (int s = begin; s < end; ++s)
                               store(finer.at(s), level.transfer.load_fine(s));
                           });
  }
}

void Multilevel::sum_over_window(const LaneArray& values, Window window, LaneArray& sums) {
  // Down and up again adds up the splines' variances: 2 voxels^2 for one level, 10 for two, 42 for three.
  smooth(values, 1 + static_cast<int>(window), sums);
  if (window == Window::kNarrow) smooth(sums, 1, sums);
}

}  // namespace lumesh::field
