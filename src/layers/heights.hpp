#pragma once
/// @file Heights of the columns of layers, before any cell is looked at.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "directions.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/layers/layers.hpp"

namespace lumesh::layers {

/// Heights of the layers' upper ends over the surface, from the first one, in the unit of the options.
/// @param most  Where sizes choose the number: the height of the last layer at most; the first is there.
/// @throws Error{kBadInput} if no growth makes the thickness out of these layers.
[[nodiscard]] std::vector<double> height_schedule(const LayerOptions& options, double most = 0);

/// The outside of a mesh, for queries of near triangles.
struct Outside {
  TriangleTree tree;
  std::vector<Vec3> normals;  ///< Normals of the triangles, out of the mesh.

  Outside(const TetMesh& mesh, const BoundaryFaces& faces);

 private:
  Outside(std::span<const Vec3> points, const std::vector<Cell<3>>& triangles);
};

/// The layers of a column by its length, as a share of the length wanted.
class LayerProfile {
 public:
  enum class Shortening : std::uint8_t {
    kAllLayers,  ///< Every layer stays, in proportion to the length.
    kDropLate,   ///< The first has its height; those over it lose theirs until all are as high as the first,
                 ///< before the outermost goes.
    kDropEarly,  ///< The outermost loses height, down to half of it, before it goes.
  };
  LayerProfile() = default;
  /// @param levels  Upper end of each layer of a complete column; the last is 1.
  LayerProfile(std::vector<double> levels, Shortening shortening);

  [[nodiscard]] Shortening shortening() const { return shortening_; }
  [[nodiscard]] bool shrinks() const { return shortening_ == Shortening::kAllLayers; }
  [[nodiscard]] int layers() const { return static_cast<int>(levels_.size()); }
  /// Number of layers of a column.
  [[nodiscard]] int count(double fraction) const;
  /// The largest share up to this one that layers fill; 0: there are none.
  [[nodiscard]] double filled(double fraction) const;
  /// How layers fill a column.
  struct Filling {
    double fraction = 0;
    int count = 0;
    double of_excess = 1;  ///< Share of what layers wanted exceed the first one by.
  };
  [[nodiscard]] Filling filling(double fraction) const;
  /// Upper end of layer k of a column, or of its last one (k = -1: the surface).
  [[nodiscard]] double upper_end(const Filling& column, int k) const;
  /// Upper end of so many layers, as high as wanted.
  [[nodiscard]] double level(int count) const { return levels_[static_cast<std::size_t>(count - 1)]; }
  /// The least share of a column that has so many.
  [[nodiscard]] double least(int count) const { return least_[static_cast<std::size_t>(count - 1)]; }

 private:
  std::vector<double> levels_, least_;
  Shortening shortening_ = Shortening::kAllLayers;
};

/// Columns over a surface.
struct Columns {
  std::vector<double> wanted_mm;  ///< Length along the direction.
  std::vector<double> fraction;   ///< Share of it, 0 to 1; 0: no layers here.
  std::vector<double> asked;  ///< Share of it that is complete: 1, or less where sizes ask for fewer layers.
  std::vector<LayerLimit> limit;
  LayerProfile profile;

  [[nodiscard]] int count(std::size_t v) const { return profile.count(fraction[v]); }
  /// The most that a column has, at least one.
  [[nodiscard]] int max_count() const;
  /// Share of the thickness asked for.
  [[nodiscard]] double reached(std::size_t v) const { return fraction[v] / asked[v]; }
  /// Whether a triangle has layers at any of its corners.
  [[nodiscard]] bool has_layers(const Cell<3>& corners) const {
    return std::ranges::any_of(corners, [&](std::uint32_t v) { return fraction[v] > 0; });
  }
  [[nodiscard]] double length_mm(std::size_t v) const { return fraction[v] * wanted_mm[v]; }
  /// No column has a layer.
  [[nodiscard]] bool are_empty() const;
  /// Takes what columns have for all that is asked of them.
  void ask_for_what_is();
  /// Makes a column shorter, for a reason.
  void shorten(std::size_t v, double to_mm, LayerLimit why);
};

struct WantedColumns {
  std::vector<double> heights;  ///< Of the layers' upper ends, in the unit of the options.
  Columns columns;

  /// Takes layers that no column has out of the heights.
  void drop_unused_layers();
};
/// Columns as wanted, for each vertex; none where no direction keeps the first height.
[[nodiscard]] WantedColumns wanted_columns(const LayerSurface& surface, const Directions& directions,
                                           const LayerOptions& options, const Outside& outside);

/// Shortens columns whose upper ends would come too near to another part of the outside.
/// @param side  1 where layers grow out of the mesh, -1 into it: there some of the mesh has to be left.
void keep_from_other_sides(const LayerSurface& surface, const Directions& directions, const Outside& outside,
                           double side, Columns& columns);

/// Shortens columns until lengths differ by no more than a share of the edge between them, or by a layer, and
/// numbers of layers by no more than one.
void smooth_lengths(const LayerSurface& surface, Columns& columns);

}  // namespace lumesh::layers
