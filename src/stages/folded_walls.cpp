#include "lumesh/stages/folded_walls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lumesh/core/angles.hpp"
#include "lumesh/core/counted.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/domain/facing.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh {

namespace {

struct Folds {
  std::size_t count = 0;
  double worst_cosine = 0;
  Vec3 worst_mm = Vec3::Zero();

  void add(const Folds& other) {
    count += other.count;
    if (other.worst_cosine >= worst_cosine) return;
    worst_cosine = other.worst_cosine;
    worst_mm = other.worst_mm;
  }
};

/// Per patch: the material inside where it is a wall, the background elsewhere.
std::vector<Material> materials_inside_walls(const MeshView& mesh, const ImageDomain& domain) {
  std::vector<Material> inside(mesh.info->patches.size(), 0);
  for (std::size_t p = 0; p < inside.size(); ++p) {
    const Patch& patch = mesh.info->patches[p];
    if (patch.kind == PatchKind::kWall) inside[p] = domain.material_of(patch.labels[0]).value_or(0);
  }
  return inside;
}

/// The triangle alone, if it is a fold.
Folds fold_at(const MeshView& mesh, const ImageDomain& domain, std::size_t triangle, Material inside) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  const Vec3 &p = mesh.points[a], &q = mesh.points[b], &r = mesh.points[c];
  const double cosine = std::max(-1.0, cosine_to_boundary(domain, p, q, r, inside, 0));
  return cosine < 0 ? Folds{1, cosine, triangle_centre(p, q, r)} : Folds{};
}

}  // namespace

std::vector<std::string> note_of_folds(const MeshView& mesh, const ImageDomain& domain) {
  const std::vector<Material> inside = materials_inside_walls(mesh, domain);
  const Folds folds = parallel::reduce(
      mesh.triangles.size(), 1024, Folds{},
      [&](Folds& found, std::size_t t) {
        if (const Material m = inside[static_cast<std::size_t>(mesh.triangle_patches[t])]; m != 0)
          found.add(fold_at(mesh, domain, t, m));
      },
      [](Folds a, const Folds& b) {
        a.add(b);
        return a;
      });
  if (folds.count == 0) return {};
  return {
      fmt::format("the wall is folded: {} against the image's boundary, the worst at {} by {:.0f} degrees; a "
                  "smaller `edge_length` may help",
                  counted(folds.count, "triangle faces", "triangles face"), place_text(folds.worst_mm),
                  degrees(std::acos(folds.worst_cosine)))};
}

}  // namespace lumesh
