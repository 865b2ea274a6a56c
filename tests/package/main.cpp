/// @file Uses an installed lumesh: meshes a box of voxels, writes the mesh, reads it again.

#include <cstdio>

#include "lumesh/core/context.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/lattice/lattice.hpp"

/// The example of docs/stages/domain.md; CMakeLists.txt makes it of the page.
void ask_domain(const lumesh::LabelImage& image);

int main(int argc, char** argv) {
  if (argc != 2) return 1;
  lumesh::ImageFrame frame;
  frame.size = {16, 16, 16};
  lumesh::LabelImage image(frame, {0, 1});
  for (int k = 4; k < 12; ++k)
    for (int j = 4; j < 12; ++j)
      for (int i = 4; i < 12; ++i) image.at({i, j, k}) = 1;
  ask_domain(image);
  lumesh::Context context;
  const lumesh::ImageDomain domain(image, {});
  const lumesh::LatticeResult result = lumesh::mesh_lattice(image, domain, {}, context);
  lumesh::write_mesh(argv[1], result.mesh.view());
  const lumesh::MixedMesh read = lumesh::read_mesh(argv[1]);
  std::printf("%zu tetrahedra\n", read.tetrahedra.size());
  return !read.tetrahedra.empty() && read.tetrahedra.size() == result.mesh.tetrahedra.size() ? 0 : 1;
}
