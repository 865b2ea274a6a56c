#include <algorithm>
#include <limits>
#include <map>

#include "cell_blocks.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/cell_corners.hpp"
#include "lumesh/mesh/cell_faces.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

namespace {

struct Face {
  Cell<4> sorted;   // for finding the other side
  Cell<4> corners;  // outwards
  Label label = 0;
  friend bool operator<(const Face& a, const Face& b) {
    return std::tie(a.sorted, a.label, a.corners) < std::tie(b.sorted, b.label, b.corners);
  }
};

std::vector<Face> all_faces(const MeshView& mesh) {
  std::vector<Face> faces;
  for (const io::CellBlock& block : io::volume_blocks(mesh)) {
    const auto part = parallel::collect<Face>(block.size(), [&](std::size_t c, std::vector<Face>& out) {
      const auto cell = block.cell(c);
      for (const LocalFace& local : faces_of_cell(block.corners)) {
        Face face;
        for (std::size_t i = 0; i < 4; ++i) face.corners[i] = cell[local[i]];
        face.sorted = face.corners;
        if (local[2] == local[3])
          face.sorted[3] = ~std::uint32_t{0};  // a triangle: its doubled corner must not tell
        std::sort(face.sorted.begin(), face.sorted.end());
        face.label = block.tags[c];
        out.push_back(face);
      }
    });
    faces.insert(faces.end(), part.begin(), part.end());
  }
  parallel::sort(faces.begin(), faces.end());
  return faces;
}

std::string patch_name(Label inside, Label outside, bool single_label) {
  if (outside != kBackground) return "interface_" + std::to_string(inside) + "_" + std::to_string(outside);
  return single_label ? "wall" : "wall_" + std::to_string(inside);
}

}  // namespace

std::size_t count_inverted_cells(const MeshView& mesh) {
  std::size_t count = 0;
  for (const io::CellBlock& block : io::volume_blocks(mesh)) {
    count += parallel::reduce_blocks(
        block.size(), 4096, std::size_t{0},
        [&](std::size_t begin, std::size_t end) {
          std::size_t n = 0;
          for (std::size_t i = begin; i < end; ++i)
            n += has_turned_corner(mesh.points, block.cell(i)) ? 1 : 0;
          return n;
        },
        [](std::size_t a, std::size_t b) { return a + b; });
  }
  return count;
}

void extract_boundary(MixedMesh& mesh) {
  const std::vector<Face> faces = all_faces(mesh.view());
  std::map<std::pair<Label, Label>, std::vector<Cell<4>>> by_pair;  // (inside, outside)
  bool single_label = true;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    single_label &= faces[i].label == faces[0].label;
    const bool paired = i + 1 < faces.size() && faces[i + 1].sorted == faces[i].sorted;
    if (!paired) {
      by_pair[{faces[i].label, kBackground}].push_back(faces[i].corners);
      continue;
    }
    if (faces[i].label != faces[i + 1].label)
      by_pair[{faces[i].label, faces[i + 1].label}].push_back(faces[i].corners);
    ++i;
  }
  mesh.triangles.clear();
  mesh.triangle_patches.clear();
  mesh.quadrilaterals.clear();
  mesh.quadrilateral_patches.clear();
  mesh.info.patches.clear();
  for (const auto& [pair, list] : by_pair) {
    const auto patch = static_cast<std::int32_t>(mesh.info.patches.size());
    mesh.info.patches.push_back({patch_name(pair.first, pair.second, single_label),
                                 pair.second == kBackground ? PatchKind::kWall : PatchKind::kInterface,
                                 {pair.first, pair.second}});
    for (const Cell<4>& c : list) {
      if (c[2] == c[3]) {
        mesh.triangles.push_back({c[0], c[1], c[2]});
        mesh.triangle_patches.push_back(patch);
      } else {
        mesh.quadrilaterals.push_back(c);
        mesh.quadrilateral_patches.push_back(patch);
      }
    }
  }
}

}  // namespace lumesh
