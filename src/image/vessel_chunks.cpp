#include "vessel_chunks.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <set>
#include <tuple>

#include "lumesh/core/error.hpp"
#include "lumesh/image/distance.hpp"
#include "lumesh/image/selection.hpp"
#include "lumesh/parallel/loops.hpp"
#include "voxel_edits.hpp"

namespace lumesh::image {

namespace {

constexpr double kMaxHalfWidth = 12;  // Smallest voxel edges; thicker parts count as this thick.
// A ball covers its vessel, and not the axis of the next.
constexpr double kBallInHalfWidths = 1.3, kCoreInHalfWidths = 0.75, kWallShare = 0.8;
constexpr double kNeckShare = 0.75;
constexpr float kThread = 1.42F;     // Half width of one or two voxels, also along diagonals.
constexpr float kThinVessel = 3.5F;  // Of such, voxels do not tell a neck from the vessel so well.
constexpr double kNeckShareOfThin = 0.95;
constexpr float kWider = 1.25;  // So much wider a way around tells that chunks of one vessel meet.
constexpr double kBumpShare = 0.6, kBumpReach = 1.6, kBumpSaddle = 0.9;
constexpr float kMinVessel = 1.8F;  // Half width of what is followed as a vessel of its own: three voxels.
constexpr double kReachInHalfWidths = 4;  // How far around a neck vessels are followed.
constexpr double kMinTurn = -0.1;  // Cosine between the two directions of a vessel, seen from its wall.

constexpr double kOpposite = -0.5;  // The same, seen from its axis.
constexpr double kTiny = 1e-9;
// Half width of what is a cavity of one vessel; pockets that vessels side by side enclose are thinner.
constexpr float kThinCavity = 2;
constexpr float kAlike = 0.6F;  // Half widths along one vessel.
// Chords between two vessels, as a share of the shorter one of theirs; half a voxel edge of each is
// uncertain.
constexpr double kChordShare = 0.85, kChordUncertain = 0.5;
constexpr double kMaxOverlap = 0.65;  // Of the balls of two vessels, in half widths of the thinner.

const std::array<Index3, 6> kSides = {Index3(-1, 0, 0), Index3(1, 0, 0),  Index3(0, -1, 0),
                                      Index3(0, 1, 0),  Index3(0, 0, -1), Index3(0, 0, 1)};

/// Voxels' distances are to centres; walls are half an edge before.
double width_share(double saddle, double half_width) {
  return std::max(0.25, saddle - 0.5) / std::max(0.25, half_width - 0.5);
}

bool has_opposites(const std::vector<Vec3>& ways, double most) {
  for (std::size_t a = 0; a < ways.size(); ++a)
    for (std::size_t b = a + 1; b < ways.size(); ++b)
      if (ways[a].dot(ways[b]) < most) return true;
  return false;
}

std::pair<std::uint32_t, std::uint32_t> ordered(std::uint32_t a, std::uint32_t b) {
  return a < b ? std::pair(a, b) : std::pair(b, a);
}

}  // namespace

VesselChunks::VesselChunks(const LabelImage& image) {
  const VoxelBox box = object_box(image);
  if (box.is_empty()) return;
  low_ = (box.low - Index3::Ones()).cwiseMax(Index3::Zero());
  size_ = (box.high + Index3::Ones()).cwiseMin(image.frame().size) - low_;
  const double voxels = size_.cast<double>().prod();
  if (voxels >= static_cast<double>(kNoChunk))
    throw Error(ErrorKind::kMemory, "image is too large to look for thin places; crop it");
  edges_ = image.frame().spacing_mm / image.frame().spacing_mm.minCoeff();
  find_distances(image);
  choose_seeds();
  part();
  if (continue_interrupted_vessels()) part();
  find_borders(image.frame().size);
}

void VesselChunks::part() {
  flood();
  find_faces();
  absorb_bumps();
  find_faces();
}

void VesselChunks::find_distances(const LabelImage& image) {
  LabelImage all(image.frame(), {kBackground, 1});
  parallel::for_each_index(all.voxels().size(), 1 << 16,
                           [&](std::size_t v) { all.voxels()[v] = image.voxels()[v] != 0 ? 1 : 0; });
  const double edge_mm = image.frame().spacing_mm.minCoeff();
  const auto edge = static_cast<float>(edge_mm);
  const auto measure = [&] {
    DistanceField field = distance_to_label_change(all, low_, low_ + size_, kMaxHalfWidth * edge_mm);
    distance_ = std::move(field.distance_mm);
    parallel::for_each_index(distance_.size(), 1 << 14, [&](std::size_t v) { distance_[v] /= edge; });
  };
  measure();
  if (fill_wide_cavities(all)) measure();
  const auto row = static_cast<std::size_t>(size_.x());
  parallel::for_each_index(distance_.size() / row, 1 << 8, [&](std::size_t r) {
    const std::size_t first = all.frame().offset(low_ + place_of(r * row));
    for (std::size_t i = 0; i < row; ++i)
      if (all.voxels()[first + i] == 0) distance_[r * row + i] = 0;
  });
}

/// The shell around a cavity would look like two vessels that meet on both sides of it.
bool VesselChunks::fill_wide_cavities(LabelImage& all) {
  is_filled_.assign(distance_.size(), false);
  bool has_any = false;
  for (const std::vector<Index3>& piece : enclosed_pieces(all)) {
    const bool is_wide = std::ranges::any_of(
        piece, [&](const Index3& voxel) { return distance_[offset(voxel - low_)] > kThinCavity; });
    for (std::size_t i = 0; is_wide && i < piece.size(); ++i) {
      all.at(piece[i]) = 1;
      is_filled_[offset(piece[i] - low_)] = true;
    }
    has_any |= is_wide;
  }
  return has_any;
}

/// The thickest place that no ball covers yet, again and again. A ball covers its middle, and what is so much
/// thinner around it that it is wall rather than axis.
void VesselChunks::choose_seeds() {
  std::vector<std::uint32_t> order;
  for (std::size_t v = 0; v < distance_.size(); ++v)
    if (distance_[v] > 0) order.push_back(static_cast<std::uint32_t>(v));
  parallel::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return distance_[a] != distance_[b] ? distance_[a] > distance_[b] : a < b;
  });
  std::vector<char> covered(distance_.size(), 0);
  for (const std::uint32_t v : order) {
    if (covered[v] != 0) continue;
    const Index3 seed = place_of(v);
    const auto half_width = static_cast<double>(distance_[v]);
    chunks_.push_back({seed, distance_[v], Vec3::Zero(), 0, {}});
    const Index3 half = (kBallInHalfWidths * half_width * edges_.cwiseInverse()).array().floor().cast<int>();
    const Index3 from = (seed - half).cwiseMax(Index3::Zero()),
                 to = (seed + half).cwiseMin(size_ - Index3::Ones());
    for_each_place(from, to, [&](const Index3& at) {
      const double away = (at - seed).cast<double>().cwiseProduct(edges_).norm() / half_width;
      const bool is_wall = static_cast<double>(distance_[offset(at)]) < kWallShare * half_width;
      if (away <= (is_wall ? kBallInHalfWidths : kCoreInHalfWidths)) covered[offset(at)] = 1;
    });
  }
}

/// Voxels go to the chunk whose ball they are nearest to, as far as it comes there through the object.
void VesselChunks::flood() {
  chunk_of_.assign(distance_.size(), kNoChunk);
  using SeedEntry = std::tuple<float, std::uint32_t, std::uint32_t>;  // How far off the ball, voxel, chunk.
  std::priority_queue<SeedEntry, std::vector<SeedEntry>, std::greater<>> entries;
  const auto add = [&](const Index3& place, std::uint32_t chunk) {
    const double off = (place - chunks_[chunk].seed).cast<double>().cwiseProduct(edges_).norm() -
                       static_cast<double>(chunks_[chunk].half_width);
    entries.emplace(static_cast<float>(off), static_cast<std::uint32_t>(offset(place)), chunk);
  };
  for (std::uint32_t c = 0; c < chunks_.size(); ++c) add(chunks_[c].seed, c);
  while (!entries.empty()) {
    const auto [off, voxel, chunk] = entries.top();
    entries.pop();
    if (chunk_of_[voxel] != kNoChunk) continue;
    chunk_of_[voxel] = chunk;
    const Index3 place = place_of(voxel);
    for (const Index3& side : kSides) {
      const Index3 next = place + side;
      if (contains(next) && distance_[offset(next)] > 0 && chunk_of_[offset(next)] == kNoChunk)
        add(next, chunk);
    }
  }
}

void VesselChunks::find_faces() {
  faces_ = parallel::collect_blocks<ChunkFace>(
      chunk_of_.size(), std::size_t{1} << 18,
      [&](std::size_t begin, std::size_t end, std::vector<ChunkFace>& out) {
        for (std::size_t v = begin; v < end; ++v) {
          if (chunk_of_[v] == kNoChunk) continue;
          const Index3 place = place_of(v);
          for (int axis = 0; axis < 3; ++axis) {
            if (place[axis] + 1 == size_[axis]) continue;
            const std::size_t w = offset(place + Index3::Unit(axis));
            if (chunk_of_[w] == kNoChunk || chunk_of_[w] == chunk_of_[v]) continue;
            const auto [first, second] = ordered(chunk_of_[v], chunk_of_[w]);
            out.push_back({first, second, static_cast<std::uint32_t>(v), static_cast<std::uint32_t>(w),
                           std::min(distance_[v], distance_[w])});
          }
        }
      });
  std::ranges::stable_sort(faces_, [](const ChunkFace& a, const ChunkFace& b) {
    return std::tie(a.first, a.second) < std::tie(b.first, b.second);
  });
  saddles_.clear();
  for (Chunk& chunk : chunks_) chunk.beside.clear();
  for (const ChunkFace& face : faces_) {
    const auto [at, is_new] = saddles_.emplace(std::pair(face.first, face.second), face.half_width);
    at->second = std::max(at->second, face.half_width);
    if (!is_new) continue;
    chunks_[face.first].beside.push_back(face.second);
    chunks_[face.second].beside.push_back(face.first);
  }
  for (Chunk& chunk : chunks_) std::ranges::sort(chunk.beside);
}

/// Whether a chunk lies between two others of about its width that are opposite to each other: in a vessel.
bool VesselChunks::is_in_line(std::uint32_t chunk) const {
  constexpr float kWide = 0.7F;
  constexpr double kInLine = -0.7;
  const float width = chunks_[chunk].half_width;
  if (width < kMinVessel) return false;
  std::vector<Vec3> ways;
  for (const std::uint32_t next : chunks_[chunk].beside) {
    const float other = chunks_[next].half_width;
    if (std::min(width, other) < kAlike * std::max(width, other) || saddle(chunk, next) < kWide * width)
      continue;
    ways.push_back(
        (chunks_[next].seed - chunks_[chunk].seed).cast<double>().cwiseProduct(edges_).normalized());
    for (const Vec3& way : ways)
      if (way.dot(ways.back()) < kInLine) return true;
  }
  return false;
}

/// Bumps of a wall that no ball covered belong to the vessel.
void VesselChunks::absorb_bumps() {
  std::vector<std::uint32_t> part_of(chunks_.size());
  std::iota(part_of.begin(), part_of.end(), 0U);
  for (std::uint32_t c = 0; c < chunks_.size(); ++c) {
    const Chunk& bump = chunks_[c];
    if (is_in_line(c)) continue;
    std::uint32_t best = kNoChunk;
    for (const std::uint32_t n : bump.beside) {
      const double apart = (chunks_[n].seed - bump.seed).cast<double>().cwiseProduct(edges_).norm();
      const bool is_large =
          static_cast<double>(bump.half_width) <= kBumpShare * static_cast<double>(chunks_[n].half_width);
      if (is_large && apart <= kBumpReach * static_cast<double>(chunks_[n].half_width) &&
          static_cast<double>(saddle(c, n)) >= kBumpSaddle * static_cast<double>(bump.half_width) &&
          (best == kNoChunk || saddle(c, n) > saddle(c, best)))
        best = n;
    }
    if (best != kNoChunk) part_of[c] = best;
  }
  // Into one that is larger each, so that no circle closes.
  for (std::uint32_t c = 0; c < part_of.size(); ++c)
    while (part_of[part_of[c]] != part_of[c]) part_of[c] = part_of[part_of[c]];
  parallel::for_each_index(chunk_of_.size(), 1 << 16, [&](std::size_t v) {
    if (chunk_of_[v] != kNoChunk) chunk_of_[v] = part_of[chunk_of_[v]];
  });
}

void VesselChunks::find_borders(const Index3& image_size) {
  for (std::size_t v = 0; v < chunk_of_.size(); ++v) {
    if (chunk_of_[v] == kNoChunk) continue;
    const Index3 place = place_of(v), in_image = low_ + place;
    if ((in_image.array() > 0).all() && (in_image.array() + 1 < image_size.array()).all()) continue;
    Chunk& chunk = chunks_[chunk_of_[v]];
    chunk.border_sum += place.cast<double>();
    ++chunk.border_count;
  }
}

/// A thin vessel that is sunk into a thicker one loses a piece of itself to that: what goes on straight
/// beyond is the same vessel, unlike branches, which do not lie in one line so near to each other. It gets a
/// ball between.
bool VesselChunks::continue_interrupted_vessels() {
  constexpr float kThinner = 0.75F, kWide = 0.7F;
  constexpr double kNear = 3.2, kStraight = 0.7;
  const auto to = [&](std::uint32_t from, std::uint32_t chunk) {
    return Vec3((chunks_[chunk].seed - chunks_[from].seed).cast<double>().cwiseProduct(edges_));
  };
  const auto goes_straight_on = [&](std::uint32_t from, std::uint32_t through) {
    const Vec3 way = to(from, through).normalized();
    const std::vector<std::uint32_t>& beside = chunks_[through].beside;
    return std::ranges::any_of(beside, [&](std::uint32_t next) {
      return next != from && to(through, next).normalized().dot(way) > kStraight;
    });
  };
  const auto is_joined = [&](std::uint32_t a, std::uint32_t b) {
    const float least = kWide * std::min(chunks_[a].half_width, chunks_[b].half_width),
                most = std::max(chunks_[a].half_width, chunks_[b].half_width) / kThinner;
    return std::ranges::any_of(chunks_[a].beside, [&](std::uint32_t c) {
      return chunks_[c].half_width < most && std::min(saddle(a, c), saddle(c, b)) >= least;
    });
  };
  std::set<std::pair<std::uint32_t, std::uint32_t>> interrupted;
  for (const Chunk& thick : chunks_)
    for (std::size_t i = 0; i < thick.beside.size(); ++i)
      for (std::size_t j = i + 1; j < thick.beside.size(); ++j) {
        const std::uint32_t a = thick.beside[i], b = thick.beside[j];
        const float most = std::max(chunks_[a].half_width, chunks_[b].half_width);
        if (most <= kThinner * thick.half_width && saddle(a, b) == 0 && !is_joined(a, b) &&
            to(a, b).norm() <= kNear * static_cast<double>(most) && goes_straight_on(a, b) &&
            goes_straight_on(b, a))
          interrupted.emplace(a, b);
      }
  const std::size_t before = chunks_.size();
  for (const auto& [a, b] : interrupted) {
    const Index3 middle = (chunks_[a].seed + chunks_[b].seed) / 2;
    const float half_width = std::min(chunks_[a].half_width, chunks_[b].half_width);
    if (distance_[offset(middle)] > 0) chunks_.push_back({middle, half_width, Vec3::Zero(), 0, {}});
  }
  return chunks_.size() > before;
}

bool VesselChunks::is_beside(std::size_t voxel) const {
  // Without the place, which takes divisions: what is beside it in memory may be at the other end of a row.
  const std::array<std::size_t, 3> steps = {
      1, static_cast<std::size_t>(size_.x()),
      static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y())};
  const auto is_object = [&](std::size_t v) { return v < chunk_of_.size() && chunk_of_[v] != kNoChunk; };
  const auto has_any = [&](std::size_t step) { return is_object(voxel - step) || is_object(voxel + step); };
  if (std::ranges::none_of(steps, has_any)) return false;
  const Index3 place = place_of(voxel);
  for (std::size_t axis = 0; axis < steps.size(); ++axis) {
    const int at = place[static_cast<Eigen::Index>(axis)], size = size_[static_cast<Eigen::Index>(axis)];
    if ((at > 0 && is_object(voxel - steps[axis])) || (at + 1 < size && is_object(voxel + steps[axis])))
      return true;
  }
  return false;
}

float VesselChunks::saddle(std::uint32_t a, std::uint32_t b) const {
  const auto found = saddles_.find(ordered(a, b));
  return found == saddles_.end() ? 0.0F : found->second;
}

/// The greatest half width of a way from one chunk to the other around the faces that they share, not far
/// off.
float VesselChunks::widest_way_around(std::uint32_t a, std::uint32_t b) const {
  constexpr double kReach = 2.5;
  const double reach = kReach * static_cast<double>(std::max(chunks_[a].half_width, chunks_[b].half_width));
  const auto is_far = [&](std::uint32_t chunk) {
    const auto off = [&](std::uint32_t from) {
      return (chunks_[chunk].seed - chunks_[from].seed).cast<double>().cwiseProduct(edges_).norm();
    };
    const auto thicker = static_cast<double>(chunks_[chunk].half_width -
                                             std::max(chunks_[a].half_width, chunks_[b].half_width));
    return std::min(off(a), off(b)) > reach + std::max(0.0, thicker);
  };
  std::priority_queue<std::pair<float, std::uint32_t>> ways;
  std::set<std::uint32_t> reached = {a};
  const auto look_around = [&](std::uint32_t chunk, float width) {
    for (const std::uint32_t next : chunks_[chunk].beside)
      if (!reached.contains(next) && !(chunk == a && next == b))
        ways.emplace(std::min(width, saddle(chunk, next)), next);
  };
  look_around(a, std::numeric_limits<float>::infinity());
  while (!ways.empty()) {
    const auto [width, chunk] = ways.top();
    ways.pop();
    if (chunk == b) return width;
    if (!reached.insert(chunk).second || is_far(chunk)) continue;
    look_around(chunk, width);
  }
  return 0;
}

bool VesselChunks::is_neck(std::uint32_t a, std::uint32_t b) const {
  const float least = std::min(chunks_[a].half_width, chunks_[b].half_width), width = saddle(a, b);
  const double share = width_share(static_cast<double>(width), static_cast<double>(least));
  if (share > (least <= kThinVessel ? kNeckShareOfThin : kNeckShare)) return false;
  return widest_way_around(a, b) < kWider * width;
}

bool VesselChunks::are_apart(std::uint32_t a, std::uint32_t b) const {
  const float least = std::min(chunks_[a].half_width, chunks_[b].half_width);
  const double width = static_cast<double>(std::max(saddle(a, b), widest_way_around(a, b)));
  return width == 0 || width_share(width, static_cast<double>(least)) <= kNeckShare;
}

bool VesselChunks::hang_by_thread(std::uint32_t a, std::uint32_t b) const {
  return saddle(a, b) <= kThread && are_apart(a, b);
}

/// How long the object is along a line through a place, at most so long on either side.
double VesselChunks::chord(const Vec3& middle, const Vec3& way, double most) const {
  constexpr double kStep = 0.25;
  const auto is_in = [&](const Vec3& at) {
    const Index3 voxel = (at.array() + 0.5).floor().cast<int>();
    return contains(voxel) && chunk_of_[offset(voxel)] != kNoChunk;
  };
  double length = 0;
  for (const double sign : {-1.0, 1.0}) {
    const Vec3 step = (sign * kStep * way).cwiseQuotient(edges_);
    for (int steps = 1; kStep * steps <= most && is_in(middle + steps * step); ++steps) length += kStep;
  }
  return length;
}

/// In a convex object a chord is at least as long as the shorter one of two that are parallel to it on both
/// sides (Brunn and Minkowski). So chunks that voxels part along the long axis of an oval section are told
/// from vessels side by side, which have a groove between them.
bool VesselChunks::narrows_between(std::uint32_t a, std::uint32_t b) const {
  constexpr int kDirections = 6, kPlaces = 12;
  constexpr double kReach = 2.5, kTooThin = 2.7;
  const auto least = static_cast<double>(std::min(chunks_[a].half_width, chunks_[b].half_width)),
             most = static_cast<double>(std::max(chunks_[a].half_width, chunks_[b].half_width));
  // Chunks of one section are alike; chords of thin ones are whole voxels, which say too little.
  if (least < kTooThin || least < static_cast<double>(kAlike) * most) return true;
  const Vec3 from = chunks_[a].seed.cast<double>(), to = chunks_[b].seed.cast<double>();
  const Vec3 apart = (to - from).cwiseProduct(edges_);
  if (least + most - apart.norm() > kMaxOverlap * least) return false;
  const Vec3 across = apart.unitOrthogonal(), up = apart.normalized().cross(across);
  const double share = kChordShare - kChordUncertain / least;
  const auto is_narrower_along = [&](int i, int j) {
    const Vec3 way = (i * across + j * up).normalized();
    const double limit = share * std::min(chord(from, way, kReach * most), chord(to, way, kReach * most));
    for (int place = 1; place < kPlaces; ++place)
      if (chord(from + (to - from) * place / kPlaces, way, kReach * most) <= limit) return true;
    return false;
  };
  for (int i = -kDirections; i < kDirections; ++i)  // All around: along the sides of a square.
    if (is_narrower_along(i, kDirections) || is_narrower_along(kDirections, i + 1)) return true;
  return false;
}

bool VesselChunks::goes_on_from_wall(const std::vector<std::uint32_t>& side, const Vec3& place) const {
  std::vector<Vec3> ways;
  for (std::size_t i = 0; i < side.size(); ++i) {
    const Chunk& chunk = chunks_[side[i]];
    const auto add = [&](const Vec3& at) { ways.push_back((at - place).cwiseProduct(edges_).normalized()); };
    if (i > 0) add(chunk.seed.cast<double>());  // The first one is where the place is.
    if (chunk.border_count > 0) add(chunk.border_sum / static_cast<double>(chunk.border_count));
  }
  return has_opposites(ways, kMinTurn);
}

/// A vessel that bends away from the other turns both its ends to one side of its wall: seen from as deep as
/// it is thick, what is as thick beside it goes on across the way that leads there.
bool VesselChunks::goes_on_from_axis(const std::vector<std::uint32_t>& side, const Vec3& place) const {
  constexpr double kMinWay = 0.2, kNear = 2.5, kAcross = 0.7;
  const Chunk& own = chunks_[side.front()];
  const auto half_width = static_cast<double>(own.half_width);
  const Vec3 inwards = (own.seed.cast<double>() - place).cwiseProduct(edges_);
  const Vec3 to_axis = inwards * std::min(1.0, half_width / std::max(kTiny, inwards.norm()));
  std::vector<Vec3> ways;
  const auto add = [&](const Vec3& at) {
    const Vec3 way = (at - place).cwiseProduct(edges_) - to_axis;
    if (way.norm() >= kMinWay * half_width && way.norm() <= kNear * half_width &&
        std::abs(way.normalized().dot(to_axis.normalized())) <= kAcross)
      ways.push_back(way.normalized());
  };
  for (std::size_t i = 0; i < side.size(); ++i) {
    const Chunk& chunk = chunks_[side[i]];
    if (std::min(chunk.half_width, own.half_width) < kAlike * std::max(chunk.half_width, own.half_width))
      continue;
    if (i > 0) add(chunk.seed.cast<double>());
    if (chunk.border_count > 0) add(chunk.border_sum / static_cast<double>(chunk.border_count));
  }
  return has_opposites(ways, kOpposite);
}

std::optional<VesselChunks::Sides> VesselChunks::passing_sides(std::uint32_t a, std::uint32_t b,
                                                               const Vec3& place) const {
  const double reach =
      kReachInHalfWidths * static_cast<double>(std::max(chunks_[a].half_width, chunks_[b].half_width));
  // Each chunk around goes to the side to which it is connected more widely, measured as a share of the
  // thicker of the two chunks that share the faces: so a thin vessel pressed into a thick one keeps its own
  // chunks.
  std::map<std::uint32_t, bool> is_of_b = {{a, false}, {b, true}};
  Sides sides = {{{a}, {b}}};
  using Way = std::tuple<float, std::uint32_t, bool>;
  const auto is_later = [](const Way& x, const Way& y) {
    return std::get<0>(x) != std::get<0>(y)
               ? std::get<0>(x) < std::get<0>(y)
               : std::tie(std::get<1>(x), std::get<2>(x)) > std::tie(std::get<1>(y), std::get<2>(y));
  };
  std::priority_queue<Way, std::vector<Way>, decltype(is_later)> ways(is_later);
  const auto look_around = [&](std::uint32_t chunk, bool of_b) {
    for (const std::uint32_t next : chunks_[chunk].beside)
      if (!is_of_b.contains(next))
        ways.emplace(saddle(chunk, next) / std::max(chunks_[chunk].half_width, chunks_[next].half_width),
                     next, of_b);
  };
  look_around(a, false);
  look_around(b, true);
  while (!ways.empty()) {
    const auto [width, chunk, of_b] = ways.top();
    ways.pop();
    if (!is_of_b.emplace(chunk, of_b).second) continue;
    if ((chunks_[chunk].seed.cast<double>() - place).cwiseProduct(edges_).norm() > reach) continue;
    sides[of_b ? 1 : 0].push_back(chunk);
    look_around(chunk, of_b);
  }
  const bool is_clear = are_apart(a, b);  // Else these may be parts of one vessel.
  const auto does_go_on = [&](const std::vector<std::uint32_t>& side) {
    return goes_on_from_wall(side, place) || (is_clear && goes_on_from_axis(side, place));
  };
  if (!does_go_on(sides[0]) || !does_go_on(sides[1])) return std::nullopt;
  return sides;
}

}  // namespace lumesh::image
