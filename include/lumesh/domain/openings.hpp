#pragma once
/// @file Where the object is cut off, before anything is meshed; and what a mesh makes of it.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lumesh/domain/domain.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

struct NamedOpening;

/// Which squares of a plane, in rows, a part of it holds.
struct OpeningSquares {
  Vec3 first_mm, u, v;  ///< Centre of the first one; unit vectors along rows and columns.
  double step_mm;
  int columns, rows;
  std::vector<std::uint8_t> is_inside;

  [[nodiscard]] std::size_t square(int column, int row) const {
    return static_cast<std::size_t>(column) +
           static_cast<std::size_t>(columns) * static_cast<std::size_t>(row);
  }
  /// The square that holds a place, if the grid does.
  [[nodiscard]] std::optional<std::size_t> square_at(const Vec3& point_mm) const {
    const Vec3 off = point_mm - first_mm;
    const double column = std::round(off.dot(u) / step_mm), row = std::round(off.dot(v) / step_mm);
    if (!(column >= 0 && column < columns && row >= 0 && row < rows)) return std::nullopt;
    return square(static_cast<int>(column), static_cast<int>(row));
  }
  /// Whether a square is inside; none beyond the grid is.
  [[nodiscard]] bool hold(int column, int row) const {
    return column >= 0 && column < columns && row >= 0 && row < rows && is_inside[square(column, row)] != 0;
  }
  [[nodiscard]] bool hold(const Vec3& point_mm) const {
    const std::optional<std::size_t> at = square_at(point_mm);
    return at && is_inside[*at] != 0;
  }
  [[nodiscard]] Vec3 centre_of(int column, int row) const {
    return first_mm + step_mm * (column * u + row * v);
  }
  /// Areas in mm^2 of the holes: parts of the plane that the inside surrounds, in the order in which the rows
  /// come to them. Const, from any thread.
  [[nodiscard]] std::vector<double> hole_areas_mm2() const;
};

/// A connected part of one label's section in one cut plane (a border of the image, or one that was asked
/// for).
struct Opening {
  Label label = kBackground;
  double area_mm2 = 0;
  Vec3 centre_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< Unit, out of the object.
  Box3 box_mm;                  ///< Around the part.
  double voxel_mm = 1;  ///< The resolution within the plane: what is nearer than this may belong to it.
  /// Its place: squares of its plane; null if that is not known.
  std::shared_ptr<const OpeningSquares> squares = nullptr;
  /// True for a section of a wall: all sections of its label that surround openings of other labels surround
  /// a quarter of their area or more together, and it is one of these, lies beside such a label, or meets one
  /// of these at an edge of the image.
  bool is_rim = false;
  bool is_of_surface = false;  ///< One of flat_ends(): others may be openings, too.
  double off_mm = 0;           ///< Largest distance of a corner of such an end from its plane.
  std::string name = {};       ///< Name of its patch in meshes, see find_openings().

  /// Radius of the circle with the same area.
  [[nodiscard]] double radius_mm() const { return std::sqrt(area_mm2 / std::numbers::pi); }
  /// Whether it is the section of a hollow wall: there is a hole in it, of a quarter of its area or more.
  [[nodiscard]] bool is_hollow() const { return hole_mm2() > 0; }
  /// Radius of the circle with the area of that hole; its own where it is not hollow.
  [[nodiscard]] double lumen_radius_mm() const;
  /// Length of its rim, about; where its squares are not known, that of the circle.
  [[nodiscard]] double perimeter_mm() const;

 private:
  [[nodiscard]] double hole_mm2() const;
};

/// The openings of a domain by falling area: its flat_ends(), or the parts of its cut planes; none if it has
/// neither. The first is "inlet_1", the others are "outlet_1", "outlet_2", …, rims of walls "wall_rim_1", …;
/// where these belong to several labels, the label is in the name: "outlet_2_label_5", or what the image
/// calls it. Areas are right to about 0.1 % of the domain's sections. A part smaller than
/// half of voxel_face_mm2() is none: a wall that grazes the border. Threads: parallel inside, bitwise
/// identical for every thread count. Cost: about 0.1 us for each voxel of the cut planes that may hold the
/// object, and 2 ms per opening.
[[nodiscard]] std::vector<Opening> find_openings(const Domain& domain);

/// Openings that the flat ends of a surface are, in their order.
/// @param resolution_mm  Of the surface, as Domain::resolution_mm().
[[nodiscard]] std::vector<Opening> openings_of(std::span<const FlatEnd> ends, double resolution_mm);

/// A place near the rim of an opening: in the cut plane, within `step_mm` of where a label ends there.
struct RimPlace {
  Vec3 position_mm;
  std::array<Material, 3> materials;  ///< The label, what is beside it, and what is beyond the plane.
};

/// At least one within twice `step_mm` of any place of a rim. Cost: as find_openings(), for squares of that
/// size.
[[nodiscard]] std::vector<RimPlace> find_rim_places(const Domain& domain, double step_mm);

/// The openings as renamings need them.
[[nodiscard]] std::vector<NamedOpening> named_openings(std::span<const Opening> openings);

/// Area of the voxel's section along a plane.
[[nodiscard]] double voxel_face_mm2(const Domain& domain, const Vec3& normal);

/// Number of the opening that a part of a mesh is: that which holds most of its places, else the nearest one;
/// of those of its label whose plane is within a voxel. `openings.size()` if there is none within a voxel. Of
/// a label that no opening has, as layers have, that which holds half of its places or more.
/// @param places_mm  Centres of its triangles; at least one.
[[nodiscard]] std::size_t opening_of_places(std::span<const Opening> openings, Label label,
                                            std::span<const Vec3> places_mm, const Vec3& normal);

/// Shape that the triangles of an opening have in a mesh.
struct OpeningShape {
  std::size_t parts = 0;          ///< Connected over edges.
  std::size_t rims = 0;           ///< Closed loops of edges: one, and one for each hole.
  std::size_t edges = 0;          ///< Edges of the rim that has the fewest.
  double edge_mm = 0;             ///< Mean length of the edges of all rims.
  double off_mm = 0;              ///< Largest distance of a vertex from the plane …
  Vec3 off_at_mm = Vec3::Zero();  ///< … and the place of that vertex.
};

/// An opening in image and mesh.
struct OpeningInMesh {
  Opening opening;
  std::string patches;  ///< Names, joined by " + "; empty if the mesh does not have it.
  double mesh_area_mm2 = 0;
  OpeningShape shape;

  [[nodiscard]] double change_percent() const { return 100 * (mesh_area_mm2 / opening.area_mm2 - 1); }
};

struct OpeningsCompared {
  std::vector<OpeningInMesh> openings;  ///< The openings of the whole domain.
  std::vector<std::string> others;      ///< Openings of the mesh that are none of the domain.
};

/// @param mesh  Of the domain; its openings are looked at, and its planes of symmetry: those may be openings.
[[nodiscard]] OpeningsCompared compare_openings(const MeshView& mesh, std::span<const Opening> openings);

/// More than this and an opening's area is wrong.
inline constexpr double kWrongOpeningPercent = 5;

[[nodiscard]] inline bool is_wrong(const OpeningInMesh& opening) {
  return opening.patches.empty() || opening.shape.parts > 1 ||
         std::abs(opening.change_percent()) > kWrongOpeningPercent;
}

/// Whether shorter edges may mend an opening: it is wrong, or doubts_about() says so of its area, rims or
/// plane.
[[nodiscard]] bool is_coarse(const OpeningInMesh& opening);

/// A line for each opening that is wrong, with its place, and for the others.
[[nodiscard]] std::vector<std::string> faults_of(const OpeningsCompared& compared);

/// Those, and a line for each opening that is less good than it should be: an area that is off by more than
/// 2 % (5 % below two voxels in radius), a vertex off the plane by more than a hundredth of a voxel, or by a
/// millionth of the radius more than the surface's own end is, fewer than eight edges around, more or fewer
/// rims than the image's opening has.
[[nodiscard]] std::vector<std::string> doubts_about(const OpeningsCompared& compared);

}  // namespace lumesh
