#include "lumesh/quality/layered.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "lumesh/core/angles.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/all_cells.hpp"
#include "lumesh/mesh/cell_corners.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh::quality {
namespace {

/// Sums and extremes of a run of flat cells; the mean is still a sum.
struct FlatTally {
  FlatCellShapes shapes = {.smallest_dihedral_deg = std::numeric_limits<double>::infinity()};
  std::uint64_t with_aspect = 0;

  void add_angle(double degrees) {
    shapes.smallest_dihedral_deg = std::min(shapes.smallest_dihedral_deg, degrees);
    shapes.largest_dihedral_deg = std::max(shapes.largest_dihedral_deg, degrees);
  }
  void add_aspect(double longest_edge, double min_height) {
    if (!(min_height > 0)) return;
    const double aspect = longest_edge / min_height;
    shapes.mean_aspect += aspect;
    shapes.largest_aspect = std::max(shapes.largest_aspect, aspect);
    ++with_aspect;
  }
};

FlatTally together(FlatTally a, const FlatTally& b) {
  a.shapes.cells += b.shapes.cells;
  a.shapes.smallest_dihedral_deg = std::min(a.shapes.smallest_dihedral_deg, b.shapes.smallest_dihedral_deg);
  a.shapes.largest_dihedral_deg = std::max(a.shapes.largest_dihedral_deg, b.shapes.largest_dihedral_deg);
  a.shapes.mean_aspect += b.shapes.mean_aspect;
  a.shapes.largest_aspect = std::max(a.shapes.largest_aspect, b.shapes.largest_aspect);
  a.with_aspect += b.with_aspect;
  return a;
}

/// Angles between the three planes that three edges of a corner span by twos: along each edge one.
void add_corner(const Vec3& at, const std::array<Vec3, 3>& ends, FlatTally& tally) {
  const std::array<Vec3, 3> e = {ends[0] - at, ends[1] - at, ends[2] - at};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 along = e[i].stableNormalized();
    const Vec3 a = e[(i + 1) % 3] - along.dot(e[(i + 1) % 3]) * along,
               b = e[(i + 2) % 3] - along.dot(e[(i + 2) % 3]) * along;
    tally.add_angle(degrees(angle_between(a, b)));
  }
}

template <std::size_t N>
double longest_of(std::span<const std::array<int, 2>> edges, std::span<const Vec3> points,
                  const Cell<N>& cell) {
  double longest = 0;
  for (const auto& [a, b] : edges)
    longest = std::max(
        longest,
        (points[cell[static_cast<std::size_t>(a)]] - points[cell[static_cast<std::size_t>(b)]]).norm());
  return longest;
}

void add_flat(std::span<const Vec3> points, const Cell<4>& c, double volume, FlatTally& tally) {
  for (const double angle : dihedral_angles_deg(points[c[0]], points[c[1]], points[c[2]], points[c[3]]))
    tally.add_angle(angle);
  double largest_face = 0;
  for (const Cell<3>& triangle : triangles_of(c))
    largest_face = std::max(largest_face, triangle_area(points, triangle));
  tally.add_aspect(longest_of(kTetEdges, points, c), 3 * volume / largest_face);
}

void add_flat(std::span<const Vec3> points, const Cell<5>& c, double volume, FlatTally& tally) {
  for (std::size_t i = 0; i < 4; ++i)
    add_corner(points[c[i]], {points[c[(i + 1) % 4]], points[c[(i + 3) % 4]], points[c[4]]}, tally);
  double base = 0, largest_face = 0;
  for (const auto& [p, q, r] : triangles_of(c)) {
    const double area = triangle_area(points[p], points[q], points[r]);
    const bool is_of_base = p != c[4] && q != c[4] && r != c[4];
    if (is_of_base) base += area;
    if (!is_of_base) largest_face = std::max(largest_face, area);
  }
  tally.add_aspect(longest_of(kPyramidEdges, points, c), 3 * volume / std::max(base, largest_face));
}

void add_flat(std::span<const Vec3> points, const Cell<6>& c, double volume, FlatTally& tally) {
  for (std::size_t i = 0; i < 3; ++i)
    for (const std::size_t end : {std::size_t{0}, std::size_t{3}})
      add_corner(points[c[end + i]],
                 {points[c[end + (i + 1) % 3]], points[c[end + (i + 2) % 3]], points[c[3 - end + i]]}, tally);
  const double area = 0.5 * (triangle_area(points[c[0]], points[c[1]], points[c[2]]) +
                             triangle_area(points[c[3]], points[c[4]], points[c[5]]));
  tally.add_aspect(longest_of(kPrismEdges, points, c), volume / area);
}

void add_cell(const MeshView& mesh, const AllCells& cells, std::size_t cell, FlatTally& tally) {
  const double volume = cells.volume(cell);
  ++tally.shapes.cells;
  if (cell < mesh.tetrahedra.size()) return add_flat(mesh.points, mesh.tetrahedra[cell], volume, tally);
  cell -= mesh.tetrahedra.size();
  if (cell < mesh.pyramids.size()) return add_flat(mesh.points, mesh.pyramids[cell], volume, tally);
  add_flat(mesh.points, mesh.prisms[cell - mesh.pyramids.size()], volume, tally);
}

}  // namespace

LayeredParts parts_of(const MeshView& mesh, const LayeredCells& cells) {
  const std::uint64_t others = mesh.hexahedra.size() + cells.core_pyramids + cells.core_prisms;
  LUMESH_ASSERT(cells.layers + others <= mesh.cell_count() && cells.core_pyramids <= mesh.pyramids.size() &&
                cells.core_prisms <= mesh.prisms.size());
  const std::uint64_t tetrahedra = mesh.cell_count() - cells.layers - others;
  LayeredParts parts;
  parts.core.points = parts.layers.points = mesh.points;
  parts.core.info = parts.layers.info = mesh.info;
  const auto divide = [](const auto& all, std::uint64_t of_core, auto& core, auto& layers) {
    core = all.first(of_core);
    layers = all.subspan(of_core);
  };
  divide(mesh.tetrahedra, tetrahedra, parts.core.tetrahedra, parts.layers.tetrahedra);
  divide(mesh.tetrahedron_labels, tetrahedra, parts.core.tetrahedron_labels, parts.layers.tetrahedron_labels);
  divide(mesh.pyramids, cells.core_pyramids, parts.core.pyramids, parts.layers.pyramids);
  divide(mesh.pyramid_labels, cells.core_pyramids, parts.core.pyramid_labels, parts.layers.pyramid_labels);
  divide(mesh.prisms, cells.core_prisms, parts.core.prisms, parts.layers.prisms);
  divide(mesh.prism_labels, cells.core_prisms, parts.core.prism_labels, parts.layers.prism_labels);
  parts.core.hexahedra = mesh.hexahedra;
  parts.core.hexahedron_labels = mesh.hexahedron_labels;
  return parts;
}

FlatCellShapes measure_flat_cells(const MeshView& mesh) {
  constexpr std::size_t kBlockOfCells = 8192;
  const std::size_t count = mesh.tetrahedra.size() + mesh.pyramids.size() + mesh.prisms.size();
  if (count == 0) return {};
  const AllCells cells(mesh);
  FlatTally tally = parallel::reduce(
      count, kBlockOfCells, FlatTally(),
      [&](FlatTally& part, std::size_t i) { add_cell(mesh, cells, i, part); }, together);
  tally.shapes.mean_aspect /= static_cast<double>(std::max<std::uint64_t>(1, tally.with_aspect));
  return tally.shapes;
}

}  // namespace lumesh::quality
