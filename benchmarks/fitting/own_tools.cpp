// What the fitting module keeps of its own against what modules share, on the lattice mesh of an image:
// memory, stars, the quality of a star, a sweep over the vertices, keys of cubes.
//
// Usage: lumesh_fitting_tools IMAGE [SPACING_MM]     one thread; the table stands in docs/design.md, section
// 9

#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <unordered_set>
#include <vector>

#include "../src/fitting/star_quality.hpp"
#include "../src/lattice/labelled_lattice.hpp"
#include "../src/operators/angle_star.hpp"
#include "../src/operators/neighbourhoods.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/geometry/cube_keys.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/operators/locks.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

using fitting::StarQuality;
using fitting::WorkMesh;

constexpr double kObtuseWeight = 0.7;

/// Seconds of the fastest of five runs.
template <class Body>
double seconds_of(const Body& body) {
  double best = 1e300;
  for (int run = 0; run < 5; ++run) {
    const auto begin = std::chrono::steady_clock::now();
    body();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return best;
}

/// Resident memory in bytes.
double resident() {
  malloc_trim(0);
  std::ifstream file("/proc/self/statm");
  double all = 0, held = 0;
  file >> all >> held;
  return 4096 * held;
}

WorkMesh lattice_mesh(const LabelImage& image, const ImageDomain& domain, double spacing_mm) {
  LatticeOptions options;
  options.spacing_mm = spacing_mm;
  const double coarsest_mm =
      SizeGrid::boundary_spacing_mm(image, domain, options) * std::exp2(options.coarsening);
  const LatticeFrame frame =
      make_lattice_frame(domain, coarsest_mm, options.coarsening + options.max_refinement);
  const SizeGrid sizes(image, domain, options, coarsest_mm, image.voxels().size(), OpeningSizes(domain));
  return make_work_mesh(refined_lattice(frame, domain, sizes), frame, domain);
}

TetMesh tet_mesh_of(const WorkMesh& mesh) {
  std::vector<Label> labels(mesh.tets.size());
  for (std::size_t t = 0; t < labels.size(); ++t) labels[t] = mesh.materials[t] + 1;
  return TetMesh::build(mesh.positions, mesh.tets, labels);
}

double sum = 0;  // Keeps what is measured from being optimised away.

void print(const char* what, double own, double shared, const char* unit) {
  std::printf("%-44s %9.2f %9.2f  %-16s %5.2f times\n", what, own, shared, unit, shared / own);
}

void measure_gathering(const WorkMesh& work, const TetMesh& mesh) {
  const double own = seconds_of([&] {
    for (std::uint32_t v = 0; v < work.positions.size(); ++v)
      for (const std::uint32_t t : work.star(v)) sum += work.positions[work.tets[t][0]].x();
  });
  operators::VertexBall ball;
  operators::NoLock lock;
  const double shared = seconds_of([&] {
    for (std::uint32_t v = 0; v < mesh.vertex_slots(); ++v) {
      if (!operators::gather_ball(mesh, VertexId(v), lock, ball)) continue;
      for (const TetId t : ball.tets) sum += mesh.corner(t, 0).x();
    }
  });
  const double scale = 1e9 / static_cast<double>(work.positions.size());
  print("star of a vertex, gathered and read", scale * own, scale * shared, "ns");
}

/// The faces opposite to a vertex, anticlockwise seen from it.
void faces_of_star(const WorkMesh& work, std::uint32_t v, std::vector<fitting::TriangleCorners>& faces) {
  faces.clear();
  for (const std::uint32_t t : work.star(v)) {
    std::size_t at = 0;
    while (work.tets[t][at] != v) ++at;
    const auto [a, b, c] = fitting::corners_of(work, fitting::face_of(work.tets[t], at));
    faces.push_back({a, c, b});
  }
}

/// Largest cosine of the dihedral angles between faces and a place; 2 if a tetrahedron is inverted there.
double largest_cosine(const std::vector<fitting::TriangleCorners>& faces, const Vec3& x) {
  double largest = -1;
  for (const auto& [a, b, c] : faces) {
    if (!(tetrahedron_volume(a, b, c, x) > 0)) return 2;
    const DihedralCosines cosines = min_max_dihedral(a, b, c, x);
    largest = std::max({largest, cosines.largest_cosine, -cosines.smallest_cosine});
  }
  return largest;
}

void measure_quality(const WorkMesh& work) {
  constexpr int kPlaces = 8;
  const auto place = [&](std::uint32_t v, int n) {
    return Vec3(work.positions[v] + 0.01 * n * Vec3(1, -1, 1));
  };
  double places = 0;
  const double own = seconds_of([&] {
    places = 0;
    for (std::uint32_t v = 0; v < work.positions.size(); v += 4) {
      StarQuality star(work, v);
      for (int n = 0; n < kPlaces; ++n) sum += star.worst(place(v, n), -2);
      places += kPlaces;
    }
  });
  operators::AngleStar star;
  std::vector<fitting::TriangleCorners> faces;
  const double shared = seconds_of([&] {
    for (std::uint32_t v = 0; v < work.positions.size(); v += 4) {
      star.begin(kObtuseWeight);
      faces_of_star(work, v, faces);
      for (const auto& [a, b, c] : faces) star.add(a, b, c);
      for (int n = 0; n < kPlaces; ++n) sum += star.worst_at(place(v, n));
    }
  });
  print("quality of a star at one place", 1e9 * own / places, 1e9 * shared / places, "ns");
  const double one_by_one = seconds_of([&] {
    for (std::uint32_t v = 0; v < work.positions.size(); v += 4) {
      faces_of_star(work, v, faces);
      for (int n = 0; n < kPlaces; ++n) sum += largest_cosine(faces, place(v, n));
    }
  });
  print("the same by min_max_dihedral()", 1e9 * own / places, 1e9 * one_by_one / places, "ns");
}

/// One sweep: every vertex goes to the middle of those around it, or halfway, if that is better.
/// @param star_of  star_of(v) is a function of a place: its quality.
template <class StarOf, class MeanOf, class Positions>
void sweep(std::size_t vertices, const StarOf& star_of, const MeanOf& mean_of, const Positions& position) {
  for (std::uint32_t v = 0; v < vertices; ++v) {
    auto quality = star_of(v);
    const Vec3 x = position(v), mean = mean_of(v);
    const double now = quality(x);
    for (const double part : {1.0, 0.5})
      if (quality(x + part * (mean - x)) > now) {
        sum += 1;
        break;
      }
  }
}

void measure_sweep(const WorkMesh& work, const TetMesh& mesh) {
  const double own = seconds_of([&] {
    sweep(
        work.positions.size(),
        [&](std::uint32_t v) {
          return [star = StarQuality(work, v)](const Vec3& x) mutable { return star.worst(x, -2); };
        },
        [&](std::uint32_t v) {
          Vec3 mean = Vec3::Zero();
          for (const std::uint32_t t : work.star(v))
            for (const std::uint32_t w : work.tets[t])
              if (w != v) mean += work.positions[w];
          return Vec3(mean / (3 * static_cast<double>(work.star(v).size())));
        },
        [&](std::uint32_t v) { return work.positions[v]; });
  });
  operators::VertexBall ball;
  operators::NoLock lock;
  operators::AngleStar star;
  const double shared = seconds_of([&] {
    sweep(
        mesh.vertex_slots(),
        [&](std::uint32_t v) {
          star.begin(kObtuseWeight);
          if (operators::gather_ball(mesh, VertexId(v), lock, ball))
            for (const TetId t : ball.tets) {
              const auto [a, b, c] = mesh.face_corners(t, mesh.index_of(t, VertexId(v)));
              star.add(mesh.point(VertexId(a)), mesh.point(VertexId(c)), mesh.point(VertexId(b)));
            }
          return [&](const Vec3& x) { return star.worst_at(x); };
        },
        [&](std::uint32_t) {
          Vec3 mean = Vec3::Zero();
          for (const std::uint32_t w : ball.neighbours) mean += mesh.point(VertexId(w));
          return Vec3(mean / static_cast<double>(ball.neighbours.size()));
        },
        [&](std::uint32_t v) { return mesh.point(VertexId(v)); });
  });
  const double scale = 1e9 / static_cast<double>(work.positions.size());
  print("sweep: a vertex, three places tried", scale * own, scale * shared, "ns");
}

/// Cubes of 1.5 voxels that hold a vertex of the mesh, against all of the box around it.
void measure_cubes(const WorkMesh& work, double voxel_mm) {
  std::unordered_set<std::uint64_t> used;
  Box3 box;
  for (const Vec3& p : work.positions) {
    used.insert(cube_key(cube_of(p, 1.5 * voxel_mm)));
    box.extend(p);
  }
  const Index3 size =
      cube_of(box.max(), 1.5 * voxel_mm) - cube_of(box.min(), 1.5 * voxel_mm) + Index3::Ones();
  print("cubes of 1.5 voxels that hold a vertex, all", 1e-3 * static_cast<double>(used.size()),
        1e-3 * static_cast<double>(grid_count(size)), "thousand");
}

void measure(const LabelImage& image, double spacing_mm) {
  const ImageDomain domain(image, {});
  const double before = resident();
  WorkMesh work = lattice_mesh(image, domain, spacing_mm);
  const auto tets = static_cast<double>(work.tets.size());
  const double own_bytes = resident() - before;
  const double build_own = seconds_of([&] {
    fitting::build_stars(work);
    fitting::build_neighbours(work);
  });
  const double middle = resident();
  const TetMesh mesh = tet_mesh_of(work);
  const double shared_bytes = resident() - middle;
  const double build_shared = seconds_of([&] { sum += tet_mesh_of(work).tet_count(); });
  std::printf("%zu tetrahedra, %zu vertices\n%-44s %9s %9s\n", work.tets.size(), work.positions.size(), "",
              "own", "shared");
  print("memory of a tetrahedron", own_bytes / tets, shared_bytes / tets, "bytes");
  print("links and stars of a tetrahedron, made", 1e9 * build_own / tets, 1e9 * build_shared / tets, "ns");
  measure_gathering(work, mesh);
  measure_quality(work);
  measure_sweep(work, mesh);
  measure_cubes(work, domain.voxel_size_mm());
  std::printf("(%g)\n", sum);
}

}  // namespace
}  // namespace lumesh

int main(int argc, char** argv) {
  if (argc < 2) return std::puts("usage: lumesh_fitting_tools IMAGE [SPACING_MM]"), 1;
  lumesh::Context context;
  const lumesh::LabelImage image = lumesh::read_image(argv[1], {}, context);
  lumesh::measure(image, argc > 2 ? std::atof(argv[2]) : 0);
}
