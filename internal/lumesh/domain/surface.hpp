#pragma once
/// @file Smooth surfaces and curves that the boundary of a mesh follows.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/geometry/triangle_tree.hpp"

namespace lumesh {

struct SurfacePoint {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< Unit length, out of the side that is meshed.
};

struct CurvePoint {
  Vec3 point = Vec3::Zero();
  Vec3 tangent = Vec3::Zero();  ///< Unit length.
};

/// A surface by its nearest points. Threads: const members may run at the same time.
class Surface {
 public:
  Surface() = default;
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;
  virtual ~Surface() = default;

  /// The point of the surface nearest to `point`, which lies near it, or one as good to second order.
  [[nodiscard]] virtual SurfacePoint closest(const Vec3& point) const = 0;
  /// True if closest() is exact, so that alternate projection finds where it meets other such surfaces.
  [[nodiscard]] virtual bool is_analytic() const { return false; }
};

/// A circular cylinder, infinite along its axis.
class CylinderSurface final : public Surface {
 public:
  /// @param axis     Unit length.
  /// @param radius   > 0.
  /// @param outward  1 if the mesh lies inside the cylinder, -1 if outside.
  CylinderSurface(const Vec3& on_axis, const Vec3& axis, double radius, double outward)
      : on_axis_(on_axis), axis_(axis), radius_(radius), outward_(outward) {}

  /// A point on the axis is as near to all of a circle: it gets one of it.
  [[nodiscard]] SurfacePoint closest(const Vec3& point) const override;
  [[nodiscard]] bool is_analytic() const override { return true; }

  [[nodiscard]] const Vec3& on_axis() const { return on_axis_; }
  [[nodiscard]] const Vec3& axis() const { return axis_; }
  [[nodiscard]] double radius() const { return radius_; }

 private:
  Vec3 on_axis_, axis_;
  double radius_, outward_;
};

/// A cubic piece of a curve between two points of it, as Bezier's control points: the ends are the first and
/// the last.
struct CurvePiece {
  std::array<Vec3, 4> control;
};

/// A smooth curve through the points of a polyline.
class MeshCurve {
 public:
  explicit MeshCurve(std::vector<CurvePiece> pieces);
  [[nodiscard]] CurvePoint closest(const Vec3& point) const;

 private:
  std::vector<CurvePiece> pieces_;
  TriangleTree chords_;  // Each a triangle whose last two corners are the same.
};

/// Sum of the normals of the triangles at each point, weighted by their angles there; unit length.
[[nodiscard]] std::vector<Vec3> vertex_normals(std::span<const Vec3> points,
                                               std::span<const std::array<std::uint32_t, 3>> triangles);

/// The cubic patch over a triangle, from the normals at its corners, at the place over a point of the
/// triangle, with a normal that varies quadratically. With the corners p, their mean V and the normals n, the
/// control point of edge (i, j) next to i is (2 pi + pj - ((pj - pi) . ni) ni) / 3, and the middle one
/// E + (E - V) / 2 with the mean E of these six. Source: Vlachos, Peters, Boyd, Mitchell 2001, Curved PN
/// triangles, doi:10.1145/364338.364387.
/// @param normals  Of unit length.
[[nodiscard]] SurfacePoint over_triangle(const std::array<Vec3, 3>& corners,
                                         const std::array<Vec3, 3>& normals, const Vec3& point);

/// A piece of a surface over a triangle.
struct CubicPatch {
  std::array<Vec3, 10>
      control;                  ///< Of the monomials of degree 3 in the corners' weights, binomials included.
  std::array<Vec3, 6> normals;  ///< Likewise, of degree 2.
};

/// A smooth surface through the vertices of a triangle mesh: the patches of over_triangle(). Neighbours join
/// without gaps.
class MeshSurface final : public Surface {
 public:
  /// An edge where the surface ends; the curve takes the place of what the normals would give.
  struct Rim {
    std::uint32_t from, to;
    CurvePiece curve;
  };

  /// Copies what it needs. Memory: about 500 bytes per triangle.
  /// @param triangles  Anticlockwise from outside, no more than two at an edge.
  MeshSurface(std::span<const Vec3> points, std::span<const std::array<std::uint32_t, 3>> triangles,
              std::span<const Rim> rims);
  /// The point of the cubic patch over the nearest point of the triangles. Cost: about 1 us near the surface.
  [[nodiscard]] SurfacePoint closest(const Vec3& point) const override;

 private:
  std::vector<CubicPatch> patches_;
  std::vector<std::array<Vec3, 3>> corners_;
  TriangleTree tree_;
};

}  // namespace lumesh
