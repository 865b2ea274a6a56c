#include "crossing_lines.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/triangle.hpp"

namespace lumesh::surfaces {

CrossingLines::CrossingLines(const TriangleMesh& surface, std::span<const SelfCrossing> crossings)
    : surface_(surface),
      points_(surface.points),
      meetings_of_(surface.triangles.size()),
      lines_(surface.triangles.size()),
      in_plane_(surface.triangles.size()) {
  for (const SelfCrossing& crossing : crossings) meet(crossing.first, crossing.second);
  const auto count = static_cast<std::uint32_t>(surface.triangles.size());
  for (std::uint32_t t = 0; t < count; ++t) cross_meetings(t);
  for (std::uint32_t t = 0; t < count; ++t) divide(t);
}

std::vector<std::uint32_t> CrossingLines::on_edge(std::uint32_t from, std::uint32_t to) const {
  const auto found = on_edges_.find({std::min(from, to), std::max(from, to)});
  if (found == on_edges_.end()) return {};
  std::vector<std::uint32_t> points = found->second;
  sort_along(points, from, to);
  return points;
}

void CrossingLines::meet(std::uint32_t a, std::uint32_t b) {
  bool is_one_plane = true;
  for (const std::uint32_t v : corners(b)) is_one_plane = is_one_plane && side_of_plane(a, v) == 0;
  if (is_one_plane) {
    in_plane_[a].push_back(b);
    in_plane_[b].push_back(a);
  }
  std::vector<std::uint32_t> all;
  for (const auto& [of, in] : {std::pair(a, b), std::pair(b, a)})
    for (std::size_t side = 0; side < 3; ++side) {
      const std::vector<std::uint32_t> found = meet_edge(edge_of(of, side), in);
      if (is_one_plane) add_meeting(a, b, found);
      all.insert(all.end(), found.begin(), found.end());
    }
  sort_unique(all);
  if (!is_one_plane) add_meeting(a, b, all);
}

/// Points where an edge meets a triangle, ascending.
std::vector<std::uint32_t> CrossingLines::meet_edge(const Edge& edge, std::uint32_t t) {
  std::vector<std::uint32_t> found;
  const int first = side_of_plane(t, edge[0]), second = side_of_plane(t, edge[1]);
  if (first * second > 0) return found;
  for (const auto& [v, side] : {std::pair(edge[0], first), std::pair(edge[1], second)})
    if (side == 0 && holds_vertex(t, v)) found.push_back(v);
  if (first * second < 0) {
    if (const std::uint32_t point = pass_through(edge, t); point != kNone) found.push_back(point);
  } else if (first == 0 && second == 0) {
    meet_in_plane(edge, t, found);
  }
  sort_unique(found);
  return found;
}

/// For an edge with ends on both sides of a triangle's plane: the point where it passes through the triangle.
std::uint32_t CrossingLines::pass_through(const Edge& edge, std::uint32_t t) {
  const Vec3 &p = points_[edge[0]], &q = points_[edge[1]];
  std::array<int, 3> turns;
  for (std::size_t s = 0; s < 3; ++s) turns[s] = orient3d(p, q, corner(t, s), corner(t, s + 1));
  const auto [least, most] = std::ranges::minmax(turns);
  if (least < 0 && most > 0) return kNone;
  const auto zeros = std::ranges::count(turns, 0);
  if (zeros == 2) {  // Through the corner between both edges.
    const auto other =
        static_cast<std::size_t>(std::ranges::find_if(turns, [](int s) { return s != 0; }) - turns.begin());
    const std::uint32_t v = corners(t)[(other + 2) % 3];
    put_on_edge(edge, v);
    return v;
  }
  if (zeros == 1)
    return point_of_edges(edge,
                          edge_of(t, static_cast<std::size_t>(std::ranges::find(turns, 0) - turns.begin())));
  const Vec3 normal = triangle_area_normal(corner(t, 0), corner(t, 1), corner(t, 2));
  const double above = normal.dot(p - corner(t, 0)), below = normal.dot(q - corner(t, 0));
  const double share = above != below ? std::clamp(above / (above - below), 0.0, 1.0) : 0.5;
  const std::uint32_t point = point_at(key_of(edge, t), p + share * (q - p));
  put_on_edge(edge, point);
  return point;
}

/// For an edge in a triangle's plane: where it meets the triangle's edges and corners.
void CrossingLines::meet_in_plane(const Edge& edge, std::uint32_t t, std::vector<std::uint32_t>& found) {
  const PlaneView plane = plane_of(t);
  const Vec3 p = points_[edge[0]], q = points_[edge[1]];  // Copies, as points are added.
  for (std::size_t s = 0; s < 3; ++s) {
    const Edge side = edge_of(t, s);
    const Vec3 x = points_[side[0]], y = points_[side[1]];
    const std::uint32_t v = corners(t)[s];
    const Vec3 at_v = points_[v];
    if (v != edge[0] && v != edge[1] && plane.left_of(p, q, at_v) == 0 && (at_v - p).dot(q - p) > 0 &&
        (at_v - q).dot(p - q) > 0) {
      put_on_edge(edge, v);
      found.push_back(v);
    }
    if (plane.left_of(p, q, x) * plane.left_of(p, q, y) < 0 &&
        plane.left_of(x, y, p) * plane.left_of(x, y, q) < 0)
      found.push_back(point_of_edges(edge, side));
  }
}

/// A line from the first to the last of the points where two triangles meet.
void CrossingLines::add_meeting(std::uint32_t a, std::uint32_t b, const std::vector<std::uint32_t>& found) {
  if (found.size() < 2) return;
  const auto number = static_cast<std::uint32_t>(meetings_.size());
  Meeting meeting{{a, b}, found[0], found[1], {}, {}};
  double longest = -1;
  for (const std::uint32_t from : found)
    for (const std::uint32_t to : found)
      if (const double length = (points_[to] - points_[from]).norm(); from < to && length > longest) {
        longest = length;
        meeting.from = from;
        meeting.to = to;
      }
  meeting.edge = edge_along(a, b, meeting.from, meeting.to);
  meetings_.push_back(meeting);
  meetings_of_[a].push_back(number);
  meetings_of_[b].push_back(number);
}

/// The edge of either triangle on which two points lie.
std::optional<CrossingLines::Edge> CrossingLines::edge_along(std::uint32_t a, std::uint32_t b,
                                                             std::uint32_t from, std::uint32_t to) const {
  for (const std::uint32_t t : {a, b})
    for (std::size_t side = 0; side < 3; ++side)
      if (const Edge edge = edge_of(t, side); is_on(edge, from) && is_on(edge, to)) return edge;
  return std::nullopt;
}

void CrossingLines::cross_meetings(std::uint32_t t) {
  const std::vector<std::uint32_t>& all = meetings_of_[t];
  if (all.size() < 2) return;
  const PlaneView plane = plane_of(t);
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t k = i + 1; k < all.size(); ++k) cross(t, plane, meetings_[all[i]], meetings_[all[k]]);
}

/// Puts a point on two lines of a triangle that cross.
void CrossingLines::cross(std::uint32_t t, const PlaneView& plane, Meeting& first, Meeting& second) {
  const Vec3 &a = points_[first.from], &b = points_[first.to], &c = points_[second.from],
             &d = points_[second.to];
  if ((a.cwiseMax(b).array() < c.cwiseMin(d).array()).any() ||
      (c.cwiseMax(d).array() < a.cwiseMin(b).array()).any())
    return;
  if (plane.left_of(a, b, c) * plane.left_of(a, b, d) >= 0 ||
      plane.left_of(c, d, a) * plane.left_of(c, d, b) >= 0)
    return;
  const auto key = [&](const Meeting& along, const Meeting& other) {
    return other.edge ? key_of(*along.edge, *other.edge) : key_of(*along.edge, other.other(t));
  };
  const std::uint32_t point = first.edge    ? known_point(key(first, second))
                              : second.edge ? known_point(key(second, first))
                                            : point_of_three(t, first, second);
  if (point == kNone) {
    fits_ = false;
    return;
  }
  for (Meeting* const meeting : {&first, &second})
    if (!meeting->edge) meeting->between.push_back(point);
}

/// The point of a triangle and two others on lines in it, which the line of those two passes as well.
std::uint32_t CrossingLines::point_of_three(std::uint32_t t, const Meeting& first, const Meeting& second) {
  const std::uint32_t a = first.other(t), b = second.other(t);
  const auto third = std::ranges::find_if(
      meetings_of_[a], [&](std::uint32_t m) { return !meetings_[m].edge && meetings_[m].other(a) == b; });
  if (third == meetings_of_[a].end()) return kNone;
  Key key = {t, a, b, kNone, kNone};
  std::sort(key.begin(), key.begin() + 3);
  const Vec3 &from = points_[first.from], &to = points_[first.to];
  const Vec3 normal = triangle_area_normal(corner(b, 0), corner(b, 1), corner(b, 2));
  const double above = normal.dot(from - corner(b, 0)), below = normal.dot(to - corner(b, 0));
  const double share = above != below ? std::clamp(above / (above - below), 0.0, 1.0) : 0.5;
  const Vec3 place = from + share * (to - from);
  const std::uint32_t point = point_at(key, place);
  meetings_[*third].between.push_back(point);
  return point;
}

void CrossingLines::divide(std::uint32_t t) {
  for (const std::uint32_t number : meetings_of_[t]) {
    const Meeting& meeting = meetings_[number];
    std::vector<std::uint32_t> way = meeting.between;
    if (meeting.edge) {
      way = on_edge((*meeting.edge)[0], (*meeting.edge)[1]);
      way.insert(way.end(), meeting.edge->begin(), meeting.edge->end());
      std::erase_if(way, [&](std::uint32_t v) {
        const double share = share_along(meeting.from, meeting.to, v);
        return v == meeting.from || v == meeting.to || share <= 0 || share >= 1;
      });
    }
    sort_unique(way);
    sort_along(way, meeting.from, meeting.to);
    way.push_back(meeting.to);
    std::uint32_t before = meeting.from;
    for (const std::uint32_t v : way) {
      lines_[t].push_back({std::min(before, v), std::max(before, v)});
      before = v;
    }
  }
  sort_unique(lines_[t]);
}

int CrossingLines::side_of_plane(std::uint32_t t, std::uint32_t v) const {
  return orient3d(corner(t, 0), corner(t, 1), corner(t, 2), points_[v]);
}

CrossingLines::Edge CrossingLines::edge_of(std::uint32_t t, std::size_t side) const {
  const auto [low, high] = std::minmax(corners(t)[side], corners(t)[(side + 1) % 3]);
  return {low, high};
}

/// Whether a vertex in a triangle's plane lies in it or on its rim; it is put on the edge on which it lies.
bool CrossingLines::holds_vertex(std::uint32_t t, std::uint32_t v) {
  if (std::ranges::count(corners(t), v) != 0) return true;
  const PlaneView plane = plane_of(t);
  std::array<int, 3> turns;
  for (std::size_t s = 0; s < 3; ++s) turns[s] = plane.left_of(corner(t, s), corner(t, s + 1), points_[v]);
  if (std::ranges::min(turns) < 0) return false;
  for (std::size_t s = 0; s < 3; ++s)
    if (turns[s] == 0) put_on_edge(edge_of(t, s), v);
  return true;
}

std::uint32_t CrossingLines::point_at(const Key& key, const Vec3& place) {
  const auto [found, is_new] = numbers_.try_emplace(key, static_cast<std::uint32_t>(points_.size()));
  if (is_new) points_.push_back(place);
  return found->second;
}

std::uint32_t CrossingLines::point_of_edges(const Edge& edge, const Edge& other) {
  const Vec3 &p = points_[edge[0]], &x = points_[other[0]];
  const Vec3 along = points_[edge[1]] - p, across = points_[other[1]] - x;
  const Vec3 normal = along.cross(across);
  const double share =
      normal.isZero(0) ? 0.5 : std::clamp((x - p).cross(across).dot(normal) / normal.squaredNorm(), 0.0, 1.0);
  const std::uint32_t point = point_at(key_of(edge, other), p + share * along);
  put_on_edge(edge, point);
  put_on_edge(other, point);
  return point;
}

void CrossingLines::put_on_edge(const Edge& edge, std::uint32_t point) {
  std::vector<std::uint32_t>& points = on_edges_[edge];
  if (std::ranges::count(points, point) == 0) points.push_back(point);
}

bool CrossingLines::is_on(const Edge& edge, std::uint32_t point) const {
  if (point == edge[0] || point == edge[1]) return true;
  const auto found = on_edges_.find(edge);
  return found != on_edges_.end() && std::ranges::count(found->second, point) != 0;
}

std::uint32_t CrossingLines::known_point(const Key& key) const {
  const auto found = numbers_.find(key);
  return found != numbers_.end() ? found->second : kNone;
}

CrossingLines::Key CrossingLines::key_of(const Edge& edge, std::uint32_t t) const {
  Cell<3> sorted = corners(t);
  std::ranges::sort(sorted);
  return {edge[0], edge[1], sorted[0], sorted[1], sorted[2]};
}

CrossingLines::Key CrossingLines::key_of(const Edge& a, const Edge& b) {
  const auto& [low, high] = std::minmax(a, b);
  return {low[0], low[1], high[0], high[1], kNone};
}

double CrossingLines::share_along(std::uint32_t from, std::uint32_t to, std::uint32_t point) const {
  return share_along_segment<3>(points_[point], points_[from], points_[to]);
}

void CrossingLines::sort_along(std::vector<std::uint32_t>& points, std::uint32_t from,
                               std::uint32_t to) const {
  std::ranges::sort(points, [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(share_along(from, to, a), a) < std::pair(share_along(from, to, b), b);
  });
}

}  // namespace lumesh::surfaces
