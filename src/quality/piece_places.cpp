// Pieces too many and too few, and where others are joined or split.
#include <algorithm>
#include <map>
#include <set>

#include "lumesh/core/disjoint_sets.hpp"
#include "pieces.hpp"
#include "rows_of_tetrahedron.hpp"

namespace lumesh::quality {

namespace {

/// Where paths from two parts meet: two nodes next to each other, or one that both begin with.
struct Meeting {
  std::uint32_t hops = 0;
  std::array<std::uint32_t, 2> parts = {};
  std::array<std::size_t, 2> nodes = {};
};

/// Fewest meetings that join all parts that paths can join, each of the shortest path. @param owner  Per node
/// the part that begins there, or kNoPiece; filled in for the nodes that are reached. @param
/// for_each_neighbour Gives the nodes that a path may go on to.
template <class ForEachNeighbour>
std::vector<Meeting> find_meetings(std::vector<std::uint32_t>& owner, std::vector<std::size_t> front,
                                   std::vector<Meeting> candidates,
                                   const ForEachNeighbour& for_each_neighbour) {
  for (std::uint32_t hops = 0; !front.empty(); ++hops) {
    std::vector<std::size_t> next;
    for (const std::size_t node : front)
      for_each_neighbour(node, [&](std::size_t beside) {
        if (owner[beside] == kNoPiece) {
          owner[beside] = owner[node];
          next.push_back(beside);
        } else if (owner[beside] != owner[node]) {
          candidates.push_back({hops, {owner[node], owner[beside]}, {node, beside}});
        }
      });
    front.swap(next);
  }
  std::ranges::stable_sort(candidates, [](const Meeting& a, const Meeting& b) { return a.hops < b.hops; });
  std::map<std::uint32_t, std::uint32_t> number;
  for (const Meeting& m : candidates)
    for (const std::uint32_t part : m.parts) number.emplace(part, static_cast<std::uint32_t>(number.size()));
  DisjointSets sets(number.size());
  std::vector<Meeting> kept;
  for (const Meeting& m : candidates) {
    const std::uint32_t a = number[m.parts[0]], b = number[m.parts[1]];
    if (sets.find(a) == sets.find(b)) continue;
    sets.merge(a, b);
    kept.push_back(m);
  }
  return kept;
}

struct PieceSize {
  std::uint64_t count = 0;  // Cells or voxels.
  double volume_mm3 = 0;
  Vec3 middle = Vec3::Zero();  // By volume: mm of cells, indices of voxels.
  VoxelBox box = VoxelBox::nothing();
  Label label = kBackground;
};

class PiecePlaces {
 public:
  PiecePlaces(const MeshView& mesh, const LabelImage& image, std::span<const TopologyDifference> differences)
      : cells_(mesh),
        mesh_(mesh),
        image_(image),
        voxels_(image),
        cell_pieces_(find_cell_pieces(mesh, differences)) {
    for (const TopologyDifference& d : differences) labels_.insert(d.label);
  }

  std::vector<TopologyPlace> run() {
    measure_voxels();
    measure_cells();
    link();
    add_extra();
    add_missing();
    add_joined();
    add_split();
    return std::move(places_);
  }

 private:
  void measure_voxels() {
    const image::RunImage& runs = voxels_.runs();
    image::for_each_run(runs, [&](std::uint32_t r, int j, int k) {
      const image::Run& run = runs.runs[r];
      const Label label = image_.values()[run.label];
      if (!labels_.contains(label)) return;
      PieceSize& size = of_voxels_[voxels_.piece_of_run(r)];
      const auto count = static_cast<double>(run.end - run.begin);
      size.label = label;
      size.count += static_cast<std::uint64_t>(run.end - run.begin);
      size.middle += count * Vec3((run.begin + run.end - 1) / 2.0, j, k);
      size.box.add({run.begin, j, k}, {run.end, j + 1, k + 1});
    });
    for (auto& [piece, size] : of_voxels_) {
      size.middle /= static_cast<double>(size.count);
      size.volume_mm3 = static_cast<double>(size.count) * image_.frame().voxel_volume_mm3();
    }
  }

  void measure_cells() {
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
      if (cell_pieces_.piece[cell] == kNoPiece) continue;
      PieceSize& size = of_cells_[cell_pieces_.piece[cell]];
      const double volume = std::max(cells_.volume(cell), 0.0);
      size.label = cells_.label(cell);
      ++size.count;
      size.volume_mm3 += volume;
      size.middle += volume * centre_of(cell);
      for (const Cell<3>& triangle : cells_.triangles(cell))
        for (const std::uint32_t v : triangle) {
          const Index3 voxel = voxel_at(mesh_.points[v]);
          size.box.add(voxel, voxel + Index3::Ones());
        }
    }
    for (auto& [piece, size] : of_cells_)
      size.middle = size.volume_mm3 > 0 ? Vec3(size.middle / size.volume_mm3) : centre_of(piece);
  }

  /// Which voxels' centres cells of their label hold.
  void link() {
    held_by_.assign(voxels_.voxel_count(), kNoPiece);
    holds_.assign(cells_.size(), kNoPiece);
    std::vector<Vec3> points(mesh_.points.size());
    for (std::size_t v = 0; v < points.size(); ++v) points[v] = image_.frame().to_index(mesh_.points[v]);
    for (std::size_t cell = 0; cell < cells_.size(); ++cell)
      if (cell_pieces_.piece[cell] != kNoPiece)
        for_each_tetrahedron(mesh_, cells_, cell, points, [&](const RowsOfTetrahedron& rows) {
          for_each_held_run(rows, voxels_.runs(), [&](std::size_t r, std::int32_t begin, std::int32_t end) {
            if (image_.values()[voxels_.runs().runs[r].label] == cells_.label(cell))
              link_run(r, begin, end, cell);
          });
        });
  }

  /// @param begin, end  The voxels of the run that the cell holds.
  void link_run(std::size_t r, std::int32_t begin, std::int32_t end, std::size_t cell) {
    const std::uint32_t voxel_piece = voxels_.piece_of_run(r), cell_piece = cell_pieces_.piece[cell];
    linked_.insert({voxel_piece, cell_piece});
    if (holds_[cell] == kNoPiece)
      holds_[cell] = voxel_piece;
    else if (holds_[cell] != voxel_piece)
      joined_in_cells_.push_back({0, {holds_[cell], voxel_piece}, {cell, cell}});
    const std::size_t first = voxels_.first_number(r);
    for (std::int32_t i = begin; i < end; ++i) {
      const std::size_t number = first + static_cast<std::size_t>(i - voxels_.runs().runs[r].begin);
      if (held_by_[number] == kNoPiece)
        held_by_[number] = cell_piece;
      else if (held_by_[number] != cell_piece)
        split_in_voxels_.push_back({0, {held_by_[number], cell_piece}, {number, number}});
    }
  }

  void add_extra() {
    std::set<std::uint32_t> linked;
    for (const auto& [voxel_piece, cell_piece] : linked_) linked.insert(cell_piece);
    add_alone(of_cells_, linked, TopologyChange::kExtraPiece);
  }
  void add_missing() {
    std::set<std::uint32_t> linked;
    for (const auto& [voxel_piece, cell_piece] : linked_) linked.insert(voxel_piece);
    add_alone(of_voxels_, linked, TopologyChange::kMissingPiece);
  }
  /// The largest first.
  void add_alone(const std::map<std::uint32_t, PieceSize>& sizes, const std::set<std::uint32_t>& linked,
                 TopologyChange change) {
    const std::size_t begin = places_.size();
    for (const auto& [piece, size] : sizes)
      if (!linked.contains(piece))
        add(change, size, size.box,
            change == TopologyChange::kExtraPiece ? size.middle : image_.frame().to_physical(size.middle));
    std::stable_sort(places_.begin() + static_cast<std::ptrdiff_t>(begin), places_.end(),
                     [](const auto& a, const auto& b) { return a.volume_mm3 > b.volume_mm3; });
  }

  void add_joined() {
    std::map<std::uint32_t, int> parts;
    for (const auto& [voxel_piece, cell_piece] : linked_) ++parts[cell_piece];
    std::vector<std::uint32_t> owner(cells_.size(), kNoPiece);
    std::vector<std::size_t> front;
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
      const auto of_cell = parts.find(cell_pieces_.piece[cell]);
      if (of_cell == parts.end() || of_cell->second < 2 || holds_[cell] == kNoPiece) continue;
      owner[cell] = holds_[cell];
      front.push_back(cell);
    }
    const auto for_each_neighbour = [&](std::size_t cell, const auto& use) {
      for (const std::uint32_t other : cell_pieces_.neighbours.of(cell)) use(std::size_t{other});
    };
    for (const Meeting& m : find_meetings(owner, front, joined_in_cells_, for_each_neighbour)) {
      const Vec3 centre_mm = (centre_of(m.nodes[0]) + centre_of(m.nodes[1])) / 2;
      add(TopologyChange::kJoined, smaller(of_voxels_, m), around(centre_mm), centre_mm);
    }
  }

  void add_split() {
    std::map<std::uint32_t, int> parts;
    for (const auto& [voxel_piece, cell_piece] : linked_) ++parts[voxel_piece];
    std::vector<std::uint32_t> owner = held_by_;
    std::vector<std::size_t> front;
    for (std::size_t r = 0; r < voxels_.runs().runs.size(); ++r) {
      const auto of_run = parts.find(voxels_.piece_of_run(r));
      if (of_run == parts.end() || of_run->second < 2) continue;
      for (std::size_t v = voxels_.first_number(r); v < voxels_.first_number(r + 1); ++v)
        if (owner[v] != kNoPiece) front.push_back(v);
    }
    const auto for_each_neighbour = [&](std::size_t number, const auto& use) {
      const Index3 place = voxels_.place_of(number);
      const std::uint32_t piece = voxels_.piece_of_run(voxels_.run_of(number));
      for (int axis = 0; axis < 3; ++axis)
        for (const int step : {-1, 1}) {
          const std::size_t beside = voxels_.number_at(place + step * Index3::Unit(axis));
          if (beside < voxels_.voxel_count() && voxels_.piece_of_run(voxels_.run_of(beside)) == piece)
            use(beside);
        }
    };
    for (const Meeting& m : find_meetings(owner, front, split_in_voxels_, for_each_neighbour)) {
      const Vec3 middle = (voxels_.place_of(m.nodes[0]) + voxels_.place_of(m.nodes[1])).cast<double>() / 2;
      const Vec3 centre_mm = image_.frame().to_physical(middle);
      add(TopologyChange::kSplit, smaller(of_cells_, m), around(centre_mm), centre_mm);
    }
  }

  static const PieceSize& smaller(const std::map<std::uint32_t, PieceSize>& sizes, const Meeting& m) {
    const PieceSize &a = sizes.at(m.parts[0]), &b = sizes.at(m.parts[1]);
    return a.volume_mm3 < b.volume_mm3 ? a : b;
  }

  void add(TopologyChange change, const PieceSize& size, const VoxelBox& box, const Vec3& centre_mm) {
    TopologyPlace place{.label = size.label, .change = change, .centre_mm = centre_mm, .box = box};
    const bool is_of_mesh = change == TopologyChange::kExtraPiece || change == TopologyChange::kSplit;
    (is_of_mesh ? place.cells : place.voxels) = size.count;
    place.volume_mm3 = size.volume_mm3;
    places_.push_back(place);
  }

  [[nodiscard]] VoxelBox around(const Vec3& point_mm) const {
    const Index3 voxel = voxel_at(point_mm);
    return {voxel, voxel + Index3::Ones()};
  }
  [[nodiscard]] Index3 voxel_at(const Vec3& point_mm) const {
    const Vec3 index = image_.frame().to_index(point_mm).array().round();
    return index.cwiseMax(-1e9).cwiseMin(1e9).cast<int>();
  }
  [[nodiscard]] Vec3 centre_of(std::size_t cell) const {
    const CellTriangles sides = cells_.triangles(cell);
    Vec3 sum = Vec3::Zero();
    for (const auto& [a, b, c] : sides) sum += mesh_.points[a] + mesh_.points[b] + mesh_.points[c];
    return sum / (3 * sides.count);
  }

  AllCells cells_;
  const MeshView& mesh_;
  const LabelImage& image_;
  VoxelPieces voxels_;
  CellPieces cell_pieces_;
  std::set<Label> labels_;
  std::map<std::uint32_t, PieceSize> of_voxels_, of_cells_;
  std::vector<std::uint32_t> held_by_;             // Per voxel: a piece of the mesh.
  std::vector<std::uint32_t> holds_;               // Per cell: a piece of the voxels.
  std::set<std::array<std::uint32_t, 2>> linked_;  // Of voxels, of the mesh.
  std::vector<Meeting> joined_in_cells_, split_in_voxels_;
  std::vector<TopologyPlace> places_;
};

}  // namespace

std::vector<TopologyPlace> find_piece_places(const MeshView& mesh, const LabelImage& image,
                                             std::span<const TopologyDifference> differences) {
  return PiecePlaces(mesh, image, differences).run();
}

}  // namespace lumesh::quality
