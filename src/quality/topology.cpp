#include <algorithm>

#include "cell_faces.hpp"
#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/label_shapes.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/parallel/sum.hpp"
#include "lumesh/quality/surface.hpp"

namespace lumesh::quality {

namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFFu;

/// Number of a side among those of all triangles.
std::uint32_t number_of(const TriangleSide& side) {
  return 3 * side.triangle + side.side;
}

/// In time that grows linearly, unlike sorted_sides(), and in its order.
parallel::KeyTable<TriangleSide> collect_sides(std::span<const Cell<3>> triangles, std::size_t vertex_count) {
  const auto visit = [&](std::size_t t, const auto& take) {
    for (std::uint32_t s = 0; s < 3; ++s) take(side_of(triangles[t], t, s));
  };
  return {triangles.size(), vertex_count, visit, [](const TriangleSide& side) { return side.low; }};
}

/// The analysis of one surface, step by step.
class SurfaceWalk {
 public:
  SurfaceWalk(std::span<const Vec3> points, std::span<const Cell<3>> triangles)
      : points_(points),
        triangles_(triangles),
        mates_(3 * triangles.size(), kNone),
        pieces_(triangles.size()) {}

  SurfaceTopology run() {
    result_.triangles = triangles_.size();
    match_edges();
    number_components();
    count_vertices();
    for (std::size_t c = 0; c < result_.components.size(); ++c) finish(c);
    std::ranges::stable_sort(result_.components,
                             [](const auto& a, const auto& b) { return a.area_mm2 > b.area_mm2; });
    return std::move(result_);
  }

 private:
  void match_edges() {
    const parallel::KeyTable<TriangleSide> sides = collect_sides(triangles_, points_.size());
    for_each_edge(sides.items(), [&](std::span<const TriangleSide> edge) {
      const auto runs_up = [&](std::size_t i) { return edge[i].runs_up(triangles_[edge[i].triangle]); };
      const std::uint32_t first = number_of(edge[0]);
      first_of_edge_.push_back(first);
      for (const TriangleSide& side : edge) pieces_.merge(edge[0].triangle, side.triangle);
      if (edge.size() == 1) {
        ++result_.open_edges;
        broken_edges_.push_back(first);
      } else if (edge.size() > 2 || runs_up(0) == runs_up(1)) {
        ++result_.non_manifold_edges;
        broken_edges_.push_back(first);
      } else {
        mates_[first] = number_of(edge[1]);
        mates_[number_of(edge[1])] = first;
      }
    });
  }

  void number_components() {
    component_.assign(triangles_.size(), 0);
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      const std::uint32_t root = pieces_.find(t);
      if (root == t) {
        component_[t] = static_cast<std::uint32_t>(result_.components.size());
        result_.components.emplace_back();
      }
      component_[t] = component_[root];  // Roots are the lowest of their set.
      add_triangle(result_.components[component_[t]], triangles_[t]);
    }
    whole_.assign(result_.components.size(), 1);
    for (const std::uint32_t edge : first_of_edge_) --result_.components[component_[edge / 3]].euler;
    for (const std::uint32_t edge : broken_edges_) whole_[component_[edge / 3]] = 0;
  }

  void add_triangle(SurfaceComponent& component, const Cell<3>& triangle) const {
    const Vec3 &a = points_[triangle[0]], &b = points_[triangle[1]], &c = points_[triangle[2]];
    ++component.triangles;
    ++component.euler;
    component.area_mm2 += triangle_area(a, b, c);
    const Vec3& origin = points_[triangles_[0][0]];
    component.enclosed_volume_mm3 += (a - origin).dot((b - origin).cross(c - origin)) / 6;
  }

  /// Counts each vertex once in every component that has it, and finds those with more than one ring.
  void count_vertices() {
    std::vector<std::uint64_t> corners(3 * triangles_.size());  // vertex << 32 | triangle * 3 + corner
    parallel::for_each_index(corners.size(), [&](std::size_t i) {
      corners[i] = std::uint64_t{triangles_[i / 3][i % 3]} << 32 | i;
    });
    parallel::sort(corners.begin(), corners.end());
    const auto same = [](std::uint64_t a, std::uint64_t b) { return a >> 32 == b >> 32; };
    parallel::for_each_run(corners, same, [&](std::span<const std::uint64_t> run) {
      ++result_.vertices;
      count_vertex(run);
    });
  }

  void count_vertex(std::span<const std::uint64_t> corners) {
    std::vector<std::uint32_t> seen;
    for (const std::uint64_t corner : corners)
      seen.push_back(component_[static_cast<std::uint32_t>(corner) / 3]);
    sort_unique(seen);
    for (const std::uint32_t component : seen) ++result_.components[component].euler;
    if (ring_length(static_cast<std::uint32_t>(corners[0])) == corners.size()) return;
    ++result_.non_manifold_vertices;
    if (seen.size() == 1) whole_[seen[0]] = 0;  // Pieces that only touch are each whole by themselves.
  }

  /// Triangles met when turning around a corner until it comes back; 0 if it meets a broken edge.
  [[nodiscard]] std::size_t ring_length(std::uint32_t corner) const {
    const std::uint32_t start = corner;
    for (std::size_t length = 1;; ++length) {
      const std::uint32_t mate = mates_[corner % 3 == 0 ? corner + 2 : corner - 1];
      if (mate == kNone) return 0;
      corner = mate;  // Mates run the other way: this side starts in the same vertex.
      if (corner == start) return length;
    }
  }

  void finish(std::size_t c) {
    SurfaceComponent& component = result_.components[c];
    component.genus = whole_[c] ? (2 - component.euler) / 2 : -1;
  }

  std::span<const Vec3> points_;
  std::span<const Cell<3>> triangles_;
  std::vector<std::uint32_t> mates_;  // The other half of each triangle side, or kNone.
  std::vector<std::uint32_t> first_of_edge_;
  std::vector<std::uint32_t> broken_edges_;
  DisjointSets pieces_;
  std::vector<std::uint32_t> component_;
  std::vector<char> whole_;
  SurfaceTopology result_;
};

/// A simplex with a label, for counting each once per label.
template <std::size_t N>
struct Labelled {
  Cell<N> vertices;
  Label label;
  auto operator<=>(const Labelled&) const = default;
};

using Counts = std::vector<std::int64_t>;  // Per label, and of the union at the end.

std::size_t index_of(const std::vector<SolidTopology>& labels, Label label) {
  return static_cast<std::size_t>(std::ranges::lower_bound(labels, label, {}, &SolidTopology::label) -
                                  labels.begin());
}

/// Number of different simplices per label and in the union.
template <std::size_t N>
Counts count_unique(const parallel::KeyTable<Labelled<N>>& items, const std::vector<SolidTopology>& labels) {
  const Counts zero(labels.size() + 1, 0);
  return parallel::reduce(
      items.key_count(), 16384, zero,
      [&](Counts& counts, std::size_t v) {
        const Labelled<N>* last = nullptr;
        for (const Labelled<N>& item : items.of(v)) {
          const bool new_simplex = !last || item.vertices != last->vertices;
          if (new_simplex) ++counts.back();
          if (new_simplex || item.label != last->label) ++counts[index_of(labels, item.label)];
          last = &item;
        }
      },
      parallel::AddEach());
}

template <std::size_t N, class Collect>
Counts count_simplices(const MeshView& mesh, const std::vector<SolidTopology>& labels,
                       const Collect& append) {
  const AllCells cells(mesh);
  const std::vector<Labelled<N>> items =
      parallel::collect<Labelled<N>>(cells.size(), [&](std::size_t cell, std::vector<Labelled<N>>& out) {
        const Label label = cells.label(cell);
        for (const Cell<3>& triangle : cells.triangles(cell)) append(triangle, label, out);
      });
  const parallel::KeyTable<Labelled<N>> sorted(items, mesh.points.size(),
                                               [](const Labelled<N>& item) { return item.vertices[0]; });
  return count_unique(sorted, labels);
}

Counts count_vertices(const MeshView& mesh, const std::vector<SolidTopology>& labels) {
  return count_simplices<1>(mesh, labels, [](const Cell<3>& t, Label label, std::vector<Labelled<1>>& out) {
    for (const std::uint32_t v : t) out.push_back({{v}, label});
  });
}

Counts count_edges(const MeshView& mesh, const std::vector<SolidTopology>& labels) {
  return count_simplices<2>(mesh, labels, [](const Cell<3>& t, Label label, std::vector<Labelled<2>>& out) {
    // Each edge of a cell has two triangles that run it both ways: take the ascending one.
    for (std::size_t s = 0; s < 3; ++s)
      if (t[s] < t[(s + 1) % 3]) out.push_back({{t[s], t[(s + 1) % 3]}, label});
  });
}

/// Merges cells across faces; counts faces and components per label and of the union.
void count_faces(const MeshView& mesh, std::vector<SolidTopology>& labels, SolidTopology& all) {
  const AllCells cells(mesh);
  const parallel::KeyTable<CellFace> faces = collect_faces(mesh);
  DisjointSets same_label(cells.size()), any_label(cells.size());
  faces.for_each_run(same_corners, [&](std::span<const CellFace> run) {
    ++all.euler;
    Label last = kOutside;
    for (const CellFace& face : run) {
      const Label label = cells.label(face.cell);
      if (label != last)
        ++labels[index_of(labels, label)].euler;
      else
        same_label.merge(run[0].cell, face.cell);
      last = label;
      any_label.merge(run[0].cell, face.cell);
    }
  });
  for (std::uint32_t cell = 0; cell < cells.size(); ++cell) {
    SolidTopology& label = labels[index_of(labels, cells.label(cell))];
    --label.euler;
    --all.euler;
    label.components += same_label.find(cell) == cell;
    all.components += any_label.find(cell) == cell;
  }
}

}  // namespace

std::int64_t SurfaceTopology::genus() const {
  std::int64_t sum = 0;
  for (const SurfaceComponent& component : components) {
    if (component.genus < 0) return -1;
    sum += component.genus;
  }
  return sum;
}

SurfaceTopology analyse_surface(std::span<const Vec3> points, std::span<const Cell<3>> triangles) {
  return SurfaceWalk(points, triangles).run();
}

std::vector<SolidTopology> analyse_solids(const MeshView& mesh) {
  const AllCells cells(mesh);
  std::vector<Label> found;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (found.empty() || found.back() != cells.label(i)) found.push_back(cells.label(i));
  sort_unique(found);
  std::vector<SolidTopology> labels;
  for (const Label label : found) labels.push_back({label, 0, 0});
  SolidTopology all{kOutside, 0, 0};
  count_faces(mesh, labels, all);
  const Counts vertices = count_vertices(mesh, labels);
  const Counts edges = count_edges(mesh, labels);
  for (std::size_t i = 0; i < labels.size(); ++i) labels[i].euler += vertices[i] - edges[i];
  all.euler += vertices.back() - edges.back();
  labels.push_back(all);
  return labels;
}

std::vector<SolidTopology> analyse_solids(const TetMesh& mesh, const SurfaceTopology& outer) {
  std::vector<SolidTopology> solids;
  for (const LabelShape& shape : label_shapes(mesh))
    solids.push_back({shape.label, shape.components, shape.euler});
  std::int64_t euler = 0;
  for (const SurfaceComponent& component : outer.components) euler += component.euler;
  // A solid has half the Euler number of its boundary.
  solids.push_back({kOutside, count_pieces(mesh), euler / 2});
  return solids;
}

}  // namespace lumesh::quality
