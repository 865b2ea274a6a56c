#include "lumesh/layers/extrusion.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/core/smoothstep.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/geometry/wall_ramp.hpp"
#include "lumesh/mesh/cell_faces.hpp"
#include "lumesh/mesh/edge_key.hpp"
#include "lumesh/mesh/edge_loops.hpp"
#include "lumesh/mesh/tetrahedral_split.hpp"

namespace lumesh {
namespace {

/// A face of a patch, with three or four corners.
struct PatchFace {
  std::vector<std::uint32_t> corners;
  std::int32_t patch;
  Label label = kBackground;  // Of the cell behind it: a patch may have several.
};

/// The openings that go on together.
struct SweptSection {
  std::vector<std::int32_t> patches;
  std::vector<PatchFace> faces;
  std::vector<std::uint32_t> vertices;  // Ascending.
  Vec3 centre_mm = Vec3::Zero(), normal = Vec3::Zero(), axis = Vec3::Zero();
  double reach_mm = 0, radius_mm = 0, edge_mm = 0;
  /// Where it becomes a circle: over this length, and then so many times as far from the axis, by vertex.
  double transition_mm = 0;
  std::vector<double> of_circle = {};
  bool is_clear = true;  // Whether the walls say the axis.
  WallRamp ramp = {Vec3::UnitZ(), 1};

  /// The place of a vertex that has gone so far along the axis.
  [[nodiscard]] Vec3 swept(const Vec3& point, std::uint32_t v, double along_mm) const {
    const Vec3 place = point + towards_circle(point, v, along_mm);
    return place + ramp.displacement(place - centre_mm, along_mm) + along_mm * axis;
  }
  /// The way that a vertex goes across the axis until so far along it.
  [[nodiscard]] Vec3 towards_circle(const Vec3& point, std::uint32_t v, double along_mm) const {
    if (of_circle.empty()) return Vec3::Zero();
    const double ramp = smoothstep(along_mm, transition_mm);
    const auto at = std::ranges::lower_bound(vertices, v) - vertices.begin();
    const Vec3 off = point - centre_mm;
    return ramp * (of_circle[static_cast<std::size_t>(at)] - 1) * (off - off.dot(axis) * axis);
  }
  [[nodiscard]] bool has(std::int32_t patch) const {
    return std::ranges::find(patches, patch) != patches.end();
  }
};

class Extruder {
 public:
  Extruder(const MixedMesh& mesh, LayerCells cells, const std::optional<LocalLength>& transition)
      : cells_(cells), transition_(transition) {
    result_.mesh = mesh;
    wall_edge_mm_ = mean_wall_edge_mm();
  }

  ExtrudedMesh make(std::span<const NamedLength> lengths) && {
    check_names(lengths);
    std::vector<bool> is_done(patches().size(), false);
    for (std::size_t p = 0; p < patches().size(); ++p) {
      if (patches()[p].kind != PatchKind::kOpening || is_done[p]) continue;
      const SweptSection section = section_at(static_cast<std::int32_t>(p));
      for (const std::int32_t q : section.patches) is_done[static_cast<std::size_t>(q)] = true;
      if (const double length_mm = wanted_mm(section, lengths); length_mm > 0 && !section.faces.empty())
        extend(section, length_mm);
    }
    return std::move(result_);
  }

 private:
  [[nodiscard]] const MixedMesh& mesh() const { return result_.mesh; }
  [[nodiscard]] const std::vector<Patch>& patches() const { return mesh().info.patches; }
  [[nodiscard]] const Patch& patch(std::int32_t p) const { return patches()[static_cast<std::size_t>(p)]; }
  [[nodiscard]] const Vec3& point(std::uint32_t v) const { return mesh().points[v]; }

  /// Mean length of the edges of all walls; 0 without any.
  [[nodiscard]] double mean_wall_edge_mm() const {
    double sum_mm = 0;
    std::size_t count = 0;
    for_each_patch_face(mesh(), [&](std::span<const std::uint32_t> face, std::int32_t p) {
      if (patch(p).kind != PatchKind::kWall) return;
      for (std::size_t i = 0; i < face.size(); ++i, ++count)
        sum_mm += (point(face[i]) - point(face[(i + 1) % face.size()])).norm();
    });
    return count == 0 ? 0 : sum_mm / static_cast<double>(count);
  }

  void check_names(std::span<const NamedLength> lengths) const {
    std::vector<std::string> names;
    for (const Patch& p : patches())
      if (p.kind == PatchKind::kOpening) names.push_back(p.name);
    if (names.empty())
      throw Error(ErrorKind::kBadInput, fmt::format("{}: the mesh has no openings", option_name("extend")));
    check_names_of(lengths, names, "the mesh");
  }

  [[nodiscard]] Vec3 area_normal(std::span<const std::uint32_t> face) const {
    Vec3 normal = 0.5 * triangle_area_normal(point(face[0]), point(face[1]), point(face[2]));
    if (face.size() == 4)
      normal += 0.5 * triangle_area_normal(point(face[0]), point(face[2]), point(face[3]));
    return normal;
  }
  [[nodiscard]] Vec3 middle_of(std::span<const std::uint32_t> face) const {
    Vec3 sum = Vec3::Zero();
    for (const std::uint32_t v : face) sum += point(v);
    return sum / static_cast<double>(face.size());
  }

  /// Mean normal of each patch, over all of its faces.
  [[nodiscard]] std::vector<Vec3> patch_normals() const {
    std::vector<Vec3> sums(patches().size(), Vec3::Zero());
    for_each_patch_face(mesh(), [&](std::span<const std::uint32_t> face, std::int32_t p) {
      sums[static_cast<std::size_t>(p)] += area_normal(face);
    });
    for (Vec3& sum : sums) sum.stableNormalize();
    return sums;
  }
  /// Patches of openings that share edges with this one and look the same way, one after the other.
  [[nodiscard]] std::vector<std::int32_t> joined_openings(std::int32_t first) const {
    constexpr double kOnePlane = 0.999;
    const std::vector<Vec3> normals = patch_normals();
    const auto looks_alike = [&](std::int32_t p) {
      return normals[static_cast<std::size_t>(p)].dot(normals[static_cast<std::size_t>(first)]) > kOnePlane;
    };
    std::map<std::uint64_t, std::vector<std::int32_t>> at_edge;
    for_each_patch_face(mesh(), [&](std::span<const std::uint32_t> face, std::int32_t p) {
      if (patch(p).kind != PatchKind::kOpening) return;
      for (std::size_t i = 0; i < face.size(); ++i)
        at_edge[edge_key(face[i], face[(i + 1) % face.size()])].push_back(p);
    });
    std::vector<std::int32_t> joined = {first};
    for (std::size_t i = 0; i < joined.size(); ++i)
      for (const auto& [edge, at] : at_edge) {
        if (std::ranges::find(at, joined[i]) == at.end()) continue;
        for (const std::int32_t p : at)
          if (std::ranges::find(joined, p) == joined.end() && looks_alike(p)) joined.push_back(p);
      }
    return joined;
  }

  [[nodiscard]] SweptSection section_at(std::int32_t first) const {
    SweptSection s;
    s.patches = joined_openings(first);
    AreaSum sum;
    double edges_mm = 0;
    std::map<std::int32_t, double> area_of;
    std::size_t edge_count = 0;
    for_each_patch_face(mesh(), [&](std::span<const std::uint32_t> face, std::int32_t p) {
      if (!s.has(p)) return;
      s.faces.push_back({{face.begin(), face.end()}, p});
      s.vertices.insert(s.vertices.end(), face.begin(), face.end());
      const Vec3 normal = area_normal(face);
      area_of[p] += normal.norm();
      sum.add(normal, middle_of(face));
      for (std::size_t i = 0; i < face.size(); ++i, ++edge_count)
        edges_mm += (point(face[i]) - point(face[(i + 1) % face.size()])).norm();
    });
    if (s.faces.empty()) return s;
    sort_unique(s.vertices);
    s.normal = sum.normal.normalized();
    s.centre_mm = sum.centre();
    s.edge_mm = edges_mm / static_cast<double>(edge_count);
    for (const std::uint32_t v : s.vertices)
      s.reach_mm = std::max(s.reach_mm, (point(v) - s.centre_mm).norm());
    s.axis = axis_at(s);
    double largest_mm2 = 0;
    for (const auto& [p, area] : area_of)
      if (!is_ring(s, p)) largest_mm2 = std::max(largest_mm2, area);
    if (const double hollow_mm2 = hollow_lumen_mm2(s, sum.area); hollow_mm2 > 0) largest_mm2 = hollow_mm2;
    s.radius_mm = circle_radius(largest_mm2 * s.axis.dot(s.normal));
    return s;
  }

  /// Whether a patch surrounds others of the section, as a wall does the lumen: its rim has several loops.
  [[nodiscard]] static bool is_ring(const SweptSection& s, std::int32_t p) {
    return s.patches.size() > 1 && loop_count(rim_edges(s, p)) > 1;
  }
  static std::set<std::uint64_t> rim_edges(const SweptSection& s, std::int32_t p) {
    std::set<std::uint64_t> rim;
    for (const PatchFace& face : s.faces)
      if (face.patch == p) toggle_edges(face.corners, rim);
    return rim;
  }

  /// Area of the largest hole of the whole section, where that is a hollow wall's: of a quarter of the
  /// section or more, as Opening::is_hollow(). Else 0.
  [[nodiscard]] double hollow_lumen_mm2(const SweptSection& s, double section_mm2) const {
    constexpr double kMin = 0.25;
    const auto rim = rim_of(s);
    DisjointSets loops(s.vertices.size());
    const auto number = [&](std::uint32_t v) {
      return static_cast<std::uint32_t>(std::ranges::lower_bound(s.vertices, v) - s.vertices.begin());
    };
    for (const auto& [from, to] : rim) loops.merge(number(from), number(to));
    std::map<std::uint32_t, double> area_of;  // Negative within holes, whose edges run the other way.
    for (const auto& [from, to] : rim)
      area_of[loops.find(number(from))] +=
          0.5 * (point(from) - s.centre_mm).cross(point(to) - s.centre_mm).dot(s.normal);
    double largest_mm2 = 0;
    for (const auto& [loop, area] : area_of) largest_mm2 = std::max(largest_mm2, -area);
    return largest_mm2 < kMin * section_mm2 ? 0 : largest_mm2;
  }

  /// The vessel's direction in the section; the normal where the walls do not say one, and where it is that
  /// within what facets and noise turn it by.
  [[nodiscard]] Vec3 axis_at(SweptSection& s) const {
    constexpr double kMinCos = 0.4, kSquare = 0.997;
    constexpr double kClear = 0.15, kUnclear = 0.3;  // What walls differ by, as sines.
    WallDirection axis = wall_direction(s, s.reach_mm);
    if (axis.left > kClear)  // Something may join the vessel further in.
      if (const WallDirection near = wall_direction(s, 0.5 * s.reach_mm); near.left < axis.left) axis = near;
    s.is_clear = axis.left < kUnclear && axis.along.dot(s.normal) > kMinCos;
    return s.is_clear && axis.along.dot(s.normal) < kSquare ? axis.along : s.normal;
  }
  struct WallDirection {
    Vec3 along = Vec3::Zero();
    double left = std::numeric_limits<double>::infinity();  // R.m.s. of the equations; infinite: left open.
  };
  /// Calls a function with the places of walls at most so deep before a section, from its centre, and their
  /// unit normals and areas. Faces as long as the section's reach count by parts: their middles alone, as of
  /// the long triangles that decimation leaves of a straight wall, would be at few depths, or none.
  template <class Function>
  void for_each_wall_before(const SweptSection& s, double depth_mm, const Function& function) const {
    for_each_patch_face(mesh(), [&](std::span<const std::uint32_t> face, std::int32_t p) {
      if (patch(p).kind != PatchKind::kWall) return;
      const Vec3 normal = area_normal(face);
      const double area = normal.norm();
      if (!(area > 0)) return;
      const std::vector<Vec3> middles = middles_of_parts(face, s.reach_mm);
      for (const Vec3& middle : middles) {
        const Vec3 off = middle - s.centre_mm;
        if (std::abs(off.dot(s.normal)) > depth_mm || off.norm() > 1.5 * s.reach_mm) continue;
        function(off, Vec3(normal / area), area / static_cast<double>(middles.size()));
      }
    });
  }
  /// Middle of the face, or middles of parts a third as long as `long_mm`, alike in each of its triangles.
  [[nodiscard]] std::vector<Vec3> middles_of_parts(std::span<const std::uint32_t> face,
                                                   double long_mm) const {
    constexpr double kParts = 3, kMaxParts = 64;
    double longest_mm = 0;
    for (std::size_t i = 0; i < face.size(); ++i)
      longest_mm = std::max(longest_mm, (point(face[i]) - point(face[(i + 1) % face.size()])).norm());
    if (longest_mm <= long_mm) return {middle_of(face)};
    const double parts = std::min(kMaxParts, std::ceil(kParts * longest_mm / long_mm));
    std::vector<Vec3> middles;
    for (std::size_t c = 2; c < face.size(); ++c) {
      const Vec3 a = point(face[0]), u = (point(face[c - 1]) - a) / parts, v = (point(face[c]) - a) / parts;
      for (int i = 0; i < parts; ++i)
        for (int j = 0; i + j < parts; ++j) {
          middles.emplace_back(a + (i + 1.0 / 3) * u + (j + 1.0 / 3) * v);
          if (i + j + 1 < parts) middles.emplace_back(a + (i + 2.0 / 3) * u + (j + 2.0 / 3) * v);
        }
    }
    return middles;
  }
  /// Direction of a vessel that bends and widens evenly before the section, with the normal N of the section:
  /// all wall normals n at depth d have n (N + t + d b) = c + d e, solved for t, b, c and e by least squares
  /// over the walls at most so deep. Derived in docs/stages/layers.md, "Direction of an opening's vessel".
  [[nodiscard]] WallDirection wall_direction(const SweptSection& s, double depth_mm) const {
    constexpr double kMinPart = 1e-3;  // Of the largest eigenvalue.
    using Vec6 = Eigen::Matrix<double, 6, 1>;
    const Vec3 u = s.normal.unitOrthogonal(), v = s.normal.cross(u);
    Eigen::Matrix<double, 6, 6> sums = Eigen::Matrix<double, 6, 6>::Zero();
    Vec6 right = Vec6::Zero();
    double area = 0, squares = 0;
    for_each_wall_before(s, depth_mm, [&](const Vec3& off, const Vec3& n, double weight) {
      const double depth = -off.dot(s.normal) / depth_mm;
      Vec6 row;
      row << n.dot(u), n.dot(v), depth * n.dot(u), depth * n.dot(v), -1, -depth;
      const double given = -n.dot(s.normal);
      sums += weight * row * row.transpose();
      right += weight * given * row;
      squares += weight * given * given;
      area += weight;
    });
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(sums);
    if (!(area > 0) || !(solver.eigenvalues()[0] > kMinPart * solver.eigenvalues()[5])) return {};
    const Vec6 fit = sums.ldlt().solve(right);
    return {(s.normal + fit[0] * u + fit[1] * v).normalized(),
            std::sqrt(std::max(0.0, squares - fit.dot(right)) / area)};
  }

  [[nodiscard]] double wanted_mm(const SweptSection& s, std::span<const NamedLength> lengths) const {
    std::vector<std::string> names;
    for (const std::int32_t p : s.patches) names.push_back(patch(p).name);
    return length_wanted_mm(lengths, names, s.radius_mm);
  }

  void find_labels(SweptSection& s) const {
    std::vector<bool> is_at(mesh().points.size(), false);
    for (const std::uint32_t v : s.vertices) is_at[v] = true;
    std::map<std::vector<std::uint32_t>, Label> behind;
    const auto look_at = [&](const auto& cells, const std::vector<Label>& labels) {
      for (std::size_t c = 0; c < cells.size(); ++c) {
        const auto count = std::ranges::count_if(cells[c], [&](std::uint32_t v) { return is_at[v]; });
        if (count < 3) continue;
        for (const LocalFace& face : faces_of_cell(cells[c].size())) {
          std::vector<std::uint32_t> corners;
          for (const std::uint8_t i : face) corners.push_back(cells[c][i]);
          behind[key_of(std::move(corners))] = labels[c];
        }
      }
    };
    for_each_cell_list(look_at, mesh());
    for (PatchFace& face : s.faces) face.label = behind.at(key_of(face.corners));
  }
  [[nodiscard]] static std::vector<std::uint32_t> key_of(std::vector<std::uint32_t> corners) {
    sort_unique(corners);
    return corners;
  }

  void extend(SweptSection s, double length_mm) {
    const std::string& name = patch(s.patches[0]).name;
    for (const std::uint32_t v : s.vertices)
      if (std::abs((point(v) - s.centre_mm).dot(s.normal)) > 0.01 * s.reach_mm)
        throw Error(ErrorKind::kBadInput, fmt::format("{}: {} is not flat; extensions stand on flat openings",
                                                      option_name("extend"), name));
    constexpr double kLowestRow = 0.25;  // Of the edges.
    if (!s.is_clear)
      result_.notes.push_back(
          fmt::format("{}: the extension of {} is perpendicular to the opening: the walls before it do not "
                      "show the vessel's direction; cut it further inside, where it runs straight",
                      option_name("extend"), name));
    const double cosine = s.axis.dot(s.normal);
    const double slant_mm = s.reach_mm * std::sqrt(std::max(0.0, 1 - cosine * cosine));
    const double min_mm = slant_mm + kLowestRow * s.edge_mm;
    find_circle(s);
    find_ramp(s, std::max(length_mm, min_mm) - slant_mm);
    const std::optional<Hit> hit = first_hit(s, std::max(length_mm, min_mm) + s.radius_mm);
    double given_mm = std::max(length_mm, min_mm);
    if (hit) given_mm = std::min(given_mm, hit->along_mm - s.radius_mm);
    if (given_mm < min_mm) given_mm = 0;
    if (given_mm != length_mm) {
      const std::string reason =
          given_mm < length_mm   ? "another part of the surface is in the way at " + place_text(hit->place_mm)
          : slant_mm > length_mm ? std::string("it is cut off obliquely")
                                 : fmt::format("its edges are {:.3g} mm long", s.edge_mm);
      result_.notes.push_back(
          fmt::format("{}: the extension of {} is {:.4g} mm long instead of {:.4g} mm: {}",
                      option_name("extend"), name, given_mm, length_mm, reason));
    }
    if (given_mm == 0) return;
    if (mesh().view().cell_count() > 0) find_labels(s);
    s.ramp.set_length(std::min(s.ramp.length_mm(), given_mm - slant_mm));
    sweep(s, given_mm);
  }

  /// The slopes are those of the first one or two rings of the wall: further in it may taper otherwise.
  void find_ramp(SweptSection& s, double most_mm) const {
    constexpr double kDepth = 0.15, kRows = 1.25;
    if (!s.is_clear) return;
    WallRamp ramp(s.axis, s.reach_mm);
    for_each_wall_before(
        s, std::max(kDepth * s.reach_mm, kRows * row_height_mm(s)),
        [&](const Vec3& off, const Vec3& normal, double area) { ramp.add_wall(off, normal, area); });
    ramp.fit();
    ramp.set_length(std::min(WallRamp::kRadii * s.radius_mm, most_mm));
    double steepest = 0;
    for (const std::uint32_t v : s.vertices)
      steepest = std::max(steepest, ramp.slope(point(v) - s.centre_mm).norm());
    ramp.limit(steepest, s.axis.dot(s.normal));
    s.ramp = ramp;
  }

  /// Rays from the centre to the vertices, until the rim, along which the section is scaled to a circle.
  void find_circle(SweptSection& s) {
    if (!transition_) return;
    const Vec3 u = s.axis.unitOrthogonal(), v = s.axis.cross(u);
    const auto flat = [&](std::uint32_t at) {
      const Vec3 off = point(at) - s.centre_mm;
      return Vec2(u.dot(off), v.dot(off));
    };
    std::vector<std::pair<Vec2, Vec2>> rim;
    double doubled_mm2 = 0, of_unit_circle = 0;
    for (const auto& [from, to] : rim_of(s)) {
      const auto& [p, q] = rim.emplace_back(flat(from), flat(to));
      const double across = p.x() * q.y() - p.y() * q.x();
      doubled_mm2 += across;
      of_unit_circle += across / (p.norm() * q.norm());
    }
    const double radius_mm = std::sqrt(doubled_mm2 / of_unit_circle);
    std::vector<double> factors;
    bool is_star = doubled_mm2 > 0 && of_unit_circle > 1;  // 2.6 to 2 pi; of a ring 0, but for rounding.
    for (const std::uint32_t at : s.vertices) {
      const Vec2 ray = flat(at);
      int hits = 0;
      double rim_mm = radius_mm;
      for (const auto& [p, q] : rim) {
        const double before = ray.x() * p.y() - ray.y() * p.x(), after = ray.x() * q.y() - ray.y() * q.x();
        if (!(before <= 0 && after > 0)) continue;  // Passes the ray's line anticlockwise.
        const Vec2 hit = p + before / (before - after) * (q - p);
        if (hit.dot(ray) <= 0) continue;
        ++hits;
        rim_mm = hit.norm();
      }
      is_star = is_star && (hits == 1 || ray.norm() < 1e-9 * radius_mm);
      factors.push_back(radius_mm / rim_mm);
    }
    if (!is_star) {
      result_.notes.push_back(fmt::format("{}: the section of {} is not star-shaped, and stays as it is",
                                          option_name("extend_circle"), patch(s.patches[0]).name));
      return;
    }
    s.transition_mm = transition_->in_mm(s.radius_mm);
    s.of_circle = std::move(factors);
  }
  /// Edges with one face of the section, as that runs.
  [[nodiscard]] static std::vector<std::pair<std::uint32_t, std::uint32_t>> rim_of(const SweptSection& s) {
    std::map<std::uint64_t, int> count;
    for (const PatchFace& face : s.faces)
      for (std::size_t i = 0; i < face.corners.size(); ++i)
        ++count[edge_key(face.corners[i], face.corners[(i + 1) % face.corners.size()])];
    std::vector<std::pair<std::uint32_t, std::uint32_t>> rim;
    for (const PatchFace& face : s.faces)
      for (std::size_t i = 0; i < face.corners.size(); ++i) {
        const std::uint32_t from = face.corners[i], to = face.corners[(i + 1) % face.corners.size()];
        if (count.at(edge_key(from, to)) == 1) rim.emplace_back(from, to);
      }
    return rim;
  }

  struct Hit {
    double along_mm = 0;
    Vec3 place_mm = Vec3::Zero();
  };
  /// Where along the axis another part of the boundary is nearer than an edge.
  [[nodiscard]] std::optional<Hit> first_hit(const SweptSection& s, double last_mm) const {
    const Vec3 u = s.axis.unitOrthogonal(), v = s.axis.cross(u);
    const double half_width_mm =  // Of what a square column around the axis holds.
        s.reach_mm + s.ramp.max_displacement_mm() + s.edge_mm;
    const auto is_in_way = [&](std::span<const std::uint32_t> face) {
      bool is_beyond = false;
      Vec2 least = Vec2::Constant(half_width_mm), most = -least;
      for (const std::uint32_t at : face) {
        const Vec3 off = point(at) - s.centre_mm;
        is_beyond = is_beyond || off.dot(s.normal) > 0.01 * s.edge_mm;
        const Vec2 across(off.dot(u), off.dot(v));
        least = least.cwiseMin(across);
        most = most.cwiseMax(across);
      }
      return is_beyond && (least.array() < half_width_mm).all() && (most.array() > -half_width_mm).all();
    };
    std::vector<Cell<3>> beyond;
    for_each_patch_face(mesh(), [&](std::span<const std::uint32_t> face, std::int32_t p) {
      if (s.has(p) || !is_in_way(face)) return;
      for (std::size_t i = 2; i < face.size(); ++i) beyond.push_back({face[0], face[i - 1], face[i]});
    });
    if (beyond.empty()) return std::nullopt;
    const TriangleTree tree(mesh().points, beyond);
    for (double along_mm = 0; along_mm < last_mm + s.edge_mm; along_mm += 0.5 * s.edge_mm)
      for (const std::uint32_t v : s.vertices)
        if (const auto found = tree.nearest(s.swept(point(v), v, along_mm), s.edge_mm);
            found.triangle != TriangleTree::kNone)
          return Hit{along_mm, found.point};
    return std::nullopt;
  }

  /// The section's edges; of a surface, whose rims are often finer than its walls, the walls' where longer.
  [[nodiscard]] double row_height_mm(const SweptSection& s) const {
    if (mesh().view().cell_count() > 0) return s.edge_mm;
    return std::max(s.edge_mm, std::min(wall_edge_mm_, kMaxRowOfRadius * s.radius_mm));
  }

  /// Rows of cells, from the section to the end.
  void sweep(const SweptSection& s, double length_mm) {
    const auto rows = static_cast<std::size_t>(std::max(1.0, std::round(length_mm / row_height_mm(s))));
    add_points(s, length_mm, rows);
    const bool has_quads =
        std::ranges::any_of(s.faces, [](const PatchFace& face) { return face.corners.size() == 4; });
    const bool splits = cells_ == LayerCells::kTetrahedra && !has_quads;
    add_sides(s, rows, splits);
    if (mesh().view().cell_count() > 0) add_cells(s, rows, splits);
    move_opening(s, rows);
  }

  void add_cells(const SweptSection& s, std::size_t rows, bool splits) {
    MixedMesh prisms;
    for (std::size_t row = 0; row < rows; ++row)
      for (const PatchFace& face : s.faces) {
        const auto low = [&](std::size_t i) { return vertex(s, face.corners[i], row); };
        const auto up = [&](std::size_t i) { return vertex(s, face.corners[i], row + 1); };
        if (face.corners.size() == 3) {
          prisms.prisms.push_back({low(0), low(2), low(1), up(0), up(2), up(1)});
          prisms.prism_labels.push_back(face.label);
        } else {
          result_.mesh.hexahedra.push_back({low(0), low(1), low(2), low(3), up(0), up(1), up(2), up(3)});
          result_.mesh.hexahedron_labels.push_back(face.label);
        }
      }
    add_prisms(prisms, splits);
  }

  /// The vertex that one of the section has in a row; row 0 is the section.
  [[nodiscard]] std::uint32_t vertex(const SweptSection& s, std::uint32_t v, std::size_t row) const {
    if (row == 0) return v;
    const auto at = std::ranges::lower_bound(s.vertices, v) - s.vertices.begin();
    return first_new_ + static_cast<std::uint32_t>((row - 1) * s.vertices.size()) +
           static_cast<std::uint32_t>(at);
  }

  void add_points(const SweptSection& s, double length_mm, std::size_t rows) {
    MixedMesh& m = result_.mesh;
    first_new_ = static_cast<std::uint32_t>(m.points.size());
    for (std::size_t row = 1; row <= rows; ++row)
      for (const std::uint32_t v : s.vertices) {
        const double way_mm = static_cast<double>(row) / static_cast<double>(rows) *
                              (length_mm - (m.points[v] - s.centre_mm).dot(s.axis));
        m.points.push_back(s.swept(m.points[v], v, way_mm));
        if (!m.metric.empty()) m.metric.push_back(m.metric[v]);
        if (!m.sizes_mm.empty()) m.sizes_mm.push_back(m.sizes_mm[v]);
      }
  }

  /// Faces on the edges where the section's label ends: each goes on with the patch that meets it there.
  void add_sides(const SweptSection& s, std::size_t rows, bool splits) {
    std::map<std::uint64_t, std::pair<std::size_t, std::int32_t>>
        besides;  // Count of the section's faces; patch.
    std::vector<bool> is_of_section(mesh().points.size(), false);
    for (const std::uint32_t v : s.vertices) is_of_section[v] = true;
    for_each_patch_face(mesh(), [&](std::span<const std::uint32_t> face, std::int32_t p) {
      for (std::size_t i = 0; i < face.size(); ++i) {
        const std::uint32_t from = face[i], to = face[(i + 1) % face.size()];
        if (!is_of_section[from] || !is_of_section[to]) continue;
        auto& [count, other] = besides.try_emplace(edge_key(from, to), 0, -1).first->second;
        if (s.has(p))
          ++count;
        else
          other = p;
      }
    });
    for (const PatchFace& face : s.faces)
      for (std::size_t i = 0; i < face.corners.size(); ++i) {
        const std::uint32_t a = face.corners[i], b = face.corners[(i + 1) % face.corners.size()];
        const std::int32_t p = side_patch(besides.at(edge_key(a, b)).second, face.label);
        // Between two labels the side belongs to the first of its patch.
        const bool is_side =
            p >= 0 && (besides.at(edge_key(a, b)).first == 1 || patch(p).labels[0] == face.label);
        if (!is_side) continue;
        for (std::size_t row = 0; row < rows; ++row)
          add_side({vertex(s, a, row), vertex(s, b, row), vertex(s, b, row + 1), vertex(s, a, row + 1)}, p,
                   splits);
      }
  }

  /// The patch that goes on; where another opening meets the section at an edge, the label's wall.
  [[nodiscard]] std::int32_t side_patch(std::int32_t beside, Label label) const {
    if (beside < 0 || patch(beside).kind != PatchKind::kOpening) return beside;
    std::int32_t wall = -1;
    for (std::size_t p = 0; p < patches().size(); ++p)
      if (patches()[p].kind == PatchKind::kWall && (wall < 0 || patches()[p].labels[0] == label)) {
        wall = static_cast<std::int32_t>(p);
        if (patches()[p].labels[0] == label) break;
      }
    if (wall < 0)
      throw Error(ErrorKind::kBadInput,
                  fmt::format("{}: {} ends at an edge beside the section, and there is no wall "
                              "to go on instead",
                              option_name("extend"), patch(beside).name));
    return wall;
  }

  void add_side(const Cell<4>& side, std::int32_t p, bool splits) {
    MixedMesh& m = result_.mesh;
    if (!splits) {
      m.quadrilaterals.push_back(side);
      m.quadrilateral_patches.push_back(p);
      return;
    }
    // From the lowest corner on, as split_into_tetrahedra() has it.
    const auto low = static_cast<std::size_t>(std::ranges::min_element(side) - side.begin());
    const auto at = [&](std::size_t i) { return side[(low + i) % 4]; };
    m.triangles.push_back({at(0), at(1), at(2)});
    m.triangles.push_back({at(0), at(2), at(3)});
    m.triangle_patches.insert(m.triangle_patches.end(), 2, p);
  }

  void add_prisms(const MixedMesh& prisms, bool splits) {
    MixedMesh& m = result_.mesh;
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    if (!splits) {
      append(m.prisms, prisms.prisms);
      append(m.prism_labels, prisms.prism_labels);
      return;
    }
    const MixedMesh split = split_into_tetrahedra(prisms.view());
    append(m.tetrahedra, split.tetrahedra);
    append(m.tetrahedron_labels, split.tetrahedron_labels);
  }

  void move_opening(const SweptSection& s, std::size_t rows) {
    MixedMesh& m = result_.mesh;
    for (std::size_t t = 0; t < m.triangles.size(); ++t)
      if (s.has(m.triangle_patches[t]))
        for (std::uint32_t& v : m.triangles[t]) v = vertex(s, v, rows);
    for (std::size_t q = 0; q < m.quadrilaterals.size(); ++q)
      if (s.has(m.quadrilateral_patches[q]))
        for (std::uint32_t& v : m.quadrilaterals[q]) v = vertex(s, v, rows);
  }

  static constexpr double kMaxRowOfRadius = 0.25;  // Ramps, and those to a circle, are smooth then.

  LayerCells cells_;
  std::optional<LocalLength> transition_;
  ExtrudedMesh result_;
  double wall_edge_mm_ = 0;      // The mean, before anything is extended.
  std::uint32_t first_new_ = 0;  // Of the sweep that is being made.
};

}  // namespace

ExtrudedMesh extrude_openings(const MixedMesh& mesh, std::span<const NamedLength> lengths, LayerCells cells,
                              const std::optional<LocalLength>& transition) {
  return Extruder(mesh, cells, transition).make(lengths);
}

}  // namespace lumesh
