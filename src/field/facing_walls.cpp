#include "facing_walls.hpp"

#include <algorithm>
#include <unordered_map>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/sort_unique.hpp"

namespace lumesh::field {

namespace {

constexpr int kCube = 4;      // voxels along the edge of a supervoxel's cube
constexpr int kGapSteps = 5;  // walls grow so far into the background, as far as the band goes
constexpr int kMinWay = 4;    // supervoxels further apart than this on the way through the object are far
constexpr std::size_t kMinVoxels = 24;  // within that way of a supervoxel, else it is a speck
// Around supervoxels that face another part: whose function is the part's, with whose faces it is fitted,
// and what continues it.
constexpr int kInnerSteps = 1, kOwnSteps = 3, kMarginSteps = 4;
constexpr int kBoxMargin = 8;  // voxels: what is near the image's border stays as far from the box's

/// Way to the next voxel along x, y and z: its row, and the places along that.
struct Following {
  int row = -1;  // -1: the own one
  int shift = 0;
};
constexpr std::array<Following, 3> kFollowing = {{{-1, 1}, {kY1, 0}, {kZ1, 0}}};

bool is_in_band(const Band& band, Lane lane) {
  const int segment = lane / kLanes;
  return segment > 0 && segment < band.end() &&
         Band::has(static_cast<std::uint8_t>(band.alive(segment) & band.in_image(segment)), lane % kLanes);
}

/// Calls visit(lane, neighbour) for all pairs of object voxels that share a face.
template <class Visit>
void for_each_object_pair(const Band& band, const Visit& visit) {
  for (int s = 1; s < band.end(); ++s) {
    const std::uint8_t own = band.object(s);
    if (own == 0) continue;
    for (const Following& f : kFollowing) {
      const int segment = f.row < 0 ? s : band.rows(s)[static_cast<std::size_t>(f.row)];
      if (segment == 0) continue;
      for (int lane = 0; lane < kLanes; ++lane) {
        if (!Band::has(own, lane)) continue;
        // Lanes of the segments before and behind in memory are alive only where they are neighbours.
        const Lane other = segment * kLanes + lane + f.shift;
        if (other < band.end() * kLanes && band.is_object(other)) visit(s * kLanes + lane, other);
      }
    }
  }
}

template <class Visit>
void for_each_face_neighbour(const Band& band, Lane lane, const Visit& visit) {
  const auto& rows = band.rows(lane / kLanes);
  const int place = lane % kLanes;
  for (const Lane other : {lane - 1, lane + 1}) visit(other);
  for (const Row row : {kY1, kYm, kZ1, kZm})
    if (rows[row] != 0) visit(rows[row] * kLanes + place);
}

}  // namespace

FacingWalls::FacingWalls(const Band& band) : band_(band) {
  find_cells();
  find_neighbours();
  const parallel::Adjacency facing = facing_cells();
  if (facing.items.empty()) return;
  lanes_ = parallel::group_by_owner(cell_of_.size(), cell_count_, [&](std::size_t lane) {
    const bool counts = cell_of_[lane] != 0 && band_.is_object(static_cast<Lane>(lane));
    return std::span<const Cell>(&cell_of_[lane], counts ? 1 : 0);
  });
  choose_parts(facing);
}

void FacingWalls::find_cells() {
  const std::size_t lanes = band_.segment_count() * kLanes;
  DisjointSets sets(lanes);
  std::vector<std::uint64_t> cube(lanes, 0);
  for (int s = 1; s < band_.end(); ++s) {
    const std::uint8_t own = band_.object(s);
    for (int lane = 0; own != 0 && lane < kLanes; ++lane) {
      if (!Band::has(own, lane)) continue;
      const Index3 c = band_.voxel(s * kLanes + lane) / kCube;
      cube[static_cast<std::size_t>(s) * kLanes + static_cast<std::size_t>(lane)] =
          static_cast<std::uint64_t>(c.x()) | static_cast<std::uint64_t>(c.y()) << 20U |
          static_cast<std::uint64_t>(c.z()) << 40U;
    }
  }
  for_each_object_pair(band_, [&](Lane a, Lane b) {
    if (cube[static_cast<std::size_t>(a)] == cube[static_cast<std::size_t>(b)])
      sets.merge(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
  });
  cell_of_.assign(lanes, 0);
  Cell next = 1;
  for (int s = 1; s < band_.end(); ++s) {
    const std::uint8_t own = band_.object(s);
    for (int lane = 0; own != 0 && lane < kLanes; ++lane) {
      if (!Band::has(own, lane)) continue;
      const auto at = static_cast<std::uint32_t>(s * kLanes + lane);
      const std::uint32_t root = sets.find(at);
      cell_of_[at] = root == at ? next++ : cell_of_[root];  // The lowest lane is the root.
    }
  }
  cell_count_ = next;
  voxels_of_.assign(cell_count_, 0);
  for (const Cell cell : cell_of_) ++voxels_of_[cell];
}

void FacingWalls::find_neighbours() {
  std::vector<std::array<Cell, 2>> pairs;
  for_each_object_pair(band_, [&](Lane a, Lane b) {
    const Cell one = cell_of_[static_cast<std::size_t>(a)], other = cell_of_[static_cast<std::size_t>(b)];
    if (one == other) return;
    const std::array<Cell, 2> pair = {std::min(one, other), std::max(one, other)};
    if (pairs.empty() || pairs.back() != pair) pairs.push_back(pair);
  });
  sort_unique(pairs);
  const parallel::Adjacency of_pairs = parallel::cells_around(pairs, cell_count_);
  neighbours_ = parallel::collect_lists(cell_count_, [&](std::size_t cell, std::vector<std::uint32_t>& out) {
    for (const std::uint32_t p : of_pairs.of(cell)) out.push_back(pairs[p][pairs[p][0] == cell ? 1 : 0]);
  });
}

/// Each supervoxel grows into the background. Grown ones that touch have met; neighbours do not count.
std::vector<std::array<FacingWalls::Cell, 2>> FacingWalls::met_cells() {
  std::vector<std::array<Cell, 2>> met;
  std::array<Cell, 2> last = {};
  std::vector<Lane> front, next;
  for (Lane lane = 0; lane < static_cast<Lane>(cell_of_.size()); ++lane)
    if (cell_of_[static_cast<std::size_t>(lane)] != 0) front.push_back(lane);
  const auto grow = [&](Lane lane, Lane other) {
    if (!is_in_band(band_, other)) return;
    const Cell own = cell_of_[static_cast<std::size_t>(lane)];
    Cell& reached = cell_of_[static_cast<std::size_t>(other)];
    if (reached == 0) {
      reached = own;
      next.push_back(other);
    } else if (reached != own && !(band_.is_object(lane) && band_.is_object(other))) {
      const std::array<Cell, 2> pair = {std::min(own, reached), std::max(own, reached)};
      if (pair == last) return;
      last = pair;
      if (!are_neighbours(own, reached)) met.push_back(pair);
    }
  };
  for (int step = 0; step < kGapSteps; ++step, std::swap(front, next)) {
    next.clear();
    for (const Lane lane : front)
      for_each_face_neighbour(band_, lane, [&](Lane other) { grow(lane, other); });
    sort_unique(met);
  }
  // Nor do those face each other that hang together by a third one.
  std::erase_if(met, [&](const std::array<Cell, 2>& pair) {
    return std::ranges::any_of(neighbours_.of(pair[0]),
                               [&](Cell between) { return are_neighbours(between, pair[1]); });
  });
  return met;
}

bool FacingWalls::are_neighbours(Cell a, Cell b) const {
  return std::ranges::find(neighbours_.of(a), b) != neighbours_.of(a).end();
}

parallel::Adjacency FacingWalls::facing_cells() {
  const std::vector<std::array<Cell, 2>> met = met_cells();
  // Those that hang together near by are one wall, and specks are noise.
  const parallel::Adjacency of_pairs = parallel::cells_around(met, cell_count_);
  std::vector<std::uint8_t> far_ends(met.size(), 0);
  for (Cell cell = 1; cell < cell_count_; ++cell) {
    const auto pairs = of_pairs.of(cell);
    if (pairs.empty()) continue;
    const std::vector<NearCell> near = around({cell}, kMinWay);
    std::size_t voxels = 0;
    for (const NearCell& n : near) voxels += voxels_of_[n.cell];
    if (voxels < kMinVoxels) continue;
    for (const std::uint32_t p : pairs) {
      const Cell other = met[p][met[p][0] == cell ? 1 : 0];
      if (!std::ranges::binary_search(near, other, {}, &NearCell::cell)) ++far_ends[p];
    }
  }
  return parallel::collect_lists(cell_count_, [&](std::size_t cell, std::vector<std::uint32_t>& out) {
    for (const std::uint32_t p : of_pairs.of(cell))
      if (far_ends[p] == 2) out.push_back(met[p][met[p][0] == cell ? 1 : 0]);
  });
}

std::vector<FacingWalls::NearCell> FacingWalls::around(const std::vector<Cell>& start, int max_steps) const {
  std::vector<NearCell> found;
  std::unordered_map<Cell, int> steps;
  for (const Cell cell : start) {
    found.push_back({cell, 0});
    steps.emplace(cell, 0);
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    const NearCell from = found[i];
    if (from.steps == max_steps) break;
    for (const Cell other : neighbours_.of(from.cell))
      if (steps.emplace(other, from.steps + 1).second) found.push_back({other, from.steps + 1});
  }
  std::ranges::sort(found, {}, &NearCell::cell);
  return found;
}

/// Less those from which the way to what the part faces is short: near the rod that joins two vessels, or the
/// turns of a tight coil, the common function stays. Nothing if those are more than half.
std::vector<FacingWalls::NearCell> FacingWalls::with_surroundings(std::vector<Cell> core,
                                                                  const parallel::Adjacency& facing) const {
  std::vector<Cell> faced;
  for (const Cell cell : core) faced.insert(faced.end(), facing.of(cell).begin(), facing.of(cell).end());
  sort_unique(faced);
  const std::vector<NearCell> near_faced = around(faced, kMarginSteps);
  const std::size_t trimmed = std::erase_if(
      core, [&](Cell c) { return std::ranges::binary_search(near_faced, c, {}, &NearCell::cell); });
  if (trimmed > core.size()) core.clear();
  return around(core, kMarginSteps);
}

void FacingWalls::choose_parts(const parallel::Adjacency& facing) {
  constexpr std::uint32_t kNone = ~0U;
  std::vector<std::uint32_t> part_of(cell_count_, kNone);
  for (Cell seed = 1; seed < cell_count_; ++seed) {
    if (facing.of(seed).empty() || part_of[seed] != kNone) continue;
    const std::uint32_t part = seed;
    const auto faces_another = [&](Cell cell) { return !facing.of(cell).empty(); };
    const auto may_join = [&](Cell cell) {
      return part_of[cell] == kNone &&
             (faces_another(cell) || std::ranges::any_of(neighbours_.of(cell), faces_another)) &&
             std::ranges::none_of(facing.of(cell), [&](Cell other) { return part_of[other] == part; });
    };
    std::vector<Cell> core = {seed};
    part_of[seed] = part;
    for (std::size_t i = 0; i < core.size(); ++i)
      for (const Cell other : neighbours_.of(core[i]))
        if (may_join(other)) {
          part_of[other] = part;
          core.push_back(other);
        }
    if (auto cells = with_surroundings(std::move(core), facing); !cells.empty())
      parts_.push_back(std::move(cells));
  }
}

bool FacingWalls::is_of_part(Lane lane, std::size_t number) const {
  const Lane inside = band_.lane_of(nearest_place(band_.image().frame().size, band_.voxel(lane)));
  const Cell cell = cell_of_[static_cast<std::size_t>(inside)];
  const auto& cells = parts_[number];
  const auto found = std::ranges::lower_bound(cells, cell, {}, &NearCell::cell);
  return cell == 0 || (found != cells.end() && found->cell == cell && found->steps <= kOwnSteps);
}

WallPart FacingWalls::part(std::size_t number) const {
  const auto for_each_lane = [&](const auto& visit) {
    for (const NearCell& near : parts_[number])
      for (const std::uint32_t lane : lanes_.of(near.cell))
        visit(static_cast<Lane>(lane), band_.voxel(static_cast<Lane>(lane)), near.steps);
  };
  VoxelBox box = VoxelBox::nothing();
  for_each_lane([&](Lane, const Index3& voxel, int) { box.add(voxel, voxel + Index3::Ones()); });
  const LabelImage& image = band_.image();
  const ImageFrame& whole = image.frame();
  WallPart part;
  part.first = (box.low - Index3::Constant(kBoxMargin)).cwiseMax(0);
  ImageFrame frame = whole;
  frame.size = (box.high + Index3::Constant(kBoxMargin)).cwiseMin(whole.size) - part.first;
  part.image = LabelImage(frame, {kBackground, WallPart::kMargin, WallPart::kInner});
  struct PlacedFace {
    std::size_t voxel = 0;
    Face face;
    float crossing = 0;
  };
  std::vector<PlacedFace> faces;
  const auto add_face = [&](Lane lane, int axis) {
    if (!Band::has(band_.faces(lane / kLanes, axis), lane % kLanes)) return;
    const Index3 voxel = band_.voxel(lane) - part.first;
    faces.push_back({frame.offset(voxel), {voxel, axis}, band_.crossing(lane, axis)});
  };
  for_each_lane([&](Lane lane, const Index3& voxel, int steps) {
    part.image.at(voxel - part.first) = steps <= kInnerSteps ? WallPart::kInner : WallPart::kMargin;
    // What is too deep for the band is of the object, too.
    for_each_place(voxel - Index3::Ones(), voxel + Index3::Ones(), [&](const Index3& beside) {
      if (whole.contains(beside) && image.at(beside) != 0 && !band_.is_object(band_.lane_of(beside)))
        part.image.at(beside - part.first) = WallPart::kMargin;
    });
    for (int axis = 0; steps <= kOwnSteps && axis < 3; ++axis) {
      add_face(lane, axis);
      const Index3 back = -Index3::Unit(axis);
      if (const Lane before = band_.neighbour(lane, back.x(), back.y(), back.z()); before >= kLanes)
        add_face(before, axis);
    }
  });
  std::ranges::sort(faces, [](const PlacedFace& a, const PlacedFace& b) {
    return std::tie(a.voxel, a.face.axis) < std::tie(b.voxel, b.face.axis);
  });
  for (const PlacedFace& f : faces) {
    part.faces.faces.push_back(f.face);
    if (band_.has_crossings()) part.faces.crossings.push_back(f.crossing);
  }
  return part;
}

}  // namespace lumesh::field
