#include "lumen.hpp"

#include <cmath>
#include <iterator>
#include <utility>

#include "lumesh/core/grid.hpp"

namespace lumesh::centerline {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Lower envelope of parabolas with the curvature of squared distances (Felzenszwalb and Huttenlocher 2012,
/// doi:10.4086/toc.2012.v008a019), which come from left to right: those of height f at p and q meet at
/// ((f(q) + q^2) - (f(p) + p^2)) / (2 (q - p)).
class Envelope {
 public:
  void clear() { arcs_.clear(); }
  void add(double at, double height) {
    if (height == kInfinite) return;
    double from = -kInfinite;
    while (!arcs_.empty()) {
      const Arc& last = arcs_.back();
      from = ((height + at * at) - (last.height + last.at * last.at)) / (2 * (at - last.at));
      if (from > last.from) break;
      arcs_.pop_back();
      from = -kInfinite;
    }
    arcs_.push_back({at, height, from});
  }
  /// For places from left to right, `hint` being 0 at first.
  [[nodiscard]] double value(double at, std::size_t& hint) const {
    if (arcs_.empty()) return kInfinite;
    while (hint + 1 < arcs_.size() && arcs_[hint + 1].from <= at) ++hint;
    return arcs_[hint].height + (at - arcs_[hint].at) * (at - arcs_[hint].at);
  }

 private:
  struct Arc {
    double at, height, from;
  };
  std::vector<Arc> arcs_;
};

}  // namespace

Lumen::Lumen(const ImageFrame& frame, std::vector<Index3> voxels, const std::vector<Index3>& beyond)
    : frame_(frame), voxels_(std::move(voxels)) {
  voxel_mm_ = std::cbrt(frame.voxel_volume_mm3());
  if (voxels_.empty()) return;
  make_bricks(beyond);
  number();
  keep_largest_piece();
  if (beyond.empty()) {
    mark_inside();
    measure_walls();
  } else {
    measure_walls_with(beyond);
  }
}

/// For a while the voxels beyond are of the lumen.
void Lumen::measure_walls_with(const std::vector<Index3>& beyond) {
  const std::vector<Index3> own = std::move(voxels_);
  voxels_.clear();
  std::merge(own.begin(), own.end(), beyond.begin(), beyond.end(), std::back_inserter(voxels_),
             MemoryOrder{frame_});
  number();
  mark_inside();
  measure_walls();
  for (std::size_t id = 0; id < own.size(); ++id) wall_mm_[id] = wall_mm_[find(own[id])];
  wall_mm_.resize(own.size());
  voxels_ = own;
  number();
}

void Lumen::make_bricks(const std::vector<Index3>& beyond) {
  Index3 high = voxels_.front();
  low_ = high;
  for (const std::vector<Index3>* some : {&std::as_const(voxels_), &beyond}) {
    for (const Index3& v : *some) {
      low_ = low_.cwiseMin(v);
      high = high.cwiseMax(v);
    }
  }
  low_ -= Index3::Ones();
  bricks_ = ((high - low_).array() + 2 + kBrick - 1) / kBrick;
  brick_of_.assign(grid_count(bricks_), -1);
  // Bricks of the neighbours, too: their shares of the inside may be refined.
  std::vector<std::uint8_t> wanted(brick_of_.size(), 0);
  for (const std::vector<Index3>* some : {&std::as_const(voxels_), &beyond}) {
    parallel::for_each_index(some->size(), [&](std::size_t n) {
      for (int corner = 0; corner < 8; ++corner) {
        const Index3 side((corner & 1) * 2 - 1, (corner >> 1 & 1) * 2 - 1, (corner >> 2 & 1) * 2 - 1);
        parallel::raise(wanted[brick_offset((*some)[n] + side - low_)]);
      }
    });
  }
  std::int32_t count = 0;
  for (std::size_t b = 0; b < wanted.size(); ++b)
    if (wanted[b] != 0) brick_of_[b] = count++;
  stored_.resize(static_cast<std::size_t>(count));
  parallel::for_each_index(brick_of_.size(), [&](std::size_t b) {
    if (brick_of_[b] < 0) return;
    stored_[static_cast<std::size_t>(brick_of_[b])].low = low_ + kBrick * grid_place(bricks_, b);
  });
}

void Lumen::number() {
  parallel::for_each_index(stored_.size(), 16, [&](std::size_t b) { stored_[b].ids.fill(kNoVoxel); });
  parallel::for_each_index(voxels_.size(), [&](std::size_t id) {
    const Index3& v = voxels_[id];
    Brick& brick = stored_[static_cast<std::size_t>(brick_of_[brick_offset(v - low_)])];
    brick.ids[cell(v)] = static_cast<std::uint32_t>(id);
  });
}

void Lumen::mark_inside() {
  parallel::for_each_index(stored_.size(), 16, [&](std::size_t b) {
    Brick& brick = stored_[b];
    for (std::size_t c = 0; c < kCells; ++c)
      brick.shares[c] = static_cast<std::uint8_t>(brick.ids[c] == kNoVoxel ? 0 : kWhole);
  });
}

void Lumen::keep_largest_piece() {
  std::vector<std::uint32_t> piece(voxels_.size(), kNoVoxel);
  std::vector<std::uint32_t> queue;
  std::uint32_t largest = 0;
  std::size_t largest_size = 0;
  std::uint32_t pieces = 0;
  for (std::uint32_t seed = 0; seed < voxels_.size(); ++seed) {
    if (piece[seed] != kNoVoxel) continue;
    queue.assign(1, seed);
    piece[seed] = pieces;
    for (std::size_t at = 0; at < queue.size(); ++at) {
      for (int a = 0; a < 6; ++a) {
        const std::uint32_t next = find(voxels_[queue[at]] + (a % 2 == 0 ? 1 : -1) * Index3::Unit(a / 2));
        if (next == kNoVoxel || piece[next] != kNoVoxel) continue;
        piece[next] = pieces;
        queue.push_back(next);
      }
    }
    if (queue.size() > largest_size) {
      largest = pieces;
      largest_size = queue.size();
    }
    ++pieces;
  }
  left_out_ = voxels_.size() - largest_size;
  if (left_out_ == 0) return;
  std::size_t kept = 0;
  for (std::size_t id = 0; id < voxels_.size(); ++id)
    if (piece[id] == largest) voxels_[kept++] = voxels_[id];
  voxels_.resize(kept);
  number();
}

void Lumen::measure_walls() {
  std::vector<double> squared(voxels_.size(), kInfinite);
  for (int axis = 0; axis < 3; ++axis) pass_along(axis, squared);
  wall_mm_.resize(voxels_.size());
  for (std::size_t id = 0; id < voxels_.size(); ++id)
    wall_mm_[id] = static_cast<float>(std::sqrt(squared[id]));
}

/// Within each run of voxels along the axis only those of the run and the first ones outside of it can be
/// nearest: whatever lies beyond is farther than these.
void Lumen::pass_along(int axis, std::vector<double>& squared) const {
  const Index3 step = Index3::Unit(axis);
  const double mm = frame_.spacing_mm[axis];
  parallel::for_each_block(voxels_.size(), 4096, [&](std::size_t, std::size_t begin, std::size_t end) {
    Envelope envelope;
    std::vector<std::uint32_t> run;
    for (std::size_t id = begin; id < end; ++id) {
      const Index3 before = voxels_[id] - step;
      if (find(before) != kNoVoxel) continue;
      run.clear();
      Index3 v = voxels_[id];
      for (std::uint32_t next = static_cast<std::uint32_t>(id); next != kNoVoxel; next = find(v)) {
        run.push_back(next);
        v += step;
      }
      envelope.clear();
      if (frame_.contains(before)) envelope.add(-mm, 0);
      for (std::size_t n = 0; n < run.size(); ++n) envelope.add(static_cast<double>(n) * mm, squared[run[n]]);
      if (frame_.contains(v)) envelope.add(static_cast<double>(run.size()) * mm, 0);
      std::size_t hint = 0;
      for (std::size_t n = 0; n < run.size(); ++n)
        squared[run[n]] = envelope.value(static_cast<double>(n) * mm, hint);
    }
  });
}

std::array<std::uint32_t, 27> Lumen::around(std::uint32_t id) const {
  std::array<std::uint32_t, 27> ids;
  const auto fill = [&](const auto& id_at) {
    std::size_t n = 0;
    for (int k = -1; k <= 1; ++k)
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) ids[n++] = id_at(i, j, k);
  };
  const Index3& v = voxels_[id];
  const Index3 at = v - low_;
  const auto is_within = [](int x) { return x % kBrick != 0 && x % kBrick != kBrick - 1; };
  if (is_within(at.x()) && is_within(at.y()) && is_within(at.z())) {
    const std::uint32_t* own = brick_at(v)->ids.data() + cell(v);
    fill([&](int i, int j, int k) { return own[i + kBrick * (j + kBrick * k)]; });
  } else {
    fill([&](int i, int j, int k) { return find(v + Index3(i, j, k)); });
  }
  return ids;
}

std::uint32_t Lumen::voxel_around(const Vec3& position) const {
  const Index3 v = position.cwiseQuotient(frame_.spacing_mm).array().round().cast<int>();
  return find(nearest_place(frame_.size, v));
}

double Lumen::inside(const Vec3& position) const {
  const Vec3 index = position.cwiseQuotient(frame_.spacing_mm);
  const Vec3 floor = index.array().floor();
  const Index3 base = floor.cast<int>();
  const Vec3 t = index - floor;
  std::array<double, 8> shares;
  const Index3 at = base - low_;
  const auto is_low = [](int x) { return x % kBrick != kBrick - 1; };
  const bool in_frame =
      (base.array() >= 0).all() && (base.array() + 1 < frame_.size.array()).all() && (at.array() >= 0).all();
  if (in_frame && is_low(at.x()) && is_low(at.y()) && is_low(at.z())) {
    const Brick* brick = brick_at(base);
    if (brick == nullptr) return 0;
    const std::uint8_t* own = brick->shares.data() + cell(base);
    for (std::size_t corner = 0; corner < 8; ++corner)
      shares[corner] = own[(corner & 1) + kBrick * ((corner >> 1 & 1) + kBrick * (corner >> 2 & 1))];
  } else {
    for (int corner = 0; corner < 8; ++corner)
      shares[static_cast<std::size_t>(corner)] =
          share_at(base + Index3(corner & 1, corner >> 1 & 1, corner >> 2 & 1));
  }
  const auto mix = [](double a, double b, double share) { return a + share * (b - a); };
  const double low = mix(mix(shares[0], shares[1], t.x()), mix(shares[2], shares[3], t.x()), t.y());
  const double high = mix(mix(shares[4], shares[5], t.x()), mix(shares[6], shares[7], t.x()), t.y());
  return mix(low, high, t.z()) / kWhole;
}

double Lumen::ray(const Vec3& from, const Vec3& direction, double max_mm) const {
  const double fine = 0.5 * frame_.spacing_mm.minCoeff();
  const double slack = 1.5 * frame_.spacing_mm.maxCoeff();
  double at = 0;
  double before = inside(from);
  if (before < 0.5) return 0;
  while (at < max_mm) {
    const std::uint32_t id = voxel_around(from + at * direction);
    const double clear = id == kNoVoxel ? 0.0 : std::min(wall_mm_[id] - slack, max_mm);
    const double step = std::max(fine, clear);
    const double value = inside(from + (at + step) * direction);
    if (value < 0.5) return std::min(max_mm, at + step * (before - 0.5) / (before - value));
    before = value;
    at += step;
  }
  return max_mm;
}

double Lumen::ray_by_area(const Vec3& from, const Vec3& direction, double max_mm) const {
  const double wall = ray(from, direction, max_mm);
  if (refined_ || wall >= max_mm || wall == 0) return wall;
  // The area of a sector is the integral of its share over the square of the radius; interpolation keeps it.
  const double step = 0.25 * frame_.spacing_mm.minCoeff();
  const double first = std::max(0.0, wall - 1.75 * frame_.spacing_mm.maxCoeff());
  double squared = first * first;
  double before = 1;
  for (double at = first; at < max_mm; at += step) {
    const double share = inside(from + (at + 0.5 * step) * direction);
    if (share <= 0 || (at > wall && share > before)) break;  // What comes next is another vessel.
    squared += share * ((at + step) * (at + step) - at * at);
    before = share;
  }
  return std::min(std::sqrt(squared), max_mm);
}

}  // namespace lumesh::centerline
