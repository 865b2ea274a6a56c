#pragma once
/// @file Boundary layers on the surface of a mesh, the role of AFLR in the paper (section 3.2).

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh {

enum class LayerCells : std::uint8_t {
  kPrisms,      ///< Prisms; pyramids and tetrahedra where columns shrink to nothing.
  kTetrahedra,  ///< Each prism as three tetrahedra, diagonals from the lower numbered column.
};

/// The side of the surface that layers grow on.
enum class LayerSide : std::uint8_t {
  kOutward,  ///< Out of the mesh, into free space.
  kInward,  ///< Into the mesh, which is deformed: layers and the rest of it fill the volume it filled before.
};

/// The unit of heights.
enum class HeightScale : std::uint8_t {
  kAbsolute,  ///< Millimetres.
  kRadius,    ///< The local radius: half the way to the opposite side of the object.
  kEdge,      ///< The mean length of the surface's edges around.
};

/// Part that a column of layers gives up where it cannot be as long as wanted.
enum class ShortOfRoom : std::uint8_t {
  kDrop,    ///< Outer layers; the first height is kept.
  kShrink,  ///< The height of all layers alike.
};

class OptionList;

/// Options of grow_layers(); describe() says what those mean that are not commented here.
struct LayerOptions {
  std::vector<std::string> patches = {};  ///< Patches that layers grow on; empty: all walls.
  LayerSide side = LayerSide::kOutward;
  Label into = kBackground;  ///< Inwards, where a mesh has several labels: the one that is deformed; 0: all
                             ///< at the patches, as one.
  double first_height = 0;   ///< > 0 for grow_layers(); in mm, or times the scale.
  double growth = 1.2;
  double growth_rise = 1;
  int constant_layers = 5;
  double max_growth = 1.5;
  int count = 0;         ///< 0: as many as the thickness asks for.
  double thickness = 0;  ///< 0: as the count makes it; neither: layers grow until they are as high as edges.
  HeightScale scale = HeightScale::kAbsolute;
  ShortOfRoom short_of_room = ShortOfRoom::kDrop;
  LayerCells cells = LayerCells::kTetrahedra;
  Label label = 0;  ///< Label of the layers, also one that is there; 0: one more than the largest.
  /// Whether the ring of layers around an opening is a patch of its own, OPENING_layer. Else it belongs to
  /// the opening, but where layers outwards have a label that the mesh has not: these are a wall around it.
  bool splits_openings = false;
  std::string label_name = {};  ///< Empty: the label's own, or "vessel_wall" outwards, "layer" inwards.
  struct Aflr {
    int mbl = 1, fints = 0;
    bool open = false;
  } aflr = {};  ///< AFLR's parameters of fixed value, accepted for its command lines.

  /// Whether the sizes of the surface choose the number of layers, place by place.
  [[nodiscard]] bool counts_by_sizes() const { return count == 0 && thickness == 0; }

  /// Without the labels.
  void describe(OptionList& list);
  void validate() const;  ///< Throws Error that names the field.
};

/// The reason why a column of layers is thinner than was asked for.
enum class LayerLimit : std::uint8_t {
  kNone,
  kOtherSide,  ///< Another part of the surface is near: the layers of both would meet.
  kRidge,      ///< No direction sees all triangles around.
  kRim,        ///< The column is beside a patch that is not flat, which it would cut off.
  kShape,      ///< Cells would turn over or become poor.
  kSkin,       ///< The outer surface would intersect itself or another part of the surface.
  kRoom,       ///< The mesh within could not be deformed as far.
  kNeighbour,  ///< Heights change gradually; a column nearby is limited.
};
inline constexpr std::size_t kLayerLimits = 8;
[[nodiscard]] const char* name_of(LayerLimit limit);

/// The layers achieved on one patch.
struct LayerCoverage {
  std::string patch;
  double area_mm2 = 0;
  int layers = 0;          ///< Number of layers wanted, the most of all columns.
  double mean_layers = 0;  ///< Number of layers, the mean over the area.
  double all_layers = 0;   ///< Share of the area with all layers wanted.
  double layered = 0;      ///< Share of the area with layers, however few or thin.
  /// Share of the layered area whose cells next to the surface are as high in the mean as asked for, to 2 %.
  double first_kept = 0;
  double min_first = 0;       ///< Lowest first height over any triangle, as a share of that asked for.
  double greatest_first = 0;  ///< The highest: in creases, columns that reach one triangle overreach another.
  double wanted_mm = 0, achieved_mm = 0;  ///< Thickness, the mean over the area.
  double min_mm = 0;                      ///< Lowest thickness of its columns.
  double complete = 0;                    ///< Share of the area whose columns have 98 % of the height wanted.
  double unlayered = 0;                   ///< Share of the area without layers.
  std::array<double, kLayerLimits> limited = {};  ///< Shares of the area by reason, kNone left out.
  struct Place {
    Vec3 at = Vec3::Zero();
    double achieved = 0;  ///< Share of the thickness wanted.
    LayerLimit why = LayerLimit::kNone;
  };
  std::vector<Place> worst;  ///< A few, apart from each other.
};

/// Shares of the thickness achieved, place by place on the surface that layers grew on.
struct LayerShares {
  std::vector<Vec3> points;        ///< Points of the surface in mm.
  std::vector<Cell<3>> triangles;  ///< Indices of points, anticlockwise seen from outside the mesh.
  std::vector<double> of_points;   ///< One per point: share of the thickness wanted, 0 to 1; 0: no layers.
};

struct LayerReport {
  int layers = 0;
  std::vector<double> heights;  ///< Height of each layer of a complete column, in mm or times the scale.
  std::vector<LayerCoverage> patches;
  std::uint64_t cells = 0;          ///< Number of cells of the layers.
  std::uint64_t core_pyramids = 0;  ///< Pyramids of the mesh that they stand on; they come before theirs.
  std::uint64_t core_prisms = 0;
  LayerShares surface;                    ///< Shares on all patches together.
  [[nodiscard]] double complete() const;  ///< Share of the area of all patches.
  /// A line if complete() is less than half: the request was not met.
  [[nodiscard]] std::string shortfall() const;
};

/// Height of each layer of a complete column, from the surface on, in mm or times the scale.
/// @param most  Where sizes choose the number, layers over the first are at most so high.
/// @throws Error{kBadInput} as LayerOptions::validate() does, and if no growth makes the thickness.
[[nodiscard]] std::vector<double> layer_heights(const LayerOptions& options, double most = 0);

struct LayerResult {
  MixedMesh mesh;  ///< The core's points, cells and faces first, then those of the layers.
  LayerReport report;
};

/// Grows layers out of a mesh, or into it, so that all of it is one conforming mesh. Outwards the mesh stays
/// as it is; inwards it is deformed: its surface is displaced along the columns, step by step, the tetrahedra
/// behind are moved and improved, and layers and mesh together fill exactly the volume that the mesh filled.
///
/// Every vertex of the patches gets a direction that sees all triangles around it, smoothed over the surface;
/// at openings it lies in their plane, so that caps stay planar. Heights shrink smoothly where layers would
/// meet, turn over or cut themselves: columns lose outer layers, or become thinner as a whole, to nothing
/// where need be, and cells taper there. The mesh is valid whatever is asked for; the report says what was
/// achieved.
///
/// A metric of the mesh is kept: its vertices have theirs, those that moved and those of layers that of the
/// place where they are; outside of the mesh, that of the column's foot.
///
/// Inwards, layers grow into all labels at the patches as one, whose interfaces follow as the interior does;
/// or into one label, on patches between labels, too: then all others stay as they are.
///
/// Patches of the result: those of the input, where a patch with layers becomes an interface (its part
/// without layers, if any, is "NAME_bare"); the skin "layer_outer"; the rings around openings "NAME_layer";
/// "layer_side" where the layers end at other patches.
///
/// @param mesh  Compact. @throws Error{kBadInput} if a patch is not there, has no free side, or none is named
/// and there is no wall, or inwards if two vertices of the surface lie at one place. Parallel inside, bitwise
/// identical for every thread count. Source: algorithms as in Aubry and Löhner 2009, doi:10.1002/nme.2446
/// (most normal normals), Ma, Bae and Choi 2012, doi:10.1007/s00371-011-0594-7 (shrinking balls), Marcum and
/// Gaither 1999, doi:10.2514/6.1999-3252 (AFLR).
[[nodiscard]] LayerResult grow_layers(const TetMesh& mesh, const LayerOptions& options, Context& context);

}  // namespace lumesh
