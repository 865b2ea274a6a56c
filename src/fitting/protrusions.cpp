#include "protrusions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "boundary_tree.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/geometry/triangle_intersection.hpp"
#include "lumesh/parallel/loops.hpp"
#include "star_quality.hpp"

namespace lumesh::fitting {

namespace {

class ProtrusionGrower {
 public:
  ProtrusionGrower(WorkMesh& mesh, BoundaryModel& boundary, const BoundaryStars& surface,
                   const BoundaryTree& tree, const ImageDomain& domain, const ProtrusionOptions& options)
      : mesh_(mesh),
        boundary_(boundary),
        surface_(surface),
        tree_(tree),
        domain_(domain),
        options_(options),
        keep_(mesh.tets.size(), 1),
        used_(mesh.positions.size(), 0) {}

  std::size_t run(const std::vector<Deviation>& deviations) {
    std::vector<std::vector<Option>> options(deviations.size());
    parallel::for_each_index(deviations.size(), 4,
                             [&](std::size_t i) { options[i] = options_for(deviations[i]); });
    std::size_t reached = 0;
    for (const std::vector<Option>& choice : options) {
      const auto best = std::ranges::find_if(choice, [&](const Option& o) { return is_free(o); });
      if (best == choice.end()) continue;
      carry_out(*best);
      ++reached;
    }
    if (reached == 0) return 0;
    drop_what_changed_sides();
    build_stars(mesh_);
    return reached;
  }

 private:
  struct Attempt {
    Vec3 probe_mm;
    Vec3 place_mm;     // on the boundary, near the probe
    double before_mm;  // the probe's distance from the surface
    bool is_outlier;   // the surface runs far inside or outside
  };
  /// A triangle to be replaced by three, which join its edges to a point: a new vertex where `tet` is
  /// none, the far vertex of a tetrahedron that changes sides otherwise. Or, with the neighbour across its
  /// edge `shared`, to the other two sides of the tetrahedron that fills the valley between both.
  struct Option {
    std::uint32_t triangle;
    std::uint32_t tet;
    Vec3 apex;
    double distance_mm = 0;  // of the probe afterwards
    std::size_t shared = 3;
    std::uint32_t neighbour = kNoTet;
    std::uint32_t top = kNoTet;  // the neighbour's far corner
  };

  /// Options that would bring the surface closer to a deviation's probe, the best first.
  [[nodiscard]] std::vector<Option> options_for(const Deviation& deviation) const {
    const Probe& probe = deviation.probe;
    const std::optional<Vec3> place = domain_.project(
        probe.position_mm, {probe.materials[0], probe.materials[1]}, 2 * domain_.voxel_size_mm());
    const Attempt attempt{probe.position_mm, place.value_or(probe.position_mm), deviation.distance_mm,
                          deviation.is_outlier};
    std::vector<Option> options;
    for (const std::uint32_t i : candidates(deviation.triangle, probe)) {
      if (const std::optional<Option> best = best_at(i, attempt)) options.push_back(*best);
      for (std::size_t e = 0; e < 3; ++e) {
        if (const std::optional<Option> filled = fill_at(i, e, attempt)) options.push_back(*filled);
      }
    }
    std::ranges::stable_sort(options,
                             [](const Option& a, const Option& b) { return a.distance_mm < b.distance_mm; });
    return options;
  }

  [[nodiscard]] std::optional<Option> best_at(std::uint32_t i, const Attempt& attempt) const {
    const BoundaryTriangle& t = boundary_.triangles[i];
    const TriangleCorners p = corners_of(mesh_, t.vertices);
    const Vec3 middle = triangle_centre(p[0], p[1], p[2]);
    const Vec3 normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    const double height = normal.dot(attempt.place_mm - middle);
    std::uint32_t tet = kNoTet;
    Vec3 from = middle;
    if (height < 0 || domain_.is_meshed(t.outside)) {
      const std::optional<std::uint32_t> found = behind(t.vertices, height > 0 ? t.outside : t.inside);
      if (!found) return std::nullopt;
      tet = *found;
      const std::uint32_t far = far_corner(tet, t.vertices);
      if (is_at_boundary(far) || is_fixed(far)) return std::nullopt;
      from = mesh_.positions[far];
    }
    std::optional<Option> best;
    for (const double sideways : {0.0, 0.4, 0.8}) {
      const Vec3 target = attempt.place_mm + sideways * (middle + height * normal - attempt.place_mm);
      for (const double part : {1.0, 0.85, 0.7, 0.55, 0.4, 0.2, 0.0}) {
        if (part < 0.3 && !options_.allows_temporary_deviation) continue;
        Option option{i, tet, from + part * (target - from)};
        if (domain_.beyond_cut(option.apex)) continue;
        option.distance_mm = distance_mm(p, option, attempt.probe_mm);
        if (option.distance_mm >
            (best ? best->distance_mm
                  : (options_.allows_temporary_deviation ? 1.0 : 0.8) * attempt.before_mm))
          continue;
        if (lies_at_boundary(t, p, option) && angles_good(option) && (tet != kNoTet || !hits_surface(option)))
          best = option;
      }
    }
    return best;
  }

  /// The tetrahedron between a triangle and its neighbour across an edge, both towards the background.
  [[nodiscard]] std::optional<Option> fill_at(std::uint32_t i, std::size_t edge,
                                              const Attempt& attempt) const {
    const BoundaryTriangle& t = boundary_.triangles[i];
    if (domain_.is_meshed(t.outside)) return std::nullopt;
    const std::uint32_t a = t.vertices[edge], b = t.vertices[(edge + 1) % 3], c = t.vertices[(edge + 2) % 3];
    Option option{i, kNoTet, Vec3::Zero()};
    option.shared = edge;
    for (const std::uint32_t j : surface_.triangles(a)) {
      const BoundaryTriangle& other = boundary_.triangles[j];
      if (j == i || !has_corner(other.vertices, b)) continue;
      if (option.neighbour != kNoTet || other.inside != t.inside || other.outside != t.outside)
        return std::nullopt;
      option.neighbour = j;
      option.top = third_corner(other.vertices, a, b);
    }
    if (option.neighbour == kNoTet || is_fixed(option.top) || are_neighbours(c, option.top))
      return std::nullopt;
    option.apex = mesh_.positions[option.top];
    const TriangleCorners p = corners_of(mesh_, t.vertices);
    option.distance_mm = distance_mm(p, option, attempt.probe_mm);
    const bool useful = attempt.is_outlier
                            ? lies_inside(t, p, option)
                            : option.distance_mm <= 0.8 * attempt.before_mm && lies_at_boundary(t, p, option);
    const bool good = useful && angles_good(option) && !hits_surface(option) &&
                      !hits_surface(from_other_side(option, a, c));
    return good ? std::optional(option) : std::nullopt;
  }

  /// The same, as seen from the neighbour; `a` is the first corner of the shared edge, `c` the triangle's far
  /// corner.
  [[nodiscard]] Option from_other_side(const Option& o, std::uint32_t a, std::uint32_t c) const {
    const Triangle& t = boundary_.triangles[o.neighbour].vertices;
    const auto end_of_edge = static_cast<std::size_t>(std::ranges::find(t, a) - t.begin());
    Option other = o;
    std::swap(other.triangle, other.neighbour);
    other.shared = (end_of_edge + 2) % 3;
    other.top = c;
    other.apex = mesh_.positions[c];
    return other;
  }

  /// Also where it has got there only now, so that its materials do not say so.
  [[nodiscard]] bool is_at_boundary(std::uint32_t v) const {
    return boundary_.sets[v].size() >= 2 || !surface_.triangles(v).empty();
  }
  [[nodiscard]] bool is_fixed(std::uint32_t v) const {
    return v < options_.fixed.size() && options_.fixed[v] != 0;
  }
  [[nodiscard]] bool touches_fixed(const Triangle& t) const {
    return std::ranges::any_of(t, [&](std::uint32_t v) { return is_fixed(v); });
  }

  /// Whether an edge of the mesh joins two vertices.
  [[nodiscard]] bool are_neighbours(std::uint32_t a, std::uint32_t b) const {
    const auto star = mesh_.star(a);
    return std::ranges::any_of(star, [&](std::uint32_t t) { return has_corner(mesh_.tets[t], b); });
  }

  [[nodiscard]] bool angles_good(const Option& o) const {
    const Triangle& t = boundary_.triangles[o.triangle].vertices;
    if (o.tet == kNoTet) {
      const TriangleCorners p = corners_of(mesh_, t);
      return angles_good(p[0], p[1], p[2], o.apex);
    }
    const bool stays = domain_.is_meshed(other_side(o));
    return star_good(far_corner(o.tet, t), o.apex, stays ? kNoTet : o.tet);
  }

  /// The material that the tetrahedron of an option goes to.
  [[nodiscard]] Material other_side(const Option& o) const {
    const BoundaryTriangle& t = boundary_.triangles[o.triangle];
    return mesh_.materials[o.tet] == t.inside ? t.outside : t.inside;
  }

  /// Whether nothing near has changed since the options were found.
  [[nodiscard]] bool is_free(const Option& o) const {
    const Triangle& t = boundary_.triangles[o.triangle].vertices;
    if (std::ranges::any_of(t, [&](std::uint32_t v) { return used_[v] != 0; })) return false;
    if (o.tet != kNoTet) return used_[far_corner(o.tet, t)] == 0;
    if (o.top != kNoTet && used_[o.top] != 0) return false;
    return std::ranges::none_of(fresh_, [&](const Triangle& f) { return hits(f, o); });
  }

  void carry_out(const Option& o) {
    const BoundaryTriangle base = boundary_.triangles[o.triangle];
    const MaterialSet pair = {base.inside, base.outside};
    if (o.top != kNoTet) {
      add_tetrahedron(base, o.top);
      fill_valley(o);
      return;
    }
    if (o.tet == kNoTet) {
      const auto v = static_cast<std::uint32_t>(mesh_.positions.size());
      mesh_.positions.push_back(o.apex);
      used_.push_back(1);
      boundary_.sets.push_back(pair);
      add_tetrahedron(base, v);
      open_towards(o.triangle, v);
      return;
    }
    const Material to = other_side(o);
    const std::uint32_t far = far_corner(o.tet, base.vertices);
    mesh_.positions[far] = o.apex;
    boundary_.sets[far] = pair;
    if (domain_.is_meshed(to))
      mesh_.materials[o.tet] = to;
    else
      keep_[o.tet] = 0;
    open_towards(o.triangle, far);
    for (const std::uint32_t s : mesh_.star(far)) {
      for (const std::uint32_t w : mesh_.tets[s]) used_[w] = 1;
    }
  }

  void add_tetrahedron(const BoundaryTriangle& base, std::uint32_t top) {
    mesh_.tets.push_back({base.vertices[0], base.vertices[1], base.vertices[2], top});
    mesh_.materials.push_back(base.inside);
    keep_.push_back(1);
    for (const std::uint32_t w : base.vertices) used_[w] = 1;
    used_[top] = 1;
  }

  /// The nearest triangle and those around its corners, by their distance from the probe.
  [[nodiscard]] std::vector<std::uint32_t> candidates(std::uint32_t nearest, const Probe& probe) const {
    std::vector<std::uint32_t> found;
    for (const std::uint32_t v : boundary_.triangles[nearest].vertices) {
      for (const std::uint32_t i : surface_.triangles(v)) {
        const BoundaryTriangle& t = boundary_.triangles[i];
        if (ascending(t.inside, t.outside) == probe.materials && !touches_fixed(t.vertices))
          found.push_back(i);
      }
    }
    const auto distance2 = [&](std::uint32_t i) {
      const TriangleCorners p = corners_of(mesh_, boundary_.triangles[i].vertices);
      return (triangle_centre(p[0], p[1], p[2]) - probe.position_mm).squaredNorm();
    };
    sort_unique(found, [&](std::uint32_t a, std::uint32_t b) {
      const double da = distance2(a), db = distance2(b);
      return da != db ? da < db : a < b;
    });
    return found;
  }

  [[nodiscard]] bool angles_good(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) const {
    if (!(tetrahedron_volume(a, b, c, d) > 0)) return false;
    const auto angles = dihedral_angles_deg(a, b, c, d);
    const auto [smallest, largest] = std::ranges::minmax_element(angles);
    return *smallest >= options_.limits.min_deg && *largest <= options_.limits.max_deg;
  }

  /// Replaces a boundary triangle by the three that join its edges to a vertex.
  void open_towards(std::uint32_t i, std::uint32_t v) {
    const BoundaryTriangle base = boundary_.triangles[i];
    for (std::size_t e = 0; e < 3; ++e) {
      const BoundaryTriangle side{
          {base.vertices[e], base.vertices[(e + 1) % 3], v}, base.inside, base.outside};
      if (e == 0)
        boundary_.triangles[i] = side;
      else
        boundary_.triangles.push_back(side);
      fresh_.push_back(side.vertices);
    }
  }

  void fill_valley(const Option& o) {
    const BoundaryTriangle base = boundary_.triangles[o.triangle];
    for (std::size_t n = 1; n < 3; ++n) {
      const std::size_t e = (o.shared + n) % 3;
      const Triangle side = {base.vertices[e], base.vertices[(e + 1) % 3], o.top};
      boundary_.triangles[n == 1 ? o.triangle : o.neighbour].vertices = side;
      fresh_.push_back(side);
    }
  }

  /// Distance of a point from the new triangles.
  [[nodiscard]] static double distance_mm(const TriangleCorners& p, const Option& o, const Vec3& from) {
    double min2 = std::numeric_limits<double>::infinity();
    for (std::size_t e = 0; e < 3; ++e) {
      if (e == o.shared) continue;
      const Vec3 x = closest_point_on_triangle(from, p[e], p[(e + 1) % 3], o.apex);
      min2 = std::min(min2, (x - from).squaredNorm());
    }
    return std::sqrt(min2);
  }

  /// Whether the new triangles stay close to the boundary between their materials, and do not turn their
  /// backs to it.
  [[nodiscard]] bool lies_at_boundary(const BoundaryTriangle& base, const TriangleCorners& p,
                                      const Option& o) const {
    const Vec3& apex = o.apex;
    const auto off = [&](const Vec3& x) {
      return std::abs(domain_.separation(x, base.inside, base.outside).value) / domain_.voxel_size_mm();
    };
    constexpr double kTurned = 0.7;  // cosine; at protrusions the smooth boundary's normals say little
    const double most = options_.allows_temporary_deviation ? 1.6 : 0.9;
    if (o.top == kNoTet && off(apex) > (options_.allows_temporary_deviation ? 1.6 : 0.6)) return false;
    for (std::size_t e = 0; e < 3; ++e) {
      if (e == o.shared) continue;
      const Vec3& a = p[e];
      const Vec3& b = p[(e + 1) % 3];
      const Vec3 middle = triangle_centre(a, b, apex);
      if (off(middle) > most || off(0.5 * (a + apex)) > most) return false;
      const Vec3 inwards = domain_.separation(middle, base.inside, base.outside).gradient;
      const Vec3 normal = (b - a).cross(apex - a);
      if (normal.dot(inwards) > kTurned * normal.norm() * inwards.norm()) return false;
    }
    return true;
  }

  /// Whether a valley lies in the label and its filling nearly so.
  [[nodiscard]] bool lies_inside(const BoundaryTriangle& base, const TriangleCorners& p,
                                 const Option& o) const {
    const auto depth = [&](const Vec3& x) {
      return domain_.separation(x, base.inside, base.outside).value / domain_.voxel_size_mm();
    };
    const Vec3& a = p[o.shared];
    const Vec3& b = p[(o.shared + 1) % 3];
    const Vec3& c = p[(o.shared + 2) % 3];
    return depth((a + b + c + o.apex) / 4) > 0.3 && depth(0.5 * (c + o.apex)) > -0.3 &&
           depth(triangle_centre(a, c, o.apex)) > -0.3 && depth(triangle_centre(b, c, o.apex)) > -0.3;
  }

  /// Whether the sides of a cap would cut the surface or come close to folding onto it.
  [[nodiscard]] bool hits_surface(const Option& o) const {
    Box3 box(o.apex);
    for (const std::uint32_t v : boundary_.triangles[o.triangle].vertices) box.extend(mesh_.positions[v]);
    const std::vector<std::uint32_t> near = tree_.overlapping(box.min(), box.max());
    return std::ranges::any_of(near, [&](std::uint32_t i) {
      return i != o.triangle && i != o.neighbour && hits(boundary_.triangles[i].vertices, o);
    });
  }

  [[nodiscard]] bool hits(const Triangle& other, const Option& o) const {
    const Triangle& base = boundary_.triangles[o.triangle].vertices;
    const TriangleCorners p = corners_of(mesh_, base);
    const Vec3& apex = o.apex;
    const TriangleCorners q = corners_of(mesh_, other);
    constexpr double kMinGap = 0.94;  // cosine of 20 degrees
    for (std::size_t e = 0; e < 3; ++e) {
      const std::size_t f = (e + 1) % 3;
      // An edge of the cap through the other triangle.
      if (!has_corner(other, base[e]) && !has_corner(other, o.top) &&
          segment_meets_triangle(p[e], apex, q[0], q[1], q[2]))
        return true;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t l = (k + 1) % 3;
        // An edge of the other triangle through a side of the cap.
        const bool touches = other[k] == base[e] || other[k] == base[f] || other[l] == base[e] ||
                             other[l] == base[f] || other[k] == o.top || other[l] == o.top;
        if (!touches && segment_meets_triangle(q[k], q[l], p[e], p[f], apex)) return true;
      }
      if (!has_corner(other, base[e]) || !has_corner(other, base[f])) continue;
      // The neighbour across an edge: the gap between it and the side of the cap.
      std::size_t k = 0;
      while (has_corner(base, other[k])) ++k;
      const Vec3 along = (p[f] - p[e]).normalized();
      const auto away = [&](const Vec3& x) {
        const Vec3 d = x - p[e];
        return Vec3((d - along * along.dot(d)).normalized());
      };
      if (away(apex).dot(away(q[k])) > kMinGap) return true;
      if (tetrahedron_volume(p[0], p[1], p[2], q[k]) > 0 && tetrahedron_volume(p[e], p[f], apex, q[k]) < 0)
        return true;
    }
    return false;
  }

  [[nodiscard]] std::uint32_t far_corner(std::uint32_t t, const Triangle& face) const {
    std::size_t at = 0;
    while (has_corner(face, mesh_.tets[t][at])) ++at;
    return mesh_.tets[t][at];
  }

  [[nodiscard]] std::optional<std::uint32_t> behind(const Triangle& face, Material material) const {
    for (const std::uint32_t t : mesh_.star(face[0])) {
      const Corner4& c = mesh_.tets[t];
      const bool has = has_corner(c, face[0]) && has_corner(c, face[1]) && has_corner(c, face[2]);
      if (has && mesh_.materials[t] == material) return t;
    }
    return std::nullopt;
  }

  [[nodiscard]] bool star_good(std::uint32_t v, const Vec3& x, std::uint32_t without) const {
    const auto star = mesh_.star(v);
    return std::ranges::all_of(star, [&](std::uint32_t t) {
      if (t == without) return true;
      const auto at = [&](std::size_t c) {
        return mesh_.tets[t][c] == v ? x : mesh_.positions[mesh_.tets[t][c]];
      };
      return angles_good(at(0), at(1), at(2), at(3));
    });
  }

  void drop_what_changed_sides() {
    std::size_t kept = 0;
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      if (keep_[t] == 0) continue;
      mesh_.tets[kept] = mesh_.tets[t];
      mesh_.materials[kept++] = mesh_.materials[t];
    }
    mesh_.tets.resize(kept);
    mesh_.materials.resize(kept);
  }

  WorkMesh& mesh_;
  BoundaryModel& boundary_;
  const BoundaryStars& surface_;
  const BoundaryTree& tree_;
  const ImageDomain& domain_;
  const ProtrusionOptions& options_;
  std::vector<std::uint8_t> keep_;  // per tetrahedron
  std::vector<Triangle> fresh_;     // new ones of the boundary: a few
  std::vector<std::uint8_t> used_;  // per vertex: something around it has changed already
};

}  // namespace

std::size_t grow_protrusions(WorkMesh& mesh, BoundaryModel& boundary, const BoundaryStars& surface,
                             const ImageDomain& domain, const std::vector<Deviation>& deviations,
                             const ProtrusionOptions& options) {
  std::vector<Vec3> places;
  for (const Deviation& deviation : deviations) {
    for (const std::uint32_t v : boundary.triangles[deviation.triangle].vertices)
      places.push_back(mesh.positions[v]);
  }
  const BoundaryTree tree(mesh, boundary, places, kNearVoxels * domain.voxel_size_mm());
  return ProtrusionGrower(mesh, boundary, surface, tree, domain, options).run(deviations);
}

}  // namespace lumesh::fitting
