#include "lumesh/mesh/cut_off_cells.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/geometry/area_order.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/cell_faces.hpp"
#include "lumesh/mesh/cell_sides.hpp"
#include "lumesh/mesh/edge_key.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/mesh/plane_heights.hpp"
#include "lumesh/mesh/points_in_use.hpp"
#include "lumesh/parallel/adjacency.hpp"

namespace lumesh {
namespace {

[[noreturn]] void throw_bad_cut(const std::string& message) {
  throw Error(ErrorKind::kBadInput, option_name("cut_planes") + ": " + message);
}

template <class Corners>
bool passes_through(const Corners& corners, const std::vector<double>& heights) {
  const auto is_above = [&](std::uint32_t v) { return heights[v] > 0; };
  const auto is_below = [&](std::uint32_t v) { return heights[v] < 0; };
  return std::ranges::any_of(corners, is_above) && std::ranges::any_of(corners, is_below);
}

/// Moves vertices near the plane into it.
class VertexSlide {
 public:
  VertexSlide(MixedMesh& mesh, const Vec3& normal, std::vector<double>& heights)
      : mesh_(mesh),
        normal_(normal),
        heights_(heights),
        tets_(parallel::cells_around(mesh.tetrahedra, mesh.points.size())),
        triangles_(parallel::cells_around(mesh.triangles, mesh.points.size())) {}

  /// The farthest way.
  double run() {
    std::vector<bool> is_of_other(mesh_.points.size(), false);  // Of a cell of another shape.
    const auto mark = [&](const auto& cells) {
      for (const auto& cell : cells)
        for (const std::uint32_t v : cell) is_of_other[v] = true;
    };
    mark(mesh_.pyramids), mark(mesh_.prisms), mark(mesh_.hexahedra);
    double farthest = 0;
    for (std::uint32_t v = 0; v < mesh_.points.size(); ++v)
      if (!is_of_other[v] && is_near(v)) farthest = std::max(farthest, move(v));
    return farthest;
  }

 private:
  /// Nearer to the plane than a quarter of the shortest edge that passes through it.
  [[nodiscard]] bool is_near(std::uint32_t v) const {
    constexpr double kShare = 0.25;
    if (heights_[v] == 0) return false;
    for (const std::uint32_t t : tets_.of(v))
      for (const std::uint32_t w : mesh_.tetrahedra[t])
        if (heights_[v] * heights_[w] < 0 &&
            std::abs(heights_[v]) < kShare * (std::abs(heights_[v]) + std::abs(heights_[w])))
          return true;
    return false;
  }

  /// How far it went; 0 if it has to stay.
  double move(std::uint32_t v) {
    const std::optional<Vec3> way = way_of(v);
    if (!way) return 0;
    const std::vector<double> volumes = volumes_around(v);
    const std::vector<Vec3> normals = normals_around(v);
    const bool stays =
        slide_point(v, *way, mesh_.points, heights_, [&] { return is_good(v, volumes, normals); });
    return stays ? way->norm() : 0;
  }

  /// Square to the plane inside, along the wall on one; none where walls bend or meet. An opening that the
  /// plane is parallel to goes with it.
  [[nodiscard]] std::optional<Vec3> way_of(std::uint32_t v) const {
    std::vector<Vec3> normals = normals_around(v);
    Vec3 mean = Vec3::Zero();
    std::optional<std::int32_t> patch;
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const std::uint32_t t = triangles_.of(v)[i];
      if (is_parallel(t)) continue;
      if (patch && mesh_.triangle_patches[t] != *patch) return std::nullopt;
      patch = mesh_.triangle_patches[t];
      mean += normals[i];
    }
    if (!patch) return Vec3(-heights_[v] * normal_);
    mean.stableNormalize();
    for (std::size_t i = 0; i < normals.size(); ++i)
      if (!is_parallel(triangles_.of(v)[i]) && normals[i].dot(mean) < kSmoothCosine * normals[i].norm())
        return std::nullopt;
    return way_into_plane(heights_[v], normal_, mean);
  }

  /// Whether a triangle is of an opening, or a plane of symmetry, that lies along the plane.
  [[nodiscard]] bool is_parallel(std::uint32_t t) const {
    constexpr double kParallel = 0.999;
    const PatchKind kind = mesh_.info.patches[static_cast<std::size_t>(mesh_.triangle_patches[t])].kind;
    return is_plane(kind) &&
           std::abs(triangle_normal(mesh_.points, mesh_.triangles[t]).dot(normal_)) > kParallel;
  }

  [[nodiscard]] std::vector<double> volumes_around(std::uint32_t v) const {
    std::vector<double> volumes;
    for (const std::uint32_t t : tets_.of(v)) {
      const auto& [a, b, c, d] = mesh_.tetrahedra[t];
      volumes.push_back(
          tetrahedron_volume(mesh_.points[a], mesh_.points[b], mesh_.points[c], mesh_.points[d]));
    }
    return volumes;
  }
  [[nodiscard]] std::vector<Vec3> normals_around(std::uint32_t v) const {
    std::vector<Vec3> normals;
    for (const std::uint32_t t : triangles_.of(v))
      normals.push_back(triangle_area_normal(mesh_.points, mesh_.triangles[t]));
    return normals;
  }

  [[nodiscard]] bool is_good(std::uint32_t v, const std::vector<double>& volumes,
                             const std::vector<Vec3>& normals) const {
    constexpr double kVolume = 0.2;
    const auto is_in_plane = [&](const auto& corners) {
      return std::ranges::all_of(corners, [&](std::uint32_t w) { return heights_[w] == 0; });
    };
    const std::vector<double> volumes_now = volumes_around(v);
    for (std::size_t i = 0; i < volumes.size(); ++i)
      if (is_in_plane(mesh_.tetrahedra[tets_.of(v)[i]]) || volumes_now[i] < kVolume * volumes[i])
        return false;
    const std::vector<Vec3> normals_now = normals_around(v);
    for (std::size_t i = 0; i < normals.size(); ++i)
      if ((is_in_plane(mesh_.triangles[triangles_.of(v)[i]]) && !is_parallel(triangles_.of(v)[i])) ||
          !turns_little(normals[i], normals_now[i]))
        return false;
    return true;
  }

  MixedMesh& mesh_;
  Vec3 normal_;
  std::vector<double>& heights_;
  parallel::Adjacency tets_, triangles_;
};

/// Divides cells and faces by the edges that pass through the plane.
class Division {
 public:
  Division(MixedMesh& mesh, std::vector<double>& heights) : mesh_(mesh), heights_(heights) {}

  /// Calls visit(part) for the parts of a tetrahedron or triangle, each on one side.
  template <std::size_t N, class Visit>
  void divide(const Cell<N>& corners, const Visit& visit) {
    const auto [low, high] = first_crossing_edge(corners);
    if (low == high) return visit(corners);
    const std::uint32_t middle = point_of(low, high);
    for (const std::uint32_t replaced : {low, high}) {
      Cell<N> part = corners;
      std::ranges::replace(part, replaced, middle);
      divide(part, visit);
    }
  }

 private:
  using Edge = std::pair<std::uint32_t, std::uint32_t>;

  /// In ascending order of edges; equal ends where there is none.
  template <std::size_t N>
  [[nodiscard]] Edge first_crossing_edge(const Cell<N>& corners) const {
    std::optional<Edge> first;
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = i + 1; j < N; ++j) {
        if (heights_[corners[i]] * heights_[corners[j]] >= 0) continue;
        const Edge edge = std::minmax(corners[i], corners[j]);
        if (!first || edge < *first) first = edge;
      }
    return first.value_or(Edge{0, 0});
  }

  std::uint32_t point_of(std::uint32_t low, std::uint32_t high) {
    return middles_.point_of(low, high, heights_, [&](std::uint32_t a, std::uint32_t b, double share) {
      const auto between = [&](auto& values) {
        if (!values.empty()) values.push_back((1 - share) * values[a] + share * values[b]);
      };
      between(mesh_.points);
      between(mesh_.metric);
      between(mesh_.sizes_mm);
    });
  }

  MixedMesh& mesh_;
  std::vector<double>& heights_;
  EdgeCrossings middles_;
};

class Cutter {
 public:
  Cutter(const MixedMesh& mesh, const Vec3& origin, const Vec3& normal)
      : mesh_(mesh),
        origin_(origin),
        normal_(normal),
        heights_(heights_over(mesh.points, origin, normal, 1e-10)) {}

  CellsCutOff run() {
    check_sides();
    made_.farthest_moved_mm = VertexSlide(mesh_, normal_, heights_).run();
    divide();
    if (mesh_.view().cell_count() == 0)
      throw_bad_cut("nothing of the mesh is left behind the plane at " + coordinates_text(origin_) +
                    kCutSide);
    add_openings();
    drop_unused_points();
    return made_;
  }
  [[nodiscard]] MixedMesh take() && { return std::move(mesh_); }

 private:
  using FaceKey = Cell<3>;

  void check_sides() const {
    if (std::ranges::none_of(heights_, [](double h) { return h > 0; }))
      throw_bad_cut("nothing of the mesh lies beyond the plane at " + coordinates_text(origin_) + kCutSide);
    const auto check = [&](const auto& cells) {
      for (const auto& cell : cells) {
        const bool is_beyond = heights_[cell[0]] > 0;
        for (const std::uint32_t v : cell)
          if (heights_[v] == 0 || (heights_[v] > 0) != is_beyond)
            throw_bad_cut("the plane passes through prisms, pyramids or hexahedra at " +
                          coordinates_text(mesh_.points[v]) +
                          "; cut the mesh before layers are made, or mesh the input with the cut");
      }
    };
    check(mesh_.pyramids), check(mesh_.prisms), check(mesh_.hexahedra);
  }

  void divide() {
    Division division(mesh_, heights_);
    std::vector<Cell<4>> tets;
    std::vector<Label> labels;
    for (std::size_t t = 0; t < mesh_.tetrahedra.size(); ++t) {
      const Cell<4> whole = mesh_.tetrahedra[t];
      bool is_whole = true;
      division.divide(whole, [&](const Cell<4>& part) {
        if (is_beyond(part)) {
          is_whole = false;
          for (const LocalFace& face : kTetrahedronFaces)
            note_face({part[face[0]], part[face[1]], part[face[2]]});
          return;
        }
        require_positive(part);
        tets.push_back(part);
        labels.push_back(mesh_.tetrahedron_labels[t]);
      });
      made_.removed += is_whole ? 0 : 1;
    }
    mesh_.tetrahedra = std::move(tets);
    mesh_.tetrahedron_labels = std::move(labels);
    divide_triangles(division);
    keep_before(mesh_.pyramids, mesh_.pyramid_labels);
    keep_before(mesh_.prisms, mesh_.prism_labels);
    keep_before(mesh_.hexahedra, mesh_.hexahedron_labels);
    keep_before(mesh_.quadrilaterals, mesh_.quadrilateral_patches);
  }

  /// Divides the boundary; faces in the plane are dropped: add_openings() makes those with a cell that stays
  /// anew.
  void divide_triangles(Division& division) {
    std::vector<Cell<3>> triangles;
    std::vector<std::int32_t> patches;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Cell<3> whole = mesh_.triangles[t];
      division.divide(whole, [&](const Cell<3>& part) {
        if (is_beyond(part) || beyond_.contains(sorted_corners(part))) return;
        triangles.push_back(part);
        patches.push_back(mesh_.triangle_patches[t]);
      });
    }
    mesh_.triangles = std::move(triangles);
    mesh_.triangle_patches = std::move(patches);
  }

  template <class Corners>
  [[nodiscard]] bool is_beyond(const Corners& corners) const {
    return std::ranges::any_of(corners, [&](std::uint32_t v) { return heights_[v] > 0; });
  }
  template <class Corners>
  [[nodiscard]] bool is_in_plane(const Corners& corners) const {
    return std::ranges::all_of(corners, [&](std::uint32_t v) { return heights_[v] == 0; });
  }
  /// Records a face, if it lies in the plane, of a removed cell.
  void note_face(const Cell<3>& face) {
    if (is_in_plane(face)) beyond_.try_emplace(sorted_corners(face), true);
  }
  void require_positive(const Cell<4>& tet) const {
    const auto& [a, b, c, d] = tet;
    const std::vector<Vec3>& p = mesh_.points;
    const bool is_as_given = std::ranges::all_of(tet, [&](std::uint32_t v) { return heights_[v] < 0; });
    if (!is_as_given && !(orient3d(p[a], p[b], p[c], p[d]) > 0))
      throw_bad_cut("the plane would leave a flat tetrahedron at " + coordinates_text(p[a]) +
                    "; move it a little");
  }
  template <class Cells, class Values>
  void keep_before(Cells& cells, Values& values) const {
    std::size_t kept = 0;
    for (std::size_t c = 0; c < cells.size(); ++c)
      if (!is_beyond(cells[c])) {
        cells[kept] = cells[c];
        values[kept++] = values[c];
      }
    cells.resize(kept);
    values.resize(kept);
  }

  struct NewFace {
    Cell<3> corners;
    Label label;
  };
  struct Piece {
    AreaSum sum;
    std::vector<std::size_t> faces;
  };

  void add_openings() {
    std::vector<NewFace> faces;
    for (std::size_t t = 0; t < mesh_.tetrahedra.size(); ++t)
      for (const LocalFace& local : kTetrahedronFaces) {
        const Cell<4>& tet = mesh_.tetrahedra[t];
        const Cell<3> face = {tet[local[0]], tet[local[1]], tet[local[2]]};
        if (is_in_plane(face) && beyond_.contains(sorted_corners(face)))
          faces.push_back({face, mesh_.tetrahedron_labels[t]});
      }
    made_.first_patch = static_cast<std::int32_t>(mesh_.info.patches.size());
    const std::map<std::pair<Label, std::uint64_t>, std::int32_t> there = openings_in_plane();
    for (const Piece& piece : pieces_of(faces)) {
      auto patch = static_cast<std::int32_t>(mesh_.info.patches.size());
      for (const std::size_t f : piece.faces)
        for_each_edge_of(faces[f].corners, [&](std::uint32_t a, std::uint32_t b) {
          if (const auto at = there.find({faces[f].label, edge_key(a, b)}); at != there.end())
            patch = at->second;
        });
      if (patch == static_cast<std::int32_t>(mesh_.info.patches.size()))
        mesh_.info.patches.push_back({"", PatchKind::kOpening, {faces[piece.faces[0]].label, kBackground}});
      for (const std::size_t f : piece.faces) {
        mesh_.triangles.push_back(faces[f].corners);
        mesh_.triangle_patches.push_back(patch);
      }
    }
  }
  /// By the edges of openings that are left in the plane: what the cut bares beside one belongs to it.
  [[nodiscard]] std::map<std::pair<Label, std::uint64_t>, std::int32_t> openings_in_plane() const {
    std::map<std::pair<Label, std::uint64_t>, std::int32_t> edges;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Patch& patch = mesh_.info.patches[static_cast<std::size_t>(mesh_.triangle_patches[t])];
      if (patch.kind != PatchKind::kOpening || !is_in_plane(mesh_.triangles[t])) continue;
      for_each_edge_of(mesh_.triangles[t], [&](std::uint32_t a, std::uint32_t b) {
        edges[{patch.labels[0], edge_key(a, b)}] = mesh_.triangle_patches[t];
      });
    }
    return edges;
  }
  /// Connected through edges, of one label, by falling area.
  [[nodiscard]] std::vector<Piece> pieces_of(const std::vector<NewFace>& faces) const {
    DisjointSets joined(faces.size());
    std::map<std::pair<Label, std::uint64_t>, std::size_t> first_at;
    for (std::size_t f = 0; f < faces.size(); ++f)
      for_each_edge_of(faces[f].corners, [&](std::uint32_t a, std::uint32_t b) {
        const auto [at, is_new] = first_at.try_emplace({faces[f].label, edge_key(a, b)}, f);
        if (!is_new) joined.merge(static_cast<std::uint32_t>(at->second), static_cast<std::uint32_t>(f));
      });
    std::map<std::uint32_t, Piece> by_root;
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const auto& [a, b, c] = faces[f].corners;
      Piece& piece = by_root[joined.find(static_cast<std::uint32_t>(f))];
      piece.sum.add(mesh_.points[a], mesh_.points[b], mesh_.points[c]);
      piece.faces.push_back(f);
    }
    std::vector<Piece> pieces;
    for (auto& [root, piece] : by_root) pieces.push_back(std::move(piece));
    sort_by_area(pieces, [](const Piece& piece) { return area_at_place(piece.sum); });
    return pieces;
  }

  void drop_unused_points() {
    const std::vector<std::uint8_t> in_use = points_in_use(mesh_.view());
    std::vector<std::uint32_t> number(mesh_.points.size());
    std::uint32_t next = 0;
    for (std::size_t v = 0; v < number.size(); ++v) {
      if (in_use[v] == 0) continue;
      mesh_.points[next] = mesh_.points[v];
      if (!mesh_.metric.empty()) mesh_.metric[next] = mesh_.metric[v];
      if (!mesh_.sizes_mm.empty()) mesh_.sizes_mm[next] = mesh_.sizes_mm[v];
      number[v] = next++;
    }
    mesh_.points.resize(next);
    if (!mesh_.metric.empty()) mesh_.metric.resize(next);
    if (!mesh_.sizes_mm.empty()) mesh_.sizes_mm.resize(next);
    const auto renumber = [&](auto& cells) {
      for (auto& cell : cells)
        for (std::uint32_t& v : cell) v = number[v];
    };
    renumber(mesh_.tetrahedra), renumber(mesh_.pyramids), renumber(mesh_.prisms), renumber(mesh_.hexahedra);
    renumber(mesh_.triangles), renumber(mesh_.quadrilaterals);
  }

  MixedMesh mesh_;
  Vec3 origin_, normal_;
  std::vector<double> heights_;
  std::map<FaceKey, bool> beyond_;  // Faces in the plane of cells that go.
  CellsCutOff made_;
};

}  // namespace

CellsCutOff cut_off_beyond(MixedMesh& mesh, const Vec3& point, const Vec3& normal) {
  Cutter cutter(mesh, point, normal);
  const CellsCutOff made = cutter.run();
  mesh = std::move(cutter).take();
  return made;
}

}  // namespace lumesh
