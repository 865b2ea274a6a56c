/// @file From a label image to a mesh with the library: mesh_an_image IMAGE MESH.

#include <cstdio>

#include "lumesh/core/context.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/lattice/lattice.hpp"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: mesh_an_image IMAGE MESH\n");
    return 1;
  }
  try {
    lumesh::Context context;
    const lumesh::LabelImage image = lumesh::read_image(argv[1], {}, context);
    const lumesh::ImageDomain domain(image, {});
    lumesh::LatticeOptions options;
    options.spacing_mm = 4 * image.frame().spacing_mm.minCoeff();
    const lumesh::LatticeResult result = lumesh::mesh_lattice(image, domain, options, context);
    lumesh::write_mesh(argv[2], result.mesh.view());
    std::printf("%zu tetrahedra\n", result.mesh.tetrahedra.size());
  } catch (const lumesh::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
