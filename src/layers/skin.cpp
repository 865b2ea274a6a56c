#include <algorithm>

#include "columns.hpp"
#include "lumesh/geometry/triangle_intersection.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::layers {
namespace {

/// The outer skin, its sides at the rim, the surface under it and the rest of the outside, as triangles in
/// space.
class Skin {
 public:
  Skin(const ExtrusionFrame& frame, const Columns& columns) : surface_(frame.surface) {
    const std::size_t count = surface_.points.size();
    for (std::size_t v = 0; v < count; ++v) points_.push_back(frame.tip(columns, v));
    has_layers_.resize(surface_.triangles.size());
    for (std::size_t t = 0; t < surface_.triangles.size(); ++t) {
      const Cell<3>& c = surface_.triangles[t];
      has_layers_[t] = columns.has_layers(c) ? 1 : 0;
      add(c, c);
      feet_.push_back(c);
    }
  }

  /// Adds the sides over the rim, and the outside, which must not be cut either.
  void add_sides_and_outside(const TetMesh& mesh, const Columns& columns) {
    add_sides(columns);
    const auto base = static_cast<std::uint32_t>(points_.size());
    points_.insert(points_.end(), surface_.points.begin(), surface_.points.end());
    for (const Cell<3>& c : surface_.triangles) add({c[0] + base, c[1] + base, c[2] + base}, c);
    for (const Cell<3>& c : surface_.others) {
      const auto first = static_cast<std::uint32_t>(points_.size());
      for (const std::uint32_t v : c) points_.push_back(mesh.point(VertexId(v)));
      triangles_.push_back({first, first + 1, first + 2});
      columns_.push_back(c);
    }
  }

  /// One flag per column of the surface: whether a triangle of the skin over it cuts something.
  [[nodiscard]] std::vector<std::uint8_t> columns_that_cut() const {
    const TriangleTree tree(points_, triangles_);
    std::vector<std::uint8_t> flags(surface_.points.size(), 0);
    parallel::for_each_index(has_layers_.size(), 64, [&](std::size_t t) {
      if (has_layers_[t] == 0) return;
      for (const std::uint32_t other : cut_by(tree, static_cast<std::uint32_t>(t))) {
        raise_at(t, flags);
        if (other < has_layers_.size()) raise_at(other, flags);
      }
    });
    return flags;
  }

 private:
  /// @param feet  Their columns' numbers in the surface.
  void add(const Cell<3>& corners, const Cell<3>& feet) {
    triangles_.push_back(corners);
    columns_.push_back({surface_.vertices[feet[0]], surface_.vertices[feet[1]], surface_.vertices[feet[2]]});
  }
  void add_sides(const Columns& columns) {
    const auto base = static_cast<std::uint32_t>(points_.size());
    points_.insert(points_.end(), surface_.points.begin(), surface_.points.end());
    for (const auto& [a, b, patch] : surface_.rim) {
      if (columns.fraction[a] > 0) add_side({a + base, b + base, a}, {a, b, a});
      if (columns.fraction[b] > 0) add_side({b + base, b, columns.fraction[a] > 0 ? a : a + base}, {b, b, a});
    }
  }
  void add_side(const Cell<3>& corners, const Cell<3>& feet) {
    add(corners, feet);
    has_layers_.push_back(1);
    feet_.push_back(feet);
  }
  [[nodiscard]] std::vector<std::uint32_t> cut_by(const TriangleTree& tree, std::uint32_t t) const {
    const auto corner = [&](std::uint32_t of, std::size_t k) -> const Vec3& {
      return points_[triangles_[of][k]];
    };
    const Vec3 low = corner(t, 0).cwiseMin(corner(t, 1)).cwiseMin(corner(t, 2)),
               high = corner(t, 0).cwiseMax(corner(t, 1)).cwiseMax(corner(t, 2));
    std::vector<std::uint32_t> found = tree.overlapping(low, high);
    std::erase_if(found, [&](std::uint32_t other) {
      if (other == t) return true;
      if (other < has_layers_.size() && has_layers_[other] == 0) return true;  // It is the surface there.
      const std::array<Vec3, 3> a = {corner(t, 0), corner(t, 1), corner(t, 2)},
                                b = {corner(other, 0), corner(other, 1), corner(other, 2)};
      return shares_column(t, other) ? !meet_around_corner(a, b) : !triangles_meet(a, b);
    });
    return found;
  }
  [[nodiscard]] bool shares_column(std::uint32_t a, std::uint32_t b) const {
    return std::ranges::any_of(
        columns_[a], [&](std::uint32_t v) { return std::ranges::find(columns_[b], v) != columns_[b].end(); });
  }
  /// Whether neighbours with one corner in common meet in more. Those with an edge touch by construction, and
  /// whether they fold is the cells' matter.
  [[nodiscard]] static bool meet_around_corner(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
    std::size_t common = 0, of_a = 0, of_b = 0;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        if (a[i] != b[k]) continue;
        ++common;
        of_a = i;
        of_b = k;
      }
    if (common != 1) return false;
    const auto next = [](std::size_t i, std::size_t by) { return (i + by) % 3; };
    return segment_meets_triangle(a[next(of_a, 1)], a[next(of_a, 2)], b[0], b[1], b[2]) ||
           segment_meets_triangle(b[next(of_b, 1)], b[next(of_b, 2)], a[0], a[1], a[2]);
  }
  void raise_at(std::size_t t, std::vector<std::uint8_t>& flags) const {
    for (const std::uint32_t v : feet_[t]) parallel::raise(flags[v]);
  }

  const LayerSurface& surface_;
  std::vector<Vec3> points_;
  std::vector<Cell<3>> triangles_;        // Of the skin, the sides, then of the surface, then of the rest.
  std::vector<Cell<3>> columns_;          // The mesh's vertices under the corners.
  std::vector<Cell<3>> feet_;             // Of the skin and the sides: their columns' numbers in the surface.
  std::vector<std::uint8_t> has_layers_;  // Of these, too.
};

}  // namespace

void keep_skin_simple(const ExtrusionFrame& frame, const TetMesh* outside, Columns& columns) {
  constexpr double kShorter = 0.7;
  constexpr int kPatientRounds = 12;
  for (int round = 0;; ++round) {  // Ends: as for cells.
    Skin skin(frame, columns);
    if (outside != nullptr) skin.add_sides_and_outside(*outside, columns);
    const std::vector<std::uint8_t> cuts = skin.columns_that_cut();
    if (std::ranges::find(cuts, 1) == cuts.end()) return;
    const double factor = round < kPatientRounds ? kShorter : 0;
    parallel::for_each_index(cuts.size(), [&](std::size_t v) {
      if (cuts[v] != 0) columns.shorten(v, factor * columns.length_mm(v), LayerLimit::kSkin);
    });
    if (round < kPatientRounds || !columns.profile.shrinks()) smooth_lengths(frame.surface, columns);
    keep_cells_well_shaped(frame, columns);
  }
}

}  // namespace lumesh::layers
