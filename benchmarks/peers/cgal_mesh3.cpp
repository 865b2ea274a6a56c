// SPDX-License-Identifier: GPL-3.0-or-later
//
// Meshes a label image with CGAL's Mesh_3, to compare lumesh with. Mesh_3 is under the GPL, and so is this
// file and what is compiled from it; nothing of it enters lumesh. See README.md beside it for how to build
// and run it.
// clang-format off
#include <CGAL/make_mesh_3.h>  // First: the parallel exude_mesh_3.h lacks what it includes.
// clang-format on
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Image_3.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/exude_mesh_3.h>
#include <CGAL/perturb_mesh_3.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <map>
#include <unordered_map>

#include "nrrd.hpp"
#ifdef PAR
#include <tbb/global_control.h>
using Tag = CGAL::Parallel_tag;
constexpr const char* kTag = "parallel";
#else
using Tag = CGAL::Sequential_tag;
constexpr const char* kTag = "sequential";
#endif

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Domain = CGAL::Labeled_mesh_domain_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain, CGAL::Default, Tag>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;
namespace params = CGAL::parameters;

constexpr const char* kUsage = R"(Meshes a label image with CGAL Mesh_3 and prints one line of JSON.

Usage: cgal_mesh3_seq|cgal_mesh3_par --image FILE.nrrd [OPTION VALUE]...

  --image FILE            label image, .nrrd with its voxels inside, raw or gzip; 0 is outside
  --output FILE           Medit file (.mesh) to write; none: nothing is written
  --facet-angle DEGREES   smallest angle of boundary triangles, default 30
  --facet-size MM         largest radius of their surface balls; default 0: no bound
  --facet-distance MM     largest distance from the middle of a triangle to the surface; default 0: no bound
  --radius-edge RATIO     largest circumradius over shortest edge of tetrahedra, default 3
  --cell-size MM          largest circumradius of tetrahedra; default 0: no bound
  --error-bound RATIO     of intersections with the surface, in units of the image's diagonal; default 0.001
  --manifold 0|1          ask for a boundary that is a manifold, default 0
  --perturb 0|1           move vertices of slivers afterwards, without time limit, default 0
  --exude 0|1             weigh vertices of slivers afterwards, without time limit, default 0
  --threads N             of the parallel program, default 1

"seconds" is the time of make_mesh_3 alone: no reading, no perturbation, no exudation, no writing. The parallel program
is not the same from run to run.
)";

struct Options {
  std::string image, output;
  double facet_angle = 30, facet_size = 0, facet_distance = 0, radius_edge = 3, cell_size = 0,
         error_bound = 1e-3;
  double manifold = 0, perturb = 0, exude = 0, threads = 1;
};

Options parse(int argc, char** argv) {
  Options options;
  const std::map<std::string, double*> numbers = {{"--facet-angle", &options.facet_angle},
                                                  {"--facet-size", &options.facet_size},
                                                  {"--facet-distance", &options.facet_distance},
                                                  {"--radius-edge", &options.radius_edge},
                                                  {"--cell-size", &options.cell_size},
                                                  {"--error-bound", &options.error_bound},
                                                  {"--manifold", &options.manifold},
                                                  {"--perturb", &options.perturb},
                                                  {"--exude", &options.exude},
                                                  {"--threads", &options.threads}};
  const std::map<std::string, std::string*> names = {{"--image", &options.image},
                                                     {"--output", &options.output}};
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i];
    if (name == "--help" || name == "-h") {
      std::cout << kUsage;
      std::exit(0);
    }
    if (i + 1 == argc) throw std::invalid_argument(name + " needs a value");
    if (const auto text = names.find(name); text != names.end()) {
      *text->second = argv[i + 1];
    } else if (const auto number = numbers.find(name); number != numbers.end()) {
      char* end = nullptr;
      *number->second = std::strtod(argv[i + 1], &end);
      if (*end != 0 || end == argv[i + 1] || *number->second < 0)
        throw std::invalid_argument(name + " takes a number from 0 on, not '" + argv[i + 1] + "'");
    } else {
      throw std::invalid_argument("unknown option " + name);
    }
  }
  if (options.image.empty()) throw std::invalid_argument("--image is missing");
  return options;
}

double length_of(const std::array<double, 3>& v) {
  return std::hypot(v[0], v[1], v[2]);
}

/// In a frame along its axes with voxel (0, 0, 0) at (1, 1, 1) spacings: a layer of background is put around
/// the image, so that what touches its border is closed there as lumesh closes it.
CGAL::Image_3 cgal_image(const peers::LabelImage& image) {
  const auto [nx, ny, nz] = image.size;
  const bool narrow = *std::max_element(image.labels.begin(), image.labels.end()) < 256;
  _image* padded = _createImage(nx + 2, ny + 2, nz + 2, 1, length_of(image.step[0]), length_of(image.step[1]),
                                length_of(image.step[2]), narrow ? 1 : 2, WK_FIXED, SGN_UNSIGNED);
  std::memset(padded->data, 0, (nx + 2) * (ny + 2) * (nz + 2) * (narrow ? 1 : 2));
  for (std::size_t z = 0; z < nz; ++z)
    for (std::size_t y = 0; y < ny; ++y)
      for (std::size_t x = 0; x < nx; ++x) {
        const std::uint16_t label = image.labels[(z * ny + y) * nx + x];
        const std::size_t at = ((z + 1) * (ny + 2) + y + 1) * (nx + 2) + x + 1;
        if (narrow)
          static_cast<std::uint8_t*>(padded->data)[at] = static_cast<std::uint8_t>(label);
        else
          static_cast<std::uint16_t*>(padded->data)[at] = label;
      }
  return CGAL::Image_3(padded);
}

/// From the frame of cgal_image() to that of the file.
std::array<double, 3> place_of(const Triangulation::Point& p, const peers::LabelImage& image) {
  std::array<double, 3> place = image.origin;
  const std::array<double, 3> local = {CGAL::to_double(p.x()), CGAL::to_double(p.y()),
                                       CGAL::to_double(p.z())};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double voxels = local[axis] / length_of(image.step[axis]) - 1;
    for (std::size_t i = 0; i < 3; ++i) place[i] += voxels * image.step[axis][i];
  }
  return place;
}

/// True if the frame of the file is left-handed, which turns tetrahedra inside out.
bool is_mirrored(const peers::LabelImage& image) {
  const auto& [a, b, c] = image.step;
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
             a[2] * (b[0] * c[1] - b[1] * c[0]) <
         0;
}

/// The vertices of the tetrahedra, numbered from 1.
std::unordered_map<Complex::Vertex_handle, std::size_t> numbers_of(const Complex& mesh) {
  std::unordered_map<Complex::Vertex_handle, std::size_t> numbers;
  for (auto cell = mesh.cells_in_complex_begin(); cell != mesh.cells_in_complex_end(); ++cell)
    for (int i = 0; i < 4; ++i) numbers.try_emplace(cell->vertex(i), numbers.size() + 1);
  return numbers;
}

/// Tetrahedra only: the list of boundary triangles of Mesh_3 may have holes where the tetrahedra have none.
void write_medit(const std::string& path, const Complex& mesh, const peers::LabelImage& image,
                 const std::unordered_map<Complex::Vertex_handle, std::size_t>& numbers) {
  std::vector<Complex::Vertex_handle> vertices(numbers.size());
  for (const auto& [vertex, number] : numbers) vertices[number - 1] = vertex;
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) throw std::runtime_error(path + ": cannot be written");
  std::fprintf(file, "MeshVersionFormatted 2\nDimension 3\nVertices\n%zu\n", vertices.size());
  for (const Complex::Vertex_handle vertex : vertices) {
    const auto [x, y, z] = place_of(vertex->point(), image);
    std::fprintf(file, "%.17g %.17g %.17g 0\n", x, y, z);
  }
  const int third = is_mirrored(image) ? 3 : 2;
  std::fprintf(file, "Tetrahedra\n%zu\n", static_cast<std::size_t>(mesh.number_of_cells_in_complex()));
  for (auto cell = mesh.cells_in_complex_begin(); cell != mesh.cells_in_complex_end(); ++cell)
    std::fprintf(file, "%zu %zu %zu %zu %d\n", numbers.at(cell->vertex(0)), numbers.at(cell->vertex(1)),
                 numbers.at(cell->vertex(third)), numbers.at(cell->vertex(5 - third)),
                 static_cast<int>(mesh.subdomain_index(cell)));
  std::fprintf(file, "End\n");
  if (std::fclose(file) != 0) throw std::runtime_error(path + ": cannot be written");
}

template <class Work>
double seconds_of(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double peak_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

void run(const Options& options) {
  peers::LabelImage image = peers::read_nrrd(options.image);
  const CGAL::Image_3 voxels = cgal_image(image);
  image.labels = {};
#ifdef PAR
  const int threads = std::max(1, static_cast<int>(options.threads));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
#else
  const int threads = 1;
#endif
  Complex mesh;
  double perturb_seconds = 0, exude_seconds = 0;
  const Domain domain =
      Domain::create_labeled_image_mesh_domain(voxels, params::relative_error_bound = options.error_bound);
  const Criteria criteria(params::facet_angle = options.facet_angle, params::facet_size = options.facet_size,
                          params::facet_distance = options.facet_distance,
                          params::cell_radius_edge_ratio = options.radius_edge,
                          params::cell_size = options.cell_size);
  const double seconds = seconds_of([&] {
    mesh = CGAL::make_mesh_3<Complex>(domain, criteria, params::no_perturb(), params::no_exude(),
                                      options.manifold != 0 ? params::manifold() : params::non_manifold());
  });
  if (options.perturb != 0) perturb_seconds = seconds_of([&] { CGAL::perturb_mesh_3(mesh, domain); });
  if (options.exude != 0) exude_seconds = seconds_of([&] { CGAL::exude_mesh_3(mesh); });
  const double mib = peak_mib();
  const auto numbers = numbers_of(mesh);
  if (!options.output.empty()) write_medit(options.output, mesh, image, numbers);
  std::printf(
      "{\"program\": \"CGAL %s Mesh_3 %s\", \"threads\": %d, \"seconds\": %.6f, \"perturb_seconds\": %.6f, "
      "\"exude_seconds\": %.6f, \"tetrahedra\": %zu, \"vertices\": %zu, \"peak_mib\": %.1f}\n",
      CGAL_VERSION_STR, kTag, threads, seconds, perturb_seconds, exude_seconds,
      static_cast<std::size_t>(mesh.number_of_cells_in_complex()), numbers.size(), mib);
}

}  // namespace

int main(int argc, char** argv) try {
  run(parse(argc, argv));
  return 0;
} catch (const std::invalid_argument& fault) {
  std::cerr << argv[0] << ": " << fault.what() << "\n\n" << kUsage;
  return 1;
} catch (const std::exception& fault) {
  std::cerr << argv[0] << ": " << fault.what() << '\n';
  return 2;
}
