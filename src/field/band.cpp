// Construction of Band: squared distances to the faces' voxels, the segments that are near, what each lane
// is.
#include "band.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "lumesh/parallel/loops.hpp"

namespace lumesh::field {

namespace {

/// Squared distances to voxels of the minus side (lanes 0 to 7) and of the plus side (8 to 15), in units that
/// keep those of cubic voxels and of edges in simple ratios exact.
using Squares = std::int16_t __attribute__((vector_size(32)));
constexpr int kUnit = 36;  // squared distance 1
constexpr std::int16_t kFar = 20000;
constexpr int kMaxSquare = static_cast<int>(Band::kReach * Band::kReach) * kUnit;
constexpr double kLongestEdge =
    1.5;  // longer voxel edges count as this: the stencils need two voxels on each side

constexpr int kBlockSegments = 24;
constexpr int kChunkSegments = 1000;
constexpr int kChunkSlices = 4;  // stencils write from one slice below to two above

}  // namespace

class BandBuilder {
 public:
  BandBuilder(Band& band, const LabelImage& image, const PairFaces& pair)
      : b_(band),
        image_(image),
        pair_(pair.pair),
        faces_(pair.faces),
        crossings_(pair.crossings),
        size_(image.frame().size) {}

  void build() {
    choose_box();
    mark_face_voxels();
    measure_distances();
    find_lanes();
    choose_segments();
    find_rows();
    find_blocks();
    enter_faces();
    enter_crossings();
    find_held_ghosts();
    find_saddles();
  }

 private:
  struct LaneBits {
    std::uint8_t minus = 0, plus = 0;
  };

  /// The box of all segments: the faces with the band's reach around, as far as the ghosts of the image.
  void choose_box() {
    const Vec3& spacing = image_.frame().spacing_mm;
    b_.edges_ = spacing / spacing.minCoeff();
    for (int axis = 0; axis < 3; ++axis) {
      const double edge = std::min(b_.edges_[axis], kLongestEdge);
      reach_[axis] = static_cast<int>(std::floor(Band::kReach / edge + 1e-9));
      for (int d = 0; d <= 3; ++d)
        square_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(d)] =
            d > reach_[axis] ? kFar : static_cast<std::int16_t>(std::lround(kUnit * d * d * edge * edge));
    }
    Index3 low = size_, high = Index3::Zero();
    for (const Face& f : faces_) {
      low = low.cwiseMin(f.voxel);
      high = high.cwiseMax(f.voxel + Index3::Unit(f.axis));
    }
    b_.low_ = (low - Index3::Constant(4)).cwiseMax(-Band::kGhosts);
    const Index3 end = (high + Index3::Constant(5)).cwiseMin(size_ + Index3::Constant(Band::kGhosts));
    box_ = end - b_.low_;
    box_.x() = (box_.x() + kLanes - 1) / kLanes;
  }

  SegmentPlace segment_of(const Index3& voxel) const {
    const Index3 v = voxel - b_.low_;
    return {v.x() / kLanes, v.y(), v.z()};
  }
  std::uint8_t bit_of(const Index3& voxel) const {
    return static_cast<std::uint8_t>(1U << (static_cast<unsigned>(voxel.x() - b_.low_.x()) % kLanes));
  }

  void mark_face_voxels() {
    near_ = SegmentGrid(box_.x(), box_.y(), box_.z());
    for (const Face& f : faces_) {
      near_.insert(segment_of(f.voxel));
      near_.insert(segment_of(f.voxel + Index3::Unit(f.axis)));
    }
    SegmentGrid& marked = marked_;
    marked = near_;
    marked.number();
    bits_.resize(static_cast<std::size_t>(marked.end()));
    const auto mark = [&](const Index3& voxel) {
      LaneBits& bits = bits_[static_cast<std::size_t>(marked.find(segment_of(voxel)))];
      std::uint8_t& side = pair_.side_of(image_.at(voxel)) > 0 ? bits.plus : bits.minus;
      side = static_cast<std::uint8_t>(side | bit_of(voxel));
    };
    for (const Face& f : faces_) {
      mark(f.voxel);
      mark(f.voxel + Index3::Unit(f.axis));
    }
  }

  /// Squared distances, one axis after the other; each on the segments that the next one asks for.
  void measure_distances() {
    SegmentGrid along_x = near_, along_xy;
    along_x.grow_along_x();
    along_xy = along_x;
    along_xy.grow_along_y(reach_.y());
    near_ = along_xy;
    near_.grow_along_z(reach_.z());
    for (SegmentGrid* grid : {&along_x, &along_xy, &near_}) grid->number();
    std::vector<Squares> x(static_cast<std::size_t>(along_x.end()));
    parallel::for_each_index(x.size(), [&](std::size_t s) {
      x[s] = s == 0 ? all_far() : squares_along_row(along_x.place(static_cast<int>(s)));
    });
    const std::vector<Squares> xy = next_axis(x, along_x, along_xy, 1);
    squares_ = next_axis(xy, along_xy, near_, 2);
  }

  static Squares all_far() { return Squares{} + kFar; }

  Squares squares_along_row(const SegmentPlace& p) const {
    std::uint32_t minus = 0, plus = 0;
    for (int d = -1; d <= 1; ++d) {
      const LaneBits& bits = bits_[static_cast<std::size_t>(marked_.find({p.x + d, p.y, p.z}))];
      const auto shift = static_cast<unsigned>((d + 1) * kLanes);
      minus |= static_cast<std::uint32_t>(bits.minus) << shift;
      plus |= static_cast<std::uint32_t>(bits.plus) << shift;
    }
    Squares result = all_far();
    for (unsigned lane = 0; lane < kLanes; ++lane) {
      for (int d = reach_.x(); d >= 0; --d) {
        const auto u = static_cast<unsigned>(d);
        const std::uint32_t here = 1U << (lane + kLanes - u) | 1U << (lane + kLanes + u);
        if ((minus & here) != 0) result[lane] = square_[0][u];
        if ((plus & here) != 0) result[lane + kLanes] = square_[0][u];
      }
    }
    return result;
  }

  std::vector<Squares> next_axis(const std::vector<Squares>& in, const SegmentGrid& from,
                                 const SegmentGrid& to, int axis) const {
    std::vector<Squares> out(static_cast<std::size_t>(to.end()));
    out[0] = all_far();
    const auto& square = square_[static_cast<std::size_t>(axis)];
    parallel::for_each_index(out.size() - 1, [&](std::size_t i) {
      const SegmentPlace& p = to.place(static_cast<int>(i) + 1);
      Squares least = all_far();
      for (int d = -reach_[axis]; d <= reach_[axis]; ++d) {
        const int s = axis == 1 ? from.find({p.x, p.y + d, p.z}) : from.find({p.x, p.y, p.z + d});
        if (s == 0) continue;
        const Squares sum = in[static_cast<std::size_t>(s)] + square[static_cast<std::size_t>(std::abs(d))];
        least = sum < least ? sum : least;
      }
      out[i + 1] = least;
    });
    return out;
  }

  /// What is near with the ghosts' rows: what their nearest voxel is.
  void find_lanes() {
    const SegmentGrid inner = near_;
    near_ = SegmentGrid(box_.x(), box_.y(), box_.z());
    const Index3 first = b_.low_;
    for (int s = 1; s < inner.end(); ++s) near_.insert(inner.place(s));
    const auto is_ghost_row = [&](int y, int z) {
      const Index3 v = first + Index3(0, y, z);
      return v.y() < 0 || v.z() < 0 || v.y() >= size_.y() || v.z() >= size_.z();
    };
    for (int z = 0; z < box_.z(); ++z) {
      for (int y = 0; y < box_.y(); ++y) {
        if (!is_ghost_row(y, z)) continue;
        const Index3 source = nearest_place(size_, first + Index3(0, y, z)) - first;
        for (int x = 0; x < box_.x(); ++x)
          if (inner.contains({x, source.y(), source.z()})) near_.insert({x, y, z});
      }
    }
    near_.number();
    lanes_.resize(static_cast<std::size_t>(near_.end()));
    parallel::for_each_index(lanes_.size() - 1, [&](std::size_t i) {
      for (unsigned lane = 0; lane < kLanes; ++lane) look_at_lane(static_cast<int>(i) + 1, lane, inner);
    });
  }

  struct LaneFacts {
    std::uint8_t alive = 0, plus = 0, sided = 0, in_image = 0;
    std::array<float, kLanes> start = {};
  };

  void look_at_lane(int segment, unsigned lane, const SegmentGrid& inner) {
    LaneFacts& facts = lanes_[static_cast<std::size_t>(segment)];
    const SegmentPlace& p = near_.place(segment);
    const Index3 voxel = b_.low_ + Index3(p.x * kLanes + static_cast<int>(lane), p.y, p.z);
    if (((voxel.array() < -Band::kGhosts) || (voxel.array() >= size_.array() + Band::kGhosts)).any()) return;
    const Index3 source = nearest_place(size_, voxel);
    const Squares& squares = squares_[static_cast<std::size_t>(inner.find(segment_of(source)))];
    const auto source_lane = static_cast<unsigned>(source.x() - b_.low_.x()) % kLanes;
    const int to_minus = squares[source_lane], to_plus = squares[source_lane + kLanes];
    const LabelIndex label = image_.at(source);
    const int own_side = pair_.side_of(label);
    const int nearest = own_side > 0 ? to_minus : own_side < 0 ? to_plus : std::min(to_minus, to_plus);
    if (nearest > kMaxSquare) return;
    const int side = own_side == 0 && label == 0 ? side_of_background(to_minus, to_plus) : own_side;
    const auto bit = [&](bool set) { return static_cast<std::uint8_t>(static_cast<unsigned>(set) << lane); };
    facts.alive = static_cast<std::uint8_t>(facts.alive | bit(true));
    facts.plus = static_cast<std::uint8_t>(facts.plus | bit(side > 0));
    facts.sided = static_cast<std::uint8_t>(facts.sided | bit(side != 0));
    facts.in_image = static_cast<std::uint8_t>(facts.in_image | bit(source == voxel));
    facts.start[lane] = start_value(side, to_minus, to_plus);
  }

  /// Beyond the outer wall the boundary between two labels goes on somewhere, but leaves each voxel on the
  /// side that is nearer: else it may come back through the wall and cut off a crumb.
  static int side_of_background(int to_minus, int to_plus) {
    constexpr int kClear = kUnit / 2;
    return to_minus > to_plus + kClear ? 1 : to_plus > to_minus + kClear ? -1 : 0;
  }

  static float start_value(int side, int to_minus, int to_plus) {
    const auto length = [](int square) {
      return std::min(static_cast<float>(Band::kReach), std::sqrt(static_cast<float>(square) / kUnit));
    };
    if (side > 0) return length(to_minus) - 0.5F;
    if (side < 0) return 0.5F - length(to_plus);
    return 0.5F * (length(to_minus) - length(to_plus));
  }

  /// Keeps the segments with a living lane and makes room for dead ones between rows whose lanes would meet
  /// in memory: the stencils read two lanes on and one back.
  void choose_segments() {
    b_.grid_ = SegmentGrid(box_.x(), box_.y(), box_.z());
    std::vector<int> kept;
    for (int s = 1; s < near_.end(); ++s) {
      if (lanes_[static_cast<std::size_t>(s)].alive == 0) continue;
      b_.grid_.insert(near_.place(s));
      kept.push_back(s);
    }
    std::vector<std::int32_t> numbers = {0};
    int next = 1;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (i > 0 && !follows(kept[i - 1], kept[i]) && would_meet(kept[i - 1], kept[i])) ++next;
      numbers.push_back(next++);
    }
    b_.grid_.number();
    b_.grid_.renumber(numbers, next);
    const auto count = static_cast<std::size_t>(next);
    for (auto* bits : {&b_.alive_, &b_.plus_, &b_.sided_, &b_.held_, &b_.in_image_, &b_.boundary_})
      bits->assign(count, 0);
    b_.start_.assign(next, 0);
    for (std::size_t i = 0; i < kept.size(); ++i) {
      const LaneFacts& facts = lanes_[static_cast<std::size_t>(kept[i])];
      const auto s = static_cast<std::size_t>(numbers[i + 1]);
      b_.alive_[s] = facts.alive;
      b_.plus_[s] = facts.plus;
      b_.sided_[s] = facts.sided;
      b_.in_image_[s] = facts.in_image;
      std::copy(facts.start.begin(), facts.start.end(), b_.start_.at(numbers[i + 1]));
      b_.voxel_count_ += static_cast<std::size_t>(std::popcount(facts.alive));
    }
  }

  bool follows(int before, int segment) const {
    const SegmentPlace &a = near_.place(before), &b = near_.place(segment);
    return a.y == b.y && a.z == b.z && a.x + 1 == b.x;
  }
  bool would_meet(int before, int segment) const {
    const unsigned a = lanes_[static_cast<std::size_t>(before)].alive;
    const unsigned b = lanes_[static_cast<std::size_t>(segment)].alive;
    const bool back = (a & 0x80U) != 0 && (b & 1U) != 0;
    return back || ((a & 0xC0U) != 0 && (b & 3U) != 0);
  }

  void find_rows() {
    b_.rows_.assign(b_.segment_count(), {});
    parallel::for_each_index(b_.segment_count() - 1, [&](std::size_t i) {
      const auto s = static_cast<int>(i) + 1;
      if (!b_.grid_.exists(s)) return;
      const SegmentPlace& p = b_.grid_.place(s);
      for (std::size_t r = 0; r < kRowCount; ++r)
        b_.rows_[i + 1][r] = b_.grid_.find({p.x, p.y + kRowOffset[r][0], p.z + kRowOffset[r][1]});
    });
  }

  void find_blocks() {
    const int end = b_.end();
    int begin = 1, chunk_begin = 1;
    int chunk_z = -1;
    b_.chunks_ = {0};
    for (int s = 1; s <= end; ++s) {
      const bool last = s == end;
      if (!last && (!b_.grid_.exists(s) || s == 1)) continue;
      if (!last) {
        const SegmentPlace &p = b_.grid_.place(s), &before = b_.grid_.place(s - 1);
        if (before.x + 1 == p.x && before.y == p.y && before.z == p.z) continue;
        if (chunk_z < 0) chunk_z = b_.grid_.place(1).z;
      }
      const bool ends_chunk =
          last || (b_.grid_.place(s).z - chunk_z >= kChunkSlices && s - chunk_begin >= kChunkSegments);
      if (s > begin && (s - begin >= kBlockSegments || ends_chunk)) {
        b_.blocks_.push_back({begin, s});
        begin = s;
      }
      if (!ends_chunk) continue;
      b_.chunks_.push_back(static_cast<int>(b_.blocks_.size()));
      chunk_begin = s;
      if (!last) chunk_z = b_.grid_.place(s).z;
    }
  }

  void enter_faces() {
    b_.faces_.assign(b_.segment_count(), {});
    b_.first_entry_.assign(b_.segment_count() + 1, 0);
    b_.face_count_ = faces_.size();
    for (const Face& f : faces_) {
      const auto s = static_cast<std::size_t>(b_.grid_.find(segment_of(f.voxel)));
      std::uint8_t& bits = b_.faces_[s][static_cast<std::size_t>(f.axis)];
      bits = static_cast<std::uint8_t>(bits | bit_of(f.voxel));
      for (const Index3& v : {f.voxel, Index3(f.voxel + Index3::Unit(f.axis))}) {
        std::uint8_t& boundary = b_.boundary_[static_cast<std::size_t>(b_.grid_.find(segment_of(v)))];
        boundary = static_cast<std::uint8_t>(boundary | bit_of(v));
      }
    }
    for (std::size_t s = 0; s < b_.segment_count(); ++s) {
      int entries = 0;
      for (const std::uint8_t bits : b_.faces_[s]) entries += static_cast<int>(bits != 0);
      b_.first_entry_[s + 1] = b_.first_entry_[s] + entries;
    }
  }

  void enter_crossings() {
    if (crossings_.empty()) return;
    b_.crossings_.assign(static_cast<std::size_t>(b_.entry_count()) * kLanes, 0.0F);
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      const Face& f = faces_[i];
      const int s = b_.grid_.find(segment_of(f.voxel));
      const int entry = b_.entry_of(s, f.axis);
      const auto lane = static_cast<std::size_t>(f.voxel.x() - b_.low_.x()) % kLanes;
      b_.crossings_[static_cast<std::size_t>(entry) * kLanes + lane] = crossings_[i];
    }
  }

  /// Outside the image the side of the nearest voxel holds, unless a cut of the object by the border is
  /// within two voxels.
  void find_held_ghosts() {
    parallel::for_each_index(b_.segment_count() - 1, [&](std::size_t i) {
      const std::size_t s = i + 1;
      b_.held_[s] = static_cast<std::uint8_t>(b_.in_image_[s] & b_.sided_[s]);
      const auto ghosts = static_cast<std::uint8_t>(b_.alive_[s] & ~b_.in_image_[s] & b_.sided_[s]);
      for (int lane = 0; lane < kLanes; ++lane) {
        if (!Band::has(ghosts, lane)) continue;
        const Index3 voxel = b_.voxel(static_cast<Lane>(s) * kLanes + lane);
        if (!cut_is_near(voxel))
          b_.held_[s] = static_cast<std::uint8_t>(b_.held_[s] | 1U << static_cast<unsigned>(lane));
      }
    });
  }

  bool cut_is_near(const Index3& ghost) const {
    const Index3 nearest = nearest_place(size_, ghost);
    const LabelIndex own = image_.at(nearest);
    const auto reach = [&](int axis) { return nearest[axis] != ghost[axis] ? 0 : 2; };
    for (int k = -reach(2); k <= reach(2); ++k)
      for (int j = -reach(1); j <= reach(1); ++j)
        for (int i = -reach(0); i <= reach(0); ++i)
          if (pair_.side_of(image_.at_nearest(nearest + Index3(i, j, k))) != pair_.side_of(own)) return true;
    return false;
  }

  void find_saddles() {
    constexpr std::array<std::array<int, 2>, 3> kPlanes = {{{0, 1}, {1, 2}, {2, 0}}};
    for (int s = 1; s < b_.end(); ++s) {
      for (const auto& [a, c] : kPlanes) {
        const auto both = static_cast<std::uint8_t>(b_.faces(s, a) & b_.faces(s, c));
        for (int lane = 0; both != 0 && lane < kLanes; ++lane)
          if (Band::has(both, lane)) add_saddle(s * kLanes + lane, Index3::Unit(a), Index3::Unit(c));
      }
    }
  }

  void add_saddle(Lane lane, const Index3& a, const Index3& c) {
    const Index3 voxel = b_.voxel(lane);
    if (pair_.side_of(image_.at(voxel)) != pair_.side_of(image_.at(voxel + a + c))) return;
    const auto at = [&](const Index3& d) { return b_.neighbour(lane, d.x(), d.y(), d.z()); };
    b_.saddles_.push_back({{lane, at(a), at(c), at(a + c)}});
  }

  Band& b_;
  const LabelImage& image_;
  LabelPair pair_;
  const std::vector<Face>& faces_;
  const std::vector<float>& crossings_;
  Index3 size_;
  Index3 box_ = Index3::Zero();  // segments along x, rows along y and z
  Index3 reach_ = Index3::Zero();
  std::array<std::array<std::int16_t, 4>, 3> square_ = {};
  SegmentGrid near_, marked_;
  std::vector<LaneBits> bits_;  // faces' voxels of the segments marked_
  std::vector<Squares> squares_;
  std::vector<LaneFacts> lanes_;
};

Band::Band(const LabelImage& image, const PairFaces& pair)
    : image_(&image), is_outer_wall_(pair.pair.is_outer_wall()) {
  BandBuilder(*this, image, pair).build();
}

Lane Band::neighbour(Lane lane, int i, int j, int k) const {
  const SegmentPlace& p = grid_.place(lane / kLanes);
  const int x = p.x * kLanes + lane % kLanes + i;
  const int segment = x < 0 ? 0 : grid_.find({x / kLanes, p.y + j, p.z + k});
  return segment * kLanes + (x & (kLanes - 1));
}

}  // namespace lumesh::field
