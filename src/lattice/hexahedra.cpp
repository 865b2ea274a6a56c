#include "hexahedra.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <optional>

#include "lumesh/core/assert.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};
constexpr std::size_t kStarSize = 24;
constexpr double kTolerance = 1e-6;  // of the spacing; the fit moves vertices by far more

/// A vertex that may become a cube, and its neighbours by direction.
struct Cube {
  std::uint32_t centre = kNone;
  std::array<std::uint32_t, 6> across;   // along the axes: -x, +x, -y, +y, -z, +z
  std::array<std::uint32_t, 8> corners;  // bit a set: on the positive side of axis a
};

/// Finds and chooses the cubes; the mesh is not changed.
class CubeChooser {
 public:
  CubeChooser(const MixedMesh& mesh, const Mat3& axes)
      : mesh_(mesh),
        to_axes_(axes.transpose()),
        stars_(parallel::cells_around(mesh.tetrahedra, mesh.points.size())),
        on_boundary_(mesh.points.size(), 0) {
    for (const Cell<3>& t : mesh.triangles) {
      for (const std::uint32_t v : t) on_boundary_[v] = 1;
    }
  }

  [[nodiscard]] std::vector<Cube> run() {
    const std::vector<Cube> all = parallel::collect<Cube>(mesh_.points.size(), [&](std::size_t v, auto& out) {
      if (const auto cube = cube_at(static_cast<std::uint32_t>(v))) out.push_back(*cube);
    });
    number_.assign(mesh_.points.size(), kNone);
    for (std::size_t i = 0; i < all.size(); ++i) number_[all[i].centre] = static_cast<std::uint32_t>(i);
    return larger_grids(all);
  }

  [[nodiscard]] std::vector<Label> labels_of(const std::vector<Cube>& cubes) const {
    std::vector<Label> labels;
    labels.reserve(cubes.size());
    for (const Cube& cube : cubes) labels.push_back(mesh_.tetrahedron_labels[stars_.of(cube.centre)[0]]);
    return labels;
  }

 private:
  [[nodiscard]] Vec3 offset(std::uint32_t from, std::uint32_t to) const {
    return to_axes_ * (mesh_.points[to] - mesh_.points[from]);
  }

  /// The cube around a vertex with a regular star of one label.
  [[nodiscard]] std::optional<Cube> cube_at(std::uint32_t centre) const {
    const auto star = stars_.of(centre);
    if (star.size() != kStarSize || on_boundary_[centre] != 0) return std::nullopt;
    double spacing = 0;
    for (const std::uint32_t t : star) {
      if (mesh_.tetrahedron_labels[t] != mesh_.tetrahedron_labels[star[0]]) return std::nullopt;
      for (const std::uint32_t v : mesh_.tetrahedra[t])
        spacing = std::max(spacing, offset(centre, v).lpNorm<Eigen::Infinity>());
    }
    Cube cube;
    cube.centre = centre;
    cube.across.fill(kNone);
    cube.corners.fill(kNone);
    for (const std::uint32_t t : star) {
      if (!enter(mesh_.tetrahedra[t], spacing, cube)) return std::nullopt;
    }
    const auto found = [](std::uint32_t v) { return v != kNone; };
    if (!std::ranges::all_of(cube.across, found)) return std::nullopt;
    if (!std::ranges::all_of(cube.corners, found)) return std::nullopt;
    return cube;
  }

  /// Enters a tetrahedron's vertices into the cube; false unless it is (centre, across, two neighbouring
  /// corners of the square between).
  bool enter(const Cell<4>& tet, double spacing, Cube& cube) const {
    std::size_t face = 6;
    std::array<std::size_t, 2> corner = {};
    std::size_t corners = 0;
    for (const std::uint32_t v : tet) {
      if (v == cube.centre) continue;
      const Vec3 steps = offset(cube.centre, v) * (2 / spacing);
      const Vec3 whole = steps.array().round().matrix();
      if ((steps - whole).lpNorm<Eigen::Infinity>() > 2 * kTolerance) return false;
      if ((whole.cwiseAbs().array() == 1).all()) {
        if (corners == 2) return false;
        corner[corners] =
            static_cast<std::size_t>((whole.x() > 0) | (whole.y() > 0) << 1 | (whole.z() > 0) << 2);
        if (!put(cube.corners[corner[corners++]], v)) return false;
      } else {
        Eigen::Index axis = 0;
        whole.cwiseAbs().maxCoeff(&axis);
        if (face != 6 || whole.cwiseAbs().sum() != 2) return false;
        face = static_cast<std::size_t>(2 * axis + (whole[axis] > 0 ? 1 : 0));
        if (!put(cube.across[face], v)) return false;
      }
    }
    if (corners != 2 || face == 6) return false;
    const std::size_t differing = corner[0] ^ corner[1];
    const bool on_face =
        (corner[0] >> (face / 2) & 1) == face % 2 && (corner[1] >> (face / 2) & 1) == face % 2;
    return on_face && (differing == 1 || differing == 2 || differing == 4);
  }

  static bool put(std::uint32_t& slot, std::uint32_t v) {
    if (slot != kNone && slot != v) return false;
    slot = v;
    return true;
  }

  /// Two cubes whose centres are joined by a short edge overlap. Regions connected by such edges fall into
  /// two grids without overlap; the larger one is kept, of equal ones the one that holds the first vertex.
  [[nodiscard]] std::vector<Cube> larger_grids(const std::vector<Cube>& all) const {
    std::vector<std::uint32_t> region(all.size(), kNone);
    std::vector<std::uint8_t> grid(all.size(), 0);
    std::vector<std::array<std::uint32_t, 2>> count;
    std::vector<std::uint32_t> front;
    for (std::uint32_t first = 0; first < all.size(); ++first) {
      if (region[first] != kNone) continue;
      const auto own = static_cast<std::uint32_t>(count.size());
      count.push_back({0, 0});
      region[first] = own;
      front.assign(1, first);
      while (!front.empty()) {
        const std::uint32_t i = front.back();
        front.pop_back();
        ++count[own][grid[i]];
        for (const std::uint32_t v : all[i].corners) {
          const std::uint32_t next = number_[v];
          if (next == kNone || region[next] != kNone) continue;
          region[next] = own;
          grid[next] = grid[i] ^ 1;
          front.push_back(next);
        }
      }
    }
    return parallel::collect<Cube>(all.size(), [&](std::size_t i, auto& out) {
      const std::uint8_t larger = count[region[i]][1] > count[region[i]][0] ? 1 : 0;
      if (grid[i] == larger) out.push_back(all[i]);
    });
  }

  const MixedMesh& mesh_;
  Mat3 to_axes_;
  parallel::Adjacency stars_;  // Tetrahedra around each vertex.
  std::vector<std::uint8_t> on_boundary_;
  std::vector<std::uint32_t> number_;  // of the cube around a vertex
};

Cell<8> hexahedron_of(const Cube& cube) {
  const auto& c = cube.corners;
  return {c[0], c[1], c[3], c[2], c[4], c[5], c[7], c[6]};
}

/// The pyramid on a face of the cube whose apex is the vertex across.
Cell<5> pyramid_on(const Cube& cube, std::size_t face) {
  const std::size_t side = (face % 2) << (face / 2);
  const std::size_t u = std::size_t{1} << ((face / 2 + 1) % 3);
  const std::size_t v = std::size_t{1} << ((face / 2 + 2) % 3);
  const auto& c = cube.corners;
  if (face % 2 == 1) return {c[side], c[side | u], c[side | u | v], c[side | v], cube.across[face]};
  return {c[side], c[side | v], c[side | u | v], c[side | u], cube.across[face]};
}

/// Removes the tetrahedra that touch a removed vertex and puts the cubes in their place; vertex numbers stay.
void replace_cells(MixedMesh& mesh, const std::vector<Cube>& cubes, const std::vector<Label>& labels,
                   const std::vector<std::uint8_t>& removed) {
  struct Labelled {
    Cell<5> cell;
    Label label;
  };
  const auto pyramids = parallel::collect<Labelled>(cubes.size(), [&](std::size_t i, auto& out) {
    for (std::size_t face = 0; face < 6; ++face) {
      if (removed[cubes[i].across[face]] == 0) out.push_back({pyramid_on(cubes[i], face), labels[i]});
    }
  });
  for (const Labelled& p : pyramids) {
    mesh.pyramids.push_back(p.cell);
    mesh.pyramid_labels.push_back(p.label);
  }
  for (const Cube& cube : cubes) mesh.hexahedra.push_back(hexahedron_of(cube));
  mesh.hexahedron_labels.insert(mesh.hexahedron_labels.end(), labels.begin(), labels.end());
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    const Cell<4>& tet = mesh.tetrahedra[t];
    if (std::ranges::any_of(tet, [&](std::uint32_t v) { return removed[v] != 0; })) continue;
    mesh.tetrahedra[kept] = tet;
    mesh.tetrahedron_labels[kept++] = mesh.tetrahedron_labels[t];
  }
  mesh.tetrahedra.resize(kept);
  mesh.tetrahedron_labels.resize(kept);
}

/// Closes the gaps in the numbering.
void drop_vertices(MixedMesh& mesh, const std::vector<std::uint8_t>& removed) {
  std::vector<std::uint32_t> number(mesh.points.size(), kNone);
  std::uint32_t kept = 0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (removed[v] != 0) continue;
    mesh.points[kept] = mesh.points[v];
    number[v] = kept++;
  }
  mesh.points.resize(kept);
  const auto renumber = [&](auto& cells) {
    parallel::for_each_index(cells.size(), [&](std::size_t c) {
      for (std::uint32_t& v : cells[c]) v = number[v];
    });
  };
  renumber(mesh.tetrahedra);
  renumber(mesh.pyramids);
  renumber(mesh.hexahedra);
  renumber(mesh.triangles);
}

}  // namespace

void merge_hexahedra(MixedMesh& mesh, const Mat3& axes) {
  LUMESH_ASSERT(mesh.pyramids.empty() && mesh.prisms.empty() && mesh.hexahedra.empty() &&
                mesh.quadrilaterals.empty());
  Mat3 proper = axes;
  if (proper.determinant() < 0) proper.col(2) = -proper.col(2);  // the lattice is symmetric
  std::vector<Cube> cubes;
  std::vector<Label> labels;
  {
    CubeChooser chooser(mesh, proper);
    cubes = chooser.run();
    labels = chooser.labels_of(cubes);
  }
  if (cubes.empty()) return;
  std::vector<std::uint8_t> removed(mesh.points.size(), 0);
  for (const Cube& cube : cubes) removed[cube.centre] = 1;
  replace_cells(mesh, cubes, labels, removed);
  drop_vertices(mesh, removed);
}

}  // namespace lumesh
