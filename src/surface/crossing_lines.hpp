#pragma once
// Lines along which triangles of a surface cross, with points that all triangles at them share.

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lumesh/geometry/plane_view.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/mesh/triangle_mesh.hpp"

namespace lumesh::surfaces {

/// Points where edges of a surface pass through triangles and where three triangles meet, each of them once,
/// and the lines between them within each triangle. Which edge passes through which triangle, edge or vertex
/// is told by exact predicates; coordinates of new points are rounded.
class CrossingLines {
 public:
  using Line = std::array<std::uint32_t, 2>;  // Between two points, the lower one first.

  /// @param surface  Points at one place are one, triangles have areas. @param crossings  All pairs of its
  /// triangles that meet.
  CrossingLines(const TriangleMesh& surface, std::span<const SelfCrossing> crossings);

  /// False where lines do not fit together, as where more than three triangles meet at a new point.
  [[nodiscard]] bool fit_together() const { return fits_; }
  /// The surface's points, then new ones.
  [[nodiscard]] const std::vector<Vec3>& points() const { return points_; }
  /// Points on the way along an edge from one vertex to another, without these.
  [[nodiscard]] std::vector<std::uint32_t> on_edge(std::uint32_t from, std::uint32_t to) const;
  /// Lines within a triangle or along its edges, ascending, each once.
  [[nodiscard]] const std::vector<Line>& in_triangle(std::uint32_t triangle) const {
    return lines_[triangle];
  }
  /// Triangles in the plane of one that meet it.
  [[nodiscard]] const std::vector<std::uint32_t>& in_plane_of(std::uint32_t triangle) const {
    return in_plane_[triangle];
  }

 private:
  using Edge = std::array<std::uint32_t, 2>;  // Between two vertices, the lower one first.
  using Key = std::array<std::uint32_t, 5>;   // What meets in a point.
  static constexpr std::uint32_t kNone = ~0U;

  /// A line between two triangles, or what of an edge lies in a triangle of one plane with it.
  struct Meeting {
    std::array<std::uint32_t, 2> triangles;
    std::uint32_t from, to;
    std::optional<Edge> edge;
    std::vector<std::uint32_t> between;

    [[nodiscard]] std::uint32_t other(std::uint32_t t) const { return triangles[triangles[0] == t ? 1 : 0]; }
  };

  void meet(std::uint32_t a, std::uint32_t b);
  [[nodiscard]] std::vector<std::uint32_t> meet_edge(const Edge& edge, std::uint32_t t);
  [[nodiscard]] std::uint32_t pass_through(const Edge& edge, std::uint32_t t);
  void meet_in_plane(const Edge& edge, std::uint32_t t, std::vector<std::uint32_t>& found);
  void add_meeting(std::uint32_t a, std::uint32_t b, const std::vector<std::uint32_t>& found);
  void cross_meetings(std::uint32_t t);
  void cross(std::uint32_t t, const PlaneView& plane, Meeting& first, Meeting& second);
  [[nodiscard]] std::uint32_t point_of_three(std::uint32_t t, const Meeting& first, const Meeting& second);
  void divide(std::uint32_t t);

  [[nodiscard]] const Cell<3>& corners(std::uint32_t t) const { return surface_.triangles[t]; }
  [[nodiscard]] const Vec3& corner(std::uint32_t t, std::size_t i) const {
    return points_[corners(t)[i % 3]];
  }
  [[nodiscard]] PlaneView plane_of(std::uint32_t t) const {
    return {corner(t, 0), corner(t, 1), corner(t, 2)};
  }
  [[nodiscard]] int side_of_plane(std::uint32_t t, std::uint32_t v) const;
  [[nodiscard]] Edge edge_of(std::uint32_t t, std::size_t side) const;
  [[nodiscard]] bool holds_vertex(std::uint32_t t, std::uint32_t v);
  [[nodiscard]] std::uint32_t point_at(const Key& key, const Vec3& place);
  [[nodiscard]] std::uint32_t point_of_edges(const Edge& edge, const Edge& other);
  void put_on_edge(const Edge& edge, std::uint32_t point);
  [[nodiscard]] bool is_on(const Edge& edge, std::uint32_t point) const;
  [[nodiscard]] std::optional<Edge> edge_along(std::uint32_t a, std::uint32_t b, std::uint32_t from,
                                               std::uint32_t to) const;
  [[nodiscard]] std::uint32_t known_point(const Key& key) const;
  [[nodiscard]] Key key_of(const Edge& edge, std::uint32_t t) const;
  [[nodiscard]] static Key key_of(const Edge& a, const Edge& b);
  [[nodiscard]] double share_along(std::uint32_t from, std::uint32_t to, std::uint32_t point) const;
  void sort_along(std::vector<std::uint32_t>& points, std::uint32_t from, std::uint32_t to) const;

  const TriangleMesh& surface_;
  std::vector<Vec3> points_;
  std::map<Key, std::uint32_t> numbers_;
  std::map<Edge, std::vector<std::uint32_t>> on_edges_;
  std::vector<Meeting> meetings_;
  std::vector<std::vector<std::uint32_t>> meetings_of_;  // Of each triangle.
  std::vector<std::vector<Line>> lines_;
  std::vector<std::vector<std::uint32_t>> in_plane_;
  bool fits_ = true;
};

}  // namespace lumesh::surfaces
