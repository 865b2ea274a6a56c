// Handles and cavities that differ, by warping (Jain et al. 2010, doi:10.1109/CVPR.2010.5539950).
#include <algorithm>
#include <array>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/image/simple_point.hpp"
#include "pieces.hpp"
#include "rows_of_tetrahedron.hpp"

namespace lumesh::quality {

namespace {

constexpr std::array<int, 2> kPointsPerVoxel = {2, 4};  // Along each axis.
constexpr std::size_t kMaxClusters = 1000;              // More are noise: it is not looked at more closely.
constexpr std::size_t kMaxBricks = std::size_t{1} << 26;
constexpr std::size_t kMaxPoints = std::size_t{1} << 27;

/// Points of a grid in bricks of 16^3 that exist where something was set. Each has bits and a number.
class PointGrid {
 public:
  static constexpr int kEdge = 16;
  enum Bit : std::uint8_t { kHas = 1, kWanted = 2, kWaits = 4, kSeen = 8 };

  PointGrid() = default;
  /// Points from low, with it, to high, without it.
  PointGrid(const Index3& low, const Index3& high) : low_(low) {
    bricks_ = ((high - low).array() + kEdge - 1) / kEdge;
    const Vec3 bricks = bricks_.cast<double>();
    fits_ = bricks.prod() < static_cast<double>(kMaxBricks);
    if (fits_) brick_of_.assign(static_cast<std::size_t>(bricks_.prod()), 0);
    points_.resize(kBrick);  // The first one is where nothing is.
  }

  [[nodiscard]] bool fits() const { return fits_ && points_.size() < kMaxPoints; }
  /// Number of the point; makes its brick.
  std::size_t made(const Index3& p) {
    std::uint32_t& brick = brick_of_[brick_at(p)];
    if (brick == 0) {
      brick = static_cast<std::uint32_t>(points_.size() / kBrick);
      points_.resize(points_.size() + kBrick, 0);
    }
    return brick * kBrick + within(p);
  }
  /// Number of the point; less than kBrick where there is none.
  [[nodiscard]] std::size_t at(const Index3& p) const {
    const Index3 v = p - low_;
    if ((v.array() < 0).any() || (v.array() >= bricks_.array() * kEdge).any()) return 0;
    return brick_of_[brick_at(p)] * kBrick + within(p);
  }
  [[nodiscard]] bool has(const Index3& p, Bit bit) const { return (points_[at(p)] & bit) != 0; }
  [[nodiscard]] std::uint8_t& bits(std::size_t number) { return points_[number]; }
  /// Which of the 27 points around have the bit, as is_simple_point() takes them.
  [[nodiscard]] std::uint32_t around(const Index3& p, Bit bit) const {
    const Index3 v = p - low_;
    const auto is_inside = [](int x) { return x % kEdge >= 1 && x % kEdge < kEdge - 1; };
    std::uint32_t set = 0;
    if (is_inside(v.x()) && is_inside(v.y()) && is_inside(v.z())) {
      const std::uint8_t* first = points_.data() + at(p) - (1 + kEdge + kEdge * kEdge);
      for (int n = 0; n < 27; ++n)
        set |= static_cast<std::uint32_t>(
                   (first[n % 3 + kEdge * (n / 3 % 3) + kEdge * kEdge * (n / 9)] & bit) != 0)
               << n;
      return set;
    }
    for (int n = 0; n < 27; ++n) set |= static_cast<std::uint32_t>(has(p + neighbour_step(n), bit)) << n;
    return set;
  }
  [[nodiscard]] std::size_t size() const { return points_.size(); }

  /// Calls use(point, number) for all points of all bricks, by place.
  template <class Use>
  void for_each(const Use& use) const {
    for (std::size_t b = 0; b < brick_of_.size(); ++b) {
      if (brick_of_[b] == 0) continue;
      const Index3 first = low_ + kEdge * grid_place(bricks_, b);
      for (std::size_t i = 0; i < kBrick; ++i) {
        const auto at = static_cast<int>(i);
        use(first + Index3(at % kEdge, at / kEdge % kEdge, at / kEdge / kEdge), brick_of_[b] * kBrick + i);
      }
    }
  }

 private:
  static constexpr std::size_t kBrick = std::size_t{kEdge} * kEdge * kEdge;
  [[nodiscard]] std::size_t brick_at(const Index3& p) const {
    return grid_offset(bricks_, (p - low_) / kEdge);
  }
  [[nodiscard]] std::size_t within(const Index3& p) const { return offset_in_brick(p - low_, kEdge); }

  Index3 low_ = Index3::Zero(), bricks_ = Index3::Zero();
  bool fits_ = false;
  std::vector<std::uint32_t> brick_of_;
  std::vector<std::uint8_t> points_;
};

constexpr std::array<std::array<int, 3>, 6> kBeside = {
    {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

/// Points next to each other that differ in the same way.
struct Cluster {
  bool is_filled = false;  // The mesh is there, and the voxels are not.
  std::vector<Index3> points;
  std::int64_t euler = 0;      // What they change.
  std::int64_t of_pieces = 0;  // What of that is that pieces join, part, come or go.
};

class Warping {
 public:
  Warping(const MeshView& mesh, const LabelImage& image, const TopologyDifference& difference,
          int points_per_voxel)
      : mesh_(mesh), image_(image), difference_(difference), n_(points_per_voxel) {}

  /// False if there are too many points.
  bool run() {
    if (!set_points()) return false;
    warp();
    find_clusters();
    number_pieces(PointGrid::kHas);
    count_pieces(true);
    for (Cluster& cluster : clusters_)
      for (const Index3& p : cluster.points) cluster.euler += flip(p);
    number_pieces(PointGrid::kWanted);
    count_pieces(false);
    return true;
  }
  /// Whether all that differs has been found.
  [[nodiscard]] bool is_complete() const {
    std::int64_t sum = 0;
    for (const Cluster& cluster : clusters_) sum += cluster.euler;
    return sum == difference_.euler;
  }
  [[nodiscard]] std::size_t cluster_count() const { return clusters_.size(); }
  [[nodiscard]] std::vector<TopologyPlace> places() const {
    std::vector<TopologyPlace> result;
    for (const Cluster& cluster : clusters_)
      if (cluster.euler != cluster.of_pieces) result.push_back(place_of(cluster));
    return result;
  }

 private:
  /// Points of a voxel v along an axis: from n v to n v + n - 1, with v in their middle.
  bool set_points() {
    std::vector<Vec3> points(mesh_.points.size());
    for (std::size_t v = 0; v < points.size(); ++v)
      points[v] = (image_.frame().to_index(mesh_.points[v]) + Vec3::Constant(0.5)) * n_ - Vec3::Constant(0.5);
    const AllCells cells(mesh_);
    const VoxelBox box = box_of_label();
    Vec3 low = box.low.cast<double>() * n_, high = box.high.cast<double>() * n_;
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
      if (cells.label(cell) != difference_.label) continue;
      for (const Cell<3>& triangle : cells.triangles(cell))
        for (const std::uint32_t v : triangle) {
          low = low.cwiseMin(points[v]);
          high = high.cwiseMax(points[v]);
        }
    }
    if (!((high - low).maxCoeff() < 1e8)) return false;  // The mesh is not of this image.
    grid_ = PointGrid((low.array().floor() - 2).cast<int>(), (high.array().ceil() + 3).cast<int>());
    if (!grid_.fits()) return false;
    set_voxels(box);
    for (std::size_t cell = 0; cell < cells.size() && grid_.fits(); ++cell)
      if (cells.label(cell) == difference_.label)
        for_each_tetrahedron(mesh_, cells, cell, points, [&](const RowsOfTetrahedron& rows) {
          for (int k = rows.first(2); k <= rows.last(2); ++k)
            for (int j = rows.first(1); j <= rows.last(1); ++j) {
              const image::Run held = rows.in_row(j, k);
              for (int i = held.begin; i < held.end; ++i) raise(grid_.made({i, j, k}), PointGrid::kWanted);
            }
        });
    return grid_.fits();
  }

  [[nodiscard]] VoxelBox box_of_label() const {
    VoxelBox box = VoxelBox::nothing();
    const image::RunImage runs = image::find_runs(image_, image::RunLabels::kEach);
    image::for_each_run(runs, [&](std::uint32_t r, int j, int k) {
      const image::Run& run = runs.runs[r];
      if (image_.values()[run.label] == difference_.label)
        box.add({run.begin, j, k}, {run.end, j + 1, k + 1});
    });
    return box;
  }

  void set_voxels(const VoxelBox& box) {
    for_each_place(box.low, box.high - Index3::Ones(), [&](const Index3& v) {
      if (image_.label_at(v) != difference_.label) return;
      for (int m = 0; m < n_ * n_ * n_; ++m)
        raise(grid_.made(n_ * v + Index3(m % n_, m / n_ % n_, m / n_ / n_)), PointGrid::kHas);
    });
  }

  void raise(std::size_t number, PointGrid::Bit bit) {
    grid_.bits(number) = static_cast<std::uint8_t>(grid_.bits(number) | bit);
  }
  void lower(std::size_t number, PointGrid::Bit bit) {
    grid_.bits(number) = static_cast<std::uint8_t>(grid_.bits(number) & ~bit);
  }
  [[nodiscard]] bool differs(const Index3& p) const {
    return grid_.has(p, PointGrid::kHas) != grid_.has(p, PointGrid::kWanted);
  }
  [[nodiscard]] std::uint32_t around(const Index3& p) const { return grid_.around(p, PointGrid::kHas); }

  /// Flips points that differ for as long as one of them is simple; in waves, so that what grows from two
  /// sides meets in the middle.
  void warp() {
    std::vector<Index3> wave;
    grid_.for_each([&](const Index3& p, std::size_t number) {
      if (!differs(p)) return;
      wave.push_back(p);
      raise(number, PointGrid::kWaits);
    });
    while (!wave.empty()) {
      // Those that may go before any of this wave does: none runs ahead of the others.
      std::erase_if(wave, [&](const Index3& p) {
        lower(grid_.at(p), PointGrid::kWaits);
        return !is_simple_point(around(p));
      });
      std::vector<Index3> next;
      for (const Index3& p : wave) {
        if (!is_simple_point(around(p))) continue;
        grid_.bits(grid_.at(p)) ^= PointGrid::kHas;
        for (int n = 0; n < 27; ++n) {
          const Index3 q = p + neighbour_step(n);
          if (!differs(q) || grid_.has(q, PointGrid::kWaits)) continue;
          raise(grid_.at(q), PointGrid::kWaits);
          next.push_back(q);
        }
      }
      // What was flipped after it had been entered has no further turn.
      std::erase_if(next, [&](const Index3& p) {
        if (differs(p)) return false;
        lower(grid_.at(p), PointGrid::kWaits);
        return true;
      });
      wave.swap(next);
    }
  }

  void find_clusters() {
    grid_.for_each([&](const Index3& first, std::size_t) {
      if (!differs(first) || grid_.has(first, PointGrid::kSeen)) return;
      Cluster cluster;
      cluster.is_filled = grid_.has(first, PointGrid::kWanted);
      cluster.points.push_back(first);
      raise(grid_.at(first), PointGrid::kSeen);
      for (std::size_t at = 0; at < cluster.points.size(); ++at)
        for (int n = 0; n < 27; ++n) {
          const Index3 q = cluster.points[at] + neighbour_step(n);
          if (!differs(q) || grid_.has(q, PointGrid::kSeen) ||
              grid_.has(q, PointGrid::kWanted) != cluster.is_filled)
            continue;
          raise(grid_.at(q), PointGrid::kSeen);
          cluster.points.push_back(q);
        }
      clusters_.push_back(std::move(cluster));
    });
  }

  /// Numbers of the pieces, joined through faces, of points with the bit.
  void number_pieces(PointGrid::Bit bit) {
    piece_.assign(grid_.size(), kNoPiece);
    piece_count_ = 0;
    std::vector<Index3> open;
    grid_.for_each([&](const Index3& first, std::size_t number) {
      if (piece_[number] != kNoPiece || !grid_.has(first, bit)) return;
      piece_[number] = piece_count_;
      for (open.assign(1, first); !open.empty();) {
        const Index3 p = open.back();
        open.pop_back();
        for (const auto& [x, y, z] : kBeside) {
          const Index3 q = p + Index3(x, y, z);
          const std::size_t beside = grid_.at(q);
          if (!grid_.has(q, bit) || piece_[beside] != kNoPiece) continue;
          piece_[beside] = piece_count_;
          open.push_back(q);
        }
      }
      ++piece_count_;
    });
  }

  /// How clusters that are filled join the pieces around them, or how the pieces around come of those cut
  /// out: n pieces that were not joined by an earlier cluster make one less n of the Euler number, with the
  /// sign of what is done.
  void count_pieces(bool filled) {
    DisjointSets sets(piece_count_);
    for (Cluster& cluster : clusters_) {
      if (cluster.is_filled != filled) continue;
      std::vector<std::uint32_t> found;
      for (const Index3& p : cluster.points)
        for (const auto& [x, y, z] : kBeside)
          if (const std::uint32_t piece = piece_[grid_.at(p + Index3(x, y, z))]; piece != kNoPiece)
            found.push_back(sets.find(piece));
      sort_unique(found);
      for (const std::uint32_t piece : found) sets.merge(found.front(), piece);
      const std::int64_t joined = 1 - static_cast<std::int64_t>(found.size());
      cluster.of_pieces = filled ? joined : -joined;
    }
  }

  /// Flips a point. @return What the Euler number changes by.
  std::int64_t flip(const Index3& p) {
    const std::uint32_t set = around(p);
    const auto has = [&](int x, int y, int z) { return (set >> (13 + x + 3 * y + 9 * z) & 1U) != 0; };
    std::int64_t euler = 1;
    for (const auto& [x, y, z] : kBeside) euler -= has(x, y, z);
    for (int n = 0; n < 27; ++n) {
      const Index3 s = neighbour_step(n);
      const int axes = s.cwiseAbs().sum();
      if (axes < 2) continue;
      bool is_full = true;  // The square or the cube between p and the point opposite.
      for (int m = 1; m < 8; ++m) {
        const Index3 part(m % 2 * s.x(), m / 2 % 2 * s.y(), m / 4 * s.z());
        if (part != Index3::Zero()) is_full = is_full && has(part.x(), part.y(), part.z());
      }
      if (is_full) euler += axes == 2 ? 1 : -1;
    }
    grid_.bits(grid_.at(p)) ^= PointGrid::kHas;
    return (set >> 13 & 1U) != 0 ? -euler : euler;
  }

  [[nodiscard]] TopologyPlace place_of(const Cluster& cluster) const {
    Vec3 mean = Vec3::Zero();
    VoxelBox box = VoxelBox::nothing();
    for (const Index3& p : cluster.points) {
      mean += p.cast<double>() / static_cast<double>(cluster.points.size());
      const Index3 voxel = (p.cast<double>() / n_).array().floor().cast<int>();
      box.add(voxel, voxel + Index3::Ones());
    }
    const Index3 nearest = *std::ranges::min_element(cluster.points, [&](const Index3& a, const Index3& b) {
      return (a.cast<double>() - mean).squaredNorm() < (b.cast<double>() - mean).squaredNorm();
    });
    TopologyPlace place{.label = difference_.label,
                        .change = cluster.is_filled ? TopologyChange::kFilled : TopologyChange::kCut,
                        .box = box};
    place.centre_mm =
        image_.frame().to_physical((nearest.cast<double>() + Vec3::Constant(0.5)) / n_ - Vec3::Constant(0.5));
    place.volume_mm3 =
        static_cast<double>(cluster.points.size()) * image_.frame().voxel_volume_mm3() / (n_ * n_ * n_);
    const std::int64_t rest = cluster.euler - cluster.of_pieces;
    // Where neither could be counted it can be both.
    const bool is_either = difference_.handles == 0 && difference_.cavities == 0;
    if (difference_.handles != 0 || is_either) place.handles = -rest;
    if (difference_.cavities != 0 || is_either) place.cavities = rest;
    return place;
  }

  const MeshView& mesh_;
  const LabelImage& image_;
  const TopologyDifference& difference_;
  int n_;
  PointGrid grid_;
  std::vector<Cluster> clusters_;
  std::vector<std::uint32_t> piece_;  // Per point.
  std::uint32_t piece_count_ = 0;
};

}  // namespace

std::vector<TopologyPlace> find_warping_places(const MeshView& mesh, const LabelImage& image,
                                               const TopologyDifference& difference) {
  std::vector<TopologyPlace> places;
  for (const int points_per_voxel : kPointsPerVoxel) {
    Warping warping(mesh, image, difference, points_per_voxel);
    if (!warping.run()) break;
    places = warping.places();
    if (warping.is_complete() || warping.cluster_count() > kMaxClusters) break;
  }
  return places;
}

}  // namespace lumesh::quality
