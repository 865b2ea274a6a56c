#include "flat_tets.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "relabelling.hpp"

namespace lumesh::delaunay {
namespace {

constexpr double kCosineOfFlat = -0.8192;      // 145 degrees between two faces: what improvement aims at.
constexpr double kCosineOfGoodAngle = 0.9063;  // 25 degrees in a face.

/// The faces of one tetrahedron.
class Faces {
 public:
  Faces(const TetMesh& mesh, TetId t) : mesh_(mesh), tet_(t) {}

  [[nodiscard]] Vec3 normal(std::size_t f) const {
    const auto& [a, b, c] = kTetFaces[f];
    return triangle_normal(mesh_.corner(tet_, a), mesh_.corner(tet_, b), mesh_.corner(tet_, c));
  }
  [[nodiscard]] double cosine_of_smallest(std::size_t f) const {
    const auto& [a, b, c] = kTetFaces[f];
    return cosine_of_smallest_angle(mesh_.corner(tet_, a), mesh_.corner(tet_, b), mesh_.corner(tet_, c));
  }
  [[nodiscard]] bool are_flat(std::size_t f, std::size_t g) const {
    return -normal(f).dot(normal(g)) < kCosineOfFlat;
  }
  /// True if the two other faces would be good boundary faces, or no worse ones than these two.
  [[nodiscard]] bool may_be_left(std::size_t f, std::size_t g) const {
    const double limit = std::max({kCosineOfGoodAngle, cosine_of_smallest(f), cosine_of_smallest(g)});
    for (std::size_t h = 0; h < 4; ++h)
      if (h != f && h != g && !(cosine_of_smallest(h) <= limit)) return false;
    return true;
  }

 private:
  const TetMesh& mesh_;
  TetId tet_;
};

/// One material is all that is not meshed, but for cut planes.
Material side_of(const Domain& domain, TetId t, const TetMesh& mesh) {
  const auto m = static_cast<Material>(mesh.label(t));
  return domain.is_meshed(m) || domain.is_cut(m) ? m : 0;
}

/// The material behind two faces of a tetrahedron, if they are flat and the tetrahedron is to have it.
std::optional<Material> taker_of(const TetMesh& mesh, const Domain& domain, TetId t) {
  const Cell<4>& corners = mesh.tet(t);
  if (std::ranges::none_of(
          corners, [&](std::uint32_t v) { return mesh.dimension(VertexId(v)) <= VertexDimension::kCurve; }))
    return std::nullopt;
  const Material mine = side_of(domain, t, mesh);
  std::array<Material, 4> behind;
  for (int f = 0; f < 4; ++f) {
    const FaceLink link = mesh.link(t, f);
    if (link.is_boundary()) return std::nullopt;
    behind[static_cast<std::size_t>(f)] = side_of(domain, link.tet(), mesh);
  }
  const Faces faces(mesh, t);
  for (std::size_t f = 0; f < 4; ++f)
    for (std::size_t g = f + 1; g < 4; ++g)
      if (behind[f] == behind[g] && behind[f] != mine && !domain.is_cut(behind[f]) && faces.are_flat(f, g) &&
          faces.may_be_left(f, g))
        return behind[f];
  return std::nullopt;
}

}  // namespace

std::size_t relabel_flat(TetMesh& mesh, const Domain& domain) {
  if (domain.label_count() <= 2) return 0;
  return relabel_unless_pinching(mesh, domain, [&](TetId t) -> std::optional<Material> {
    if (!domain.is_meshed(static_cast<Material>(mesh.label(t)))) return std::nullopt;
    return taker_of(mesh, domain, t);
  });
}

}  // namespace lumesh::delaunay
