#include <Eigen/Geometry>
#include <algorithm>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/edge_key.hpp"
#include "plane_sections.hpp"

namespace lumesh::quality {

namespace {

double cross(const PlanePoint& a, const PlanePoint& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double signed_area(const Outline& loop) {
  double sum = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) sum += cross(loop[i], loop[(i + 1) % loop.size()]);
  return sum / 2;
}

/// True if a loop turns around a point. Source: Sunday 2001, winding numbers by crossings.
bool surrounds(const Outline& loop, const PlanePoint& p) {
  int turns = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const PlanePoint a = loop[i] - p, b = loop[(i + 1) % loop.size()] - p;
    if (a.y() <= 0 && b.y() > 0 && cross(a, b) > 0) ++turns;
    if (a.y() > 0 && b.y() <= 0 && cross(a, b) < 0) --turns;
  }
  return turns != 0;
}

double distance_to(const Outline& loop, const PlanePoint& p) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const PlanePoint &a = loop[i], &b = loop[(i + 1) % loop.size()];
    smallest = std::min(smallest, (a - p + share_along_segment(p, a, b) * (b - a)).norm());
  }
  return smallest;
}

/// What a triangle leaves on a plane: from where the next one begins to where the one before ended. With
/// outward triangles the inside is on the left.
struct Segment {
  std::uint64_t from;  ///< Edges as numbers.
  std::uint64_t to;
  PlanePoint start;
};

/// The segment of a triangle that has corners on both sides; corners on the plane count as above.
std::optional<Segment> segment_of(const SectionPlane& plane, std::span<const Vec3> points,
                                  const Cell<3>& triangle) {
  std::array<double, 3> heights;
  int above = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    heights[i] = plane.height(points[triangle[i]]);
    above += heights[i] >= 0 ? 1 : 0;
  }
  if (above == 0 || above == 3) return std::nullopt;
  Segment segment = {};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3;
    const std::uint32_t a = triangle[i], b = triangle[next];
    if (heights[i] < 0 && heights[next] >= 0) segment.to = edge_key(a, b);
    if (heights[i] >= 0 && heights[next] < 0) {
      segment.from = edge_key(a, b);
      const double share = heights[i] / (heights[i] - heights[next]);
      const Vec3 p = points[a] + share * (points[b] - points[a]) - plane.origin_mm;
      segment.start = {p.dot(plane.u), p.dot(plane.v)};
    }
  }
  return segment;
}

struct Loops {
  std::vector<Outline> closed;
  bool has_open = false;
};

Loops chain(std::vector<Segment> segments) {
  std::ranges::sort(segments, [](const Segment& a, const Segment& b) {
    return a.from != b.from ? a.from < b.from : a.to < b.to;
  });
  const auto next_of = [&](std::uint64_t edge) {
    const auto at = std::ranges::lower_bound(segments, edge, {}, &Segment::from);
    const bool found = at != segments.end() && at->from == edge;
    return found ? static_cast<std::size_t>(at - segments.begin()) : segments.size();
  };
  Loops loops;
  std::vector<char> used(segments.size(), 0);
  for (std::size_t first = 0; first < segments.size(); ++first) {
    if (used[first]) continue;
    Outline loop;
    std::size_t at = first;
    while (at < segments.size() && !used[at]) {
      used[at] = 1;
      loop.push_back(segments[at].start);
      at = next_of(segments[at].to);
    }
    if (at == first)
      loops.closed.push_back(std::move(loop));
    else
      loops.has_open = true;  // Its end may also be the beginning of another open one.
  }
  return loops;
}

/// The smallest outline around a point, as an index; the number of loops if there is none.
std::size_t innermost_around(const Loops& loops, const std::vector<double>& areas, const PlanePoint& p) {
  std::size_t best = loops.closed.size();
  for (std::size_t l = 0; l < loops.closed.size(); ++l)
    if (areas[l] > 0 && (best == loops.closed.size() || areas[l] < areas[best]) &&
        surrounds(loops.closed[l], p))
      best = l;
  return best;
}

/// The outline nearest to the origin within a tolerance.
std::size_t nearest(const Loops& loops, const std::vector<double>& areas, double tolerance) {
  std::size_t best = loops.closed.size();
  for (std::size_t l = 0; l < loops.closed.size(); ++l) {
    if (areas[l] <= 0) continue;
    const double distance = distance_to(loops.closed[l], PlanePoint::Zero());
    if (distance > tolerance) continue;
    tolerance = distance;
    best = l;
  }
  return best;
}

/// An outline's area without the holes in it.
double area_without_holes(const Loops& loops, const std::vector<double>& areas, std::size_t outline) {
  double area = areas[outline];
  for (std::size_t l = 0; l < loops.closed.size(); ++l)
    if (areas[l] < 0 && innermost_around(loops, areas, loops.closed[l].front()) == outline) area += areas[l];
  return area;
}

}  // namespace

SectionPlane::SectionPlane(const Vec3& origin, const Vec3& unit_normal)
    : origin_mm(origin), normal(unit_normal), u(unit_normal.unitOrthogonal()), v(unit_normal.cross(u)) {}

SurfaceSections::SurfaceSections(std::span<const Vec3> points, std::vector<Cell<3>> triangles)
    : points_(points), triangles_(std::move(triangles)), tree_(points_, triangles_) {}

bool SurfaceSection::is_nearest_to(const PlanePoint& p) const {
  if (others.empty() || surrounds(outline, p)) return true;
  const double distance = distance_to(outline, p);
  return std::ranges::none_of(
      others, [&](const Outline& other) { return surrounds(other, p) || distance_to(other, p) < distance; });
}

SurfaceSection SurfaceSections::at(const SectionPlane& plane, double limit_mm, double tolerance_mm) const {
  const Vec3 half =
      limit_mm * (Vec3::Ones() - plane.normal.cwiseAbs2()).cwiseMax(0).cwiseSqrt();  // Of a disc.
  std::vector<Segment> segments;
  for (const std::uint32_t t : tree_.overlapping(plane.origin_mm - half, plane.origin_mm + half))
    if (const auto segment = segment_of(plane, points_, triangles_[t])) segments.push_back(*segment);
  Loops loops = chain(std::move(segments));
  std::vector<double> areas;
  for (const Outline& loop : loops.closed) areas.push_back(signed_area(loop));
  SurfaceSection section;
  std::size_t own = innermost_around(loops, areas, PlanePoint::Zero());
  // All that is within a closed outline lies in the box, so that nothing of it can be missing.
  if (own == loops.closed.size() && loops.has_open)
    section.reach_mm = std::numeric_limits<double>::infinity();
  if (own == loops.closed.size()) own = nearest(loops, areas, tolerance_mm);
  if (own == loops.closed.size()) return section;
  section.area_mm2 = area_without_holes(loops, areas, own);
  for (std::size_t l = 0; l < loops.closed.size(); ++l)
    if (areas[l] > 0 && l != own) section.others.push_back(std::move(loops.closed[l]));
  section.outline = std::move(loops.closed[own]);
  for (const PlanePoint& p : section.outline) section.reach_mm = std::max(section.reach_mm, p.norm());
  return section;
}

}  // namespace lumesh::quality
