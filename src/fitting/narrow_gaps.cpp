#include "narrow_gaps.hpp"

#include <algorithm>
#include <optional>

#include "boundary_stars.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "star_quality.hpp"

namespace lumesh::fitting {

namespace {

using Edge = std::array<std::uint32_t, 2>;

class NarrowGaps {
 public:
  NarrowGaps(WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain,
             const std::vector<std::uint8_t>& fixed, const AngleLimits& limits)
      : mesh_(mesh),
        boundary_(boundary),
        domain_(domain),
        fixed_(fixed),
        limits_(limits),
        surface_(boundary, mesh.positions.size()) {}

  /// Closes one of the valleys at the triangles around a deviation.
  bool close_one(const Deviation& deviation) {
    std::optional<Merge> best;
    for (const std::uint32_t v : boundary_.triangles[deviation.triangle].vertices) {
      for (const std::uint32_t i : surface_.triangles(v)) {
        for (std::size_t e = 0; e < 3; ++e) {
          const std::optional<Merge> merge = merge_across(i, e);
          if (merge && (!best || merge->quality > best->quality)) best = merge;
        }
      }
    }
    if (best) carry_out(*best);
    return best.has_value();
  }

 private:
  struct Merge {
    std::uint32_t stays, goes;
    Vec3 place;
    double quality;
    std::vector<std::uint32_t> vanishing;  // triangles
  };

  [[nodiscard]] std::optional<Merge> merge_across(std::uint32_t i, std::size_t edge) const {
    const BoundaryTriangle& t = boundary_.triangles[i];
    if (domain_.is_meshed(t.outside) || domain_.is_cut(t.outside)) return std::nullopt;
    const std::uint32_t a = t.vertices[edge], b = t.vertices[(edge + 1) % 3], c = t.vertices[(edge + 2) % 3];
    for (const std::uint32_t j : surface_.triangles(a)) {
      const Triangle& other = boundary_.triangles[j].vertices;
      if (j == i || !has_corner(other, b)) continue;
      const std::uint32_t d = third_corner(other, a, b);
      if (!is_narrow(a, b, c, d) || !lies_inside(t, d)) return std::nullopt;
      return merge_of(c, d, {t.inside, t.outside});
    }
    return std::nullopt;
  }

  /// Whether the two triangles at an edge a-b, the first seen from outside, enclose less than 75 degrees
  /// outside.
  [[nodiscard]] bool is_narrow(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) const {
    constexpr double kNarrow = 0.26;  // cosine
    const auto at = [&](std::uint32_t v) -> const Vec3& { return mesh_.positions[v]; };
    const Vec3 along = (at(b) - at(a)).normalized();
    const auto away = [&](std::uint32_t v) {
      const Vec3 way = at(v) - at(a);
      return Vec3((way - along * along.dot(way)).normalized());
    };
    return tetrahedron_volume(at(a), at(b), at(c), at(d)) > 0 && away(c).dot(away(d)) > kNarrow;
  }

  /// Whether the valley between a triangle and a vertex should belong to the label.
  [[nodiscard]] bool lies_inside(const BoundaryTriangle& t, std::uint32_t d) const {
    Vec3 middle = mesh_.positions[d] / 4;
    for (const std::uint32_t v : t.vertices) middle += mesh_.positions[v] / 4;
    return domain_.separation(middle, t.inside, t.outside).value > 0.3 * domain_.voxel_size_mm();
  }

  [[nodiscard]] std::optional<Merge> merge_of(std::uint32_t c, std::uint32_t d,
                                              const MaterialSet& pair) const {
    const auto free = [&](std::uint32_t v) {
      return (v >= fixed_.size() || fixed_[v] == 0) && boundary_.sets[v] == pair;
    };
    if (!free(c) || !free(d)) return std::nullopt;
    std::vector<Edge> seam;
    Merge merge{c, d, Vec3::Zero(), 0, {}};
    for (const std::uint32_t i : surface_.triangles(c)) {
      const Edge rest = opposite_edge(boundary_.triangles[i].vertices, c);
      for (const std::uint32_t j : surface_.triangles(d)) {
        if (opposite_edge(boundary_.triangles[j].vertices, d) != rest) continue;
        seam.push_back(rest);
        merge.vanishing.insert(merge.vanishing.end(), {i, j});
      }
    }
    if (!is_path(seam) || !shares_only(c, d, seam)) return std::nullopt;
    for (const double part : {0.5, 0.3, 0.7, 0.1, 0.9}) {
      const Vec3 x = mesh_.positions[c] + part * (mesh_.positions[d] - mesh_.positions[c]);
      const double quality = std::min(worst_around(c, x), worst_around(d, x));
      if (quality <= merge.quality) continue;
      merge.quality = quality;
      merge.place = x;
    }
    return merge.quality >= angle_floor(limits_) ? std::optional(merge) : std::nullopt;
  }

  [[nodiscard]] static Edge opposite_edge(const Triangle& t, std::uint32_t v) {
    const std::size_t at = t[0] == v ? 0 : (t[1] == v ? 1 : 2);
    const std::uint32_t p = t[(at + 1) % 3], q = t[(at + 2) % 3];
    return {std::min(p, q), std::max(p, q)};
  }

  /// Whether edges form one path, open or closed: then the two discs of tetrahedra around the merged vertices
  /// join to one disc or one ball.
  [[nodiscard]] static bool is_path(const std::vector<Edge>& edges) {
    if (edges.empty()) return false;
    std::vector<std::uint32_t> reached = {edges[0][0]};
    std::vector<std::uint8_t> used(edges.size(), 0);
    for (std::size_t n = 0; n < reached.size(); ++n) {
      int here = 0;
      for (std::size_t e = 0; e < edges.size(); ++e) {
        if (edges[e][0] != reached[n] && edges[e][1] != reached[n]) continue;
        ++here;
        if (used[e] != 0) continue;
        used[e] = 1;
        reached.push_back(edges[e][0] == reached[n] ? edges[e][1] : edges[e][0]);
      }
      if (here > 2) return false;
    }
    return std::ranges::all_of(used, [](std::uint8_t u) { return u != 0; });
  }

  /// Whether two vertices have no edge in common, no neighbours but those of the seam, and no faces over the
  /// same edge but those that vanish.
  [[nodiscard]] bool shares_only(std::uint32_t c, std::uint32_t d, const std::vector<Edge>& seam) const {
    std::vector<std::uint32_t> on_seam;
    for (const Edge& e : seam) on_seam.insert(on_seam.end(), e.begin(), e.end());
    const std::vector<std::uint32_t> near_c = neighbours(c), near_d = neighbours(d);
    if (std::ranges::binary_search(near_c, d)) return false;
    const std::vector<Edge> faces_c = faces_over(c), faces_d = faces_over(d);
    return std::ranges::all_of(near_c,
                               [&](std::uint32_t v) {
                                 return !std::ranges::binary_search(near_d, v) ||
                                        std::ranges::find(on_seam, v) != on_seam.end();
                               }) &&
           std::ranges::all_of(faces_c, [&](const Edge& e) {
             return !std::ranges::binary_search(faces_d, e) || std::ranges::find(seam, e) != seam.end();
           });
  }

  [[nodiscard]] std::vector<std::uint32_t> neighbours(std::uint32_t v) const {
    std::vector<std::uint32_t> found;
    for (const std::uint32_t t : mesh_.star(v)) {
      for (const std::uint32_t w : mesh_.tets[t]) {
        if (w != v) found.push_back(w);
      }
    }
    sort_unique(found);
    return found;
  }

  /// The edges opposite to a vertex in the faces that hold it, ascending.
  [[nodiscard]] std::vector<Edge> faces_over(std::uint32_t v) const {
    std::vector<Edge> found;
    for (const std::uint32_t t : mesh_.star(v)) {
      for (const auto& [i, j] : kTetEdges) {
        const std::uint32_t p = mesh_.tets[t][i], q = mesh_.tets[t][j];
        if (p != v && q != v) found.push_back({std::min(p, q), std::max(p, q)});
      }
    }
    sort_unique(found);
    return found;
  }

  [[nodiscard]] double worst_around(std::uint32_t v, const Vec3& x) const {
    return StarQuality(mesh_, v).worst(x, angle_floor(limits_));
  }

  void carry_out(const Merge& merge) {
    const auto put = [&](std::uint32_t& v) {
      if (v == merge.goes) v = merge.stays;
    };
    mesh_.positions[merge.stays] = merge.place;
    for (const std::uint32_t t : mesh_.star(merge.goes)) {
      for (std::uint32_t& v : mesh_.tets[t]) put(v);
    }
    std::vector<std::uint32_t> touched;
    for (const std::uint32_t v : {merge.stays, merge.goes}) {
      for (const std::uint32_t i : surface_.triangles(v)) {
        const Triangle& t = boundary_.triangles[i].vertices;
        touched.insert(touched.end(), t.begin(), t.end());
        for (std::uint32_t& w : boundary_.triangles[i].vertices) put(w);
      }
    }
    std::vector<std::uint32_t> vanishing = merge.vanishing;
    std::sort(vanishing.rbegin(), vanishing.rend());
    for (const std::uint32_t i : vanishing)
      boundary_.triangles.erase(boundary_.triangles.begin() + static_cast<std::ptrdiff_t>(i));
    build_stars(mesh_);
    surface_ = BoundaryStars(boundary_, mesh_.positions.size());
    for (const std::uint32_t v : touched) {
      if (surface_.triangles(v).empty()) boundary_.sets[v] = MaterialSet();
    }
  }

  WorkMesh& mesh_;
  BoundaryModel& boundary_;
  const ImageDomain& domain_;
  const std::vector<std::uint8_t>& fixed_;
  const AngleLimits& limits_;
  BoundaryStars surface_;
};

}  // namespace

bool close_gap(WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain,
               const std::vector<Deviation>& deviations, const std::vector<std::uint8_t>& fixed,
               const AngleLimits& limits) {
  NarrowGaps gaps(mesh, boundary, domain, fixed, limits);
  return std::ranges::any_of(deviations, [&](const Deviation& deviation) {
    return deviation.is_outlier && gaps.close_one(deviation);
  });
}

}  // namespace lumesh::fitting
