#include "exposed_tetrahedra.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/edge_key.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::fitting {

namespace {

struct TriangleHash {
  std::size_t operator()(const Triangle& t) const {
    return (t[0] * std::size_t{0x9e3779b1} ^ t[1]) * std::size_t{0x85ebca77} ^ t[2];
  }
};

Triangle sorted(Triangle t) {
  std::ranges::sort(t);
  return t;
}

class ExposedRemoval {
 public:
  ExposedRemoval(WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain)
      : mesh_(mesh), boundary_(boundary), domain_(domain), keep_(mesh.tets.size(), 1) {}

  std::vector<std::uint32_t> run() {
    std::vector<std::uint32_t> exposed = find_exposed();
    index_boundary(exposed);
    std::erase_if(exposed, [&](std::uint32_t t) { return try_drop(t) || common_cut(t) == 0; });
    drop_all(std::move(exposed));
    return finish();
  }

  /// Only tetrahedra that three faces expose, one of them among these triangles.
  void run_at(std::span<const std::uint32_t> triangles) {
    build_neighbours(mesh_);
    std::vector<std::uint32_t> exposed;
    for (const std::uint32_t i : triangles) {
      const Triangle& v = boundary_.triangles[i].vertices;
      for (const std::uint32_t t : mesh_.star(v[0]))
        if (has_corner(mesh_.tets[t], v[1]) && has_corner(mesh_.tets[t], v[2]) && open_faces(t) == 3 &&
            stands_near(t))
          exposed.push_back(t);
    }
    if (exposed.empty()) return;
    sort_unique(exposed);
    index_boundary(exposed);
    for (const std::uint32_t t : exposed) try_drop(t);
    finish();
  }

  void run_beyond_cuts() {
    std::vector<std::uint32_t> beyond = find_beyond_cuts();
    if (beyond.empty()) return;
    build_neighbours(mesh_);
    may_join_opening_ = true;
    index_boundary(beyond);
    drop_all(std::move(beyond));
    finish();
  }

 private:
  /// One that only one face exposes may go after those beside it.
  void drop_all(std::vector<std::uint32_t> tets) {
    while (std::erase_if(tets, [&](std::uint32_t t) { return try_drop(t); }) > 0) {
    }
  }
  std::vector<std::uint32_t> finish() {
    std::erase_if(boundary_.triangles, [](const BoundaryTriangle& t) { return t.vertices[0] == kNoTet; });
    sort_unique(touched_);
    for (const std::uint32_t v : touched_) boundary_.sets[v] = {};
    for (const BoundaryTriangle& t : boundary_.triangles)
      for (const std::uint32_t v : t.vertices)
        if (std::ranges::binary_search(touched_, v)) bind(boundary_.sets[v], t);
    return drop_tetrahedra(mesh_, boundary_, keep_);
  }

  [[nodiscard]] bool is_beyond(std::uint32_t v) const {
    return beyond_cuts_mm(domain_, boundary_.sets[v], mesh_.positions[v]) >
           kLittleBeyond * domain_.voxel_size_mm();
  }
  /// Ascending.
  [[nodiscard]] std::vector<std::uint32_t> find_beyond_cuts() const {
    std::vector<std::uint32_t> beyond;
    for (std::uint32_t v = 0; v < mesh_.positions.size(); ++v) {
      if (is_beyond(v)) beyond.insert(beyond.end(), mesh_.star(v).begin(), mesh_.star(v).end());
    }
    sort_unique(beyond);
    return beyond;
  }

  [[nodiscard]] int open_faces(std::uint32_t t) const {
    return static_cast<int>(std::ranges::count(mesh_.neighbours[t], kNoTet));
  }

  [[nodiscard]] std::vector<std::uint32_t> find_exposed() const {
    return parallel::collect<std::uint32_t>(mesh_.tets.size(), [&](std::size_t i, auto& out) {
      const auto t = static_cast<std::uint32_t>(i);
      const int open = open_faces(t);
      if (common_cut(t) != 0 ||
          (open >= 2 && !deep_inside(t) && (open == 3 || opens_wide(t) || hangs_out(t))))
        out.push_back(t);
    });
  }

  /// The cut plane that all corners belong in, which so leave the tetrahedron no room; 0: none.
  [[nodiscard]] Material common_cut(std::uint32_t t) const {
    const Corner4& corners = mesh_.tets[t];
    for (const Material m : boundary_.sets[corners[0]])
      if (domain_.is_cut(m) &&
          std::ranges::all_of(corners, [&](std::uint32_t v) { return boundary_.sets[v].contains(m); }))
        return m;
    return 0;
  }

  /// Tetrahedra at the ends of thin vessels are exposed too, but the label fills them.
  [[nodiscard]] bool deep_inside(std::uint32_t t) const {
    const double depth = domain_.separation(mesh_.centroid(t), mesh_.materials[t], 0).value;
    return depth > 0.3 * mesh_.longest_edge_mm(t);
  }

  /// Whether the face that it stands on is near the boundary: on one that is not, it may be a bump.
  [[nodiscard]] bool stands_near(std::uint32_t t) const {
    constexpr double kNear = 0.5;  // Voxels: more is a deviation.
    const auto inner =
        std::ranges::find_if(mesh_.neighbours[t], [](std::uint32_t other) { return other != kNoTet; });
    const auto [a, b, c] =
        face_of(mesh_.tets[t], static_cast<std::size_t>(inner - mesh_.neighbours[t].begin()));
    const Vec3 middle = triangle_centre(mesh_.positions[a], mesh_.positions[b], mesh_.positions[c]);
    return domain_.separation(middle, mesh_.materials[t], 0).value <= kNear * domain_.voxel_size_mm();
  }

  /// Where a corner belongs; where it is, if that is not known.
  [[nodiscard]] Vec3 target_of(std::uint32_t v) const {
    const MaterialSet& set = boundary_.sets[v];
    const Vec3& x = mesh_.positions[v];
    if (set.size() < 2) return x;
    return domain_.project(x, set, 4 * domain_.voxel_size_mm()).value_or(x);
  }

  /// More than 140 degrees between the two open faces, as they are or with their corners where these belong.
  [[nodiscard]] bool opens_wide(std::uint32_t t) const {
    std::array<Vec3, 4> now, then;
    for (std::size_t i = 0; i < 4; ++i) {
      now[i] = mesh_.positions[mesh_.tets[t][i]];
      then[i] = target_of(mesh_.tets[t][i]);
    }
    return opens_wide(t, now) || opens_wide(t, then);
  }

  [[nodiscard]] bool opens_wide(std::uint32_t t, const std::array<Vec3, 4>& places) const {
    std::array<Vec3, 2> normal;
    std::size_t n = 0;
    for (std::size_t f = 0; f < 4; ++f) {
      if (mesh_.neighbours[t][f] != kNoTet || n == 2) continue;
      const auto [a, b, c] = face_of(Corner4{0, 1, 2, 3}, f);
      normal[n++] = (places[b] - places[a]).cross(places[c] - places[a]).normalized();
    }
    return -normal[0].dot(normal[1]) < -0.766;
  }

  [[nodiscard]] bool hangs_out(std::uint32_t t) const {
    for (const std::uint32_t v : mesh_.tets[t]) {
      const MaterialSet& set = boundary_.sets[v];
      if (set.size() != 2 || set[0] != 0) continue;
      if (domain_.separation(mesh_.positions[v], set[1], set[0]).value < -0.1 * domain_.voxel_size_mm())
        return true;
    }
    return false;
  }

  /// Only triangles with an edge between corners of exposed tetrahedra matter.
  void index_boundary(const std::vector<std::uint32_t>& exposed) {
    std::vector<std::uint8_t> corner(mesh_.positions.size(), 0);
    for (const std::uint32_t t : exposed) {
      for (const std::uint32_t v : mesh_.tets[t]) corner[v] = 1;
    }
    const auto near =
        parallel::collect<std::uint32_t>(boundary_.triangles.size(), [&](std::size_t i, auto& out) {
          const Triangle& v = boundary_.triangles[i].vertices;
          if (corner[v[0]] + corner[v[1]] + corner[v[2]] >= 2) out.push_back(static_cast<std::uint32_t>(i));
        });
    for (const std::uint32_t i : near) add_to_index(i);
  }
  void add_to_index(std::uint32_t i) {
    const Triangle& v = boundary_.triangles[i].vertices;
    triangle_at_[sorted(v)] = i;
    for (std::size_t e = 0; e < 3; ++e) ++edge_use_[edge_key(v[e], v[(e + 1) % 3])];
  }
  void remove_from_index(std::uint32_t i) {
    const Triangle v = boundary_.triangles[i].vertices;
    triangle_at_.erase(sorted(v));
    for (std::size_t e = 0; e < 3; ++e) --edge_use_[edge_key(v[e], v[(e + 1) % 3])];
    boundary_.triangles[i].vertices[0] = kNoTet;
  }

  /// With two open faces the edge that they do not touch must lie inside, or the boundary would pinch there;
  /// with three there is nothing to pinch. The faces that come to light must belong to the same label. Where
  /// one that goes was in a cut plane, at the rim of an opening, they belong to the opening.
  bool try_drop(std::uint32_t t) {
    const int open = open_faces(t);
    if (open != 2 && open != 3) return false;
    const Material cut = common_cut(t);
    Material outside = cut;
    bool joins_opening = false;
    std::array<std::size_t, 4> faces_open{};
    std::size_t n = 0;
    for (std::size_t f = 0; f < 4; ++f) {
      const std::uint32_t other = mesh_.neighbours[t][f];
      if (other != kNoTet) {
        if (mesh_.materials[other] != mesh_.materials[t]) return false;
        continue;
      }
      const auto found = triangle_at_.find(sorted(face_of(mesh_.tets[t], f)));
      if (found == triangle_at_.end()) return false;
      const Material m = boundary_.triangles[found->second].outside;
      if (n > 0 && m != outside) {
        if (cut == 0 && (!may_join_opening_ || !domain_.is_cut(std::max(m, outside)))) return false;
        joins_opening = cut == 0;
      }
      if (cut == 0) outside = std::max(m, outside);
      faces_open[n++] = f;
    }
    if (open == 2) {
      const std::uint32_t a = mesh_.tets[t][faces_open[0]];
      const std::uint32_t b = mesh_.tets[t][faces_open[1]];
      if (const auto use = edge_use_.find(edge_key(a, b)); use != edge_use_.end() && use->second > 0)
        return false;
    }
    if (joins_opening && !comes_to_lie_in(t, domain_.cut_plane(outside))) return false;
    drop(t, outside);
    return true;
  }

  /// Whether the faces that come to light are in a cut plane, but for corners beyond it, which go later.
  [[nodiscard]] bool comes_to_lie_in(std::uint32_t t, const CutPlane& plane) const {
    for (std::size_t f = 0; f < 4; ++f) {
      if (mesh_.neighbours[t][f] == kNoTet) continue;
      for (const std::uint32_t v : face_of(mesh_.tets[t], f)) {
        const double off_mm = std::abs(plane.height(mesh_.positions[v]));
        if (!is_beyond(v) && off_mm > kLittleBeyond * domain_.voxel_size_mm()) return false;
      }
    }
    return true;
  }

  void drop(std::uint32_t t, Material outside) {
    keep_[t] = 0;
    touched_.insert(touched_.end(), mesh_.tets[t].begin(), mesh_.tets[t].end());
    for (std::size_t f = 0; f < 4; ++f) {
      const std::uint32_t other = mesh_.neighbours[t][f];
      Triangle face = face_of(mesh_.tets[t], f);
      if (other == kNoTet) {
        remove_from_index(triangle_at_.at(sorted(face)));
        continue;
      }
      for (std::uint32_t& back : mesh_.neighbours[other]) {
        if (back == t) back = kNoTet;
      }
      std::swap(face[1], face[2]);  // outwards of the tetrahedron behind
      boundary_.triangles.push_back({face, mesh_.materials[other], outside});
      add_to_index(static_cast<std::uint32_t>(boundary_.triangles.size() - 1));
    }
  }

  WorkMesh& mesh_;
  BoundaryModel& boundary_;
  const ImageDomain& domain_;
  std::vector<std::uint8_t> keep_;
  bool may_join_opening_ = false;
  std::vector<std::uint32_t> touched_;  // Corners of what was dropped.
  std::unordered_map<Triangle, std::uint32_t, TriangleHash> triangle_at_;
  std::unordered_map<std::uint64_t, int> edge_use_;
};

}  // namespace

std::vector<std::uint32_t> remove_exposed(WorkMesh& mesh, BoundaryModel& boundary,
                                          const ImageDomain& domain) {
  return ExposedRemoval(mesh, boundary, domain).run();
}

void remove_exposed_at(WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain,
                       std::span<const std::uint32_t> triangles) {
  ExposedRemoval(mesh, boundary, domain).run_at(triangles);
}

void remove_beyond_cuts(WorkMesh& mesh, BoundaryModel& boundary, const ImageDomain& domain) {
  ExposedRemoval(mesh, boundary, domain).run_beyond_cuts();
}

}  // namespace lumesh::fitting
