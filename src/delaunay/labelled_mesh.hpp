#pragma once
/// @file The tetrahedra of a TetMesh with their materials, for the repair of boundaries. What it does depends
/// on the places of vertices alone, never on numbers.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "lumesh/domain/label_star.hpp"
#include "lumesh/geometry/perturbed_insphere.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "places.hpp"

namespace lumesh::delaunay {

/// Labels of tetrahedra are materials.
class LabelledMesh {
 public:
  LabelledMesh(const TetMesh& mesh, const Domain& domain) : mesh_(mesh), domain_(domain) {}

  using StarScratch = VertexStar;
  void gather_star(std::uint32_t v, VertexStar& star, std::vector<std::uint32_t>& tets) const {
    tets.clear();
    for (const TetId t : star.gather(mesh_, VertexId(v))) tets.push_back(t.value);
  }
  [[nodiscard]] std::array<std::uint32_t, 4> corners(std::uint32_t t) const { return mesh_.tet(TetId(t)); }
  [[nodiscard]] std::uint32_t behind(std::uint32_t t, std::size_t face) const {
    const FaceLink link = mesh_.link(TetId(t), static_cast<int>(face));
    return link.is_boundary() ? kNoTet : link.tet().value;
  }
  [[nodiscard]] Material material(std::uint32_t t) const {
    return static_cast<Material>(mesh_.label(TetId(t)));
  }
  [[nodiscard]] bool is_object(Material m) const { return domain_.is_meshed(m); }

 protected:
  const TetMesh& mesh_;
  const Domain& domain_;
};

/// The same to be changed.
class RelabelledMesh : public LabelledMesh {
 public:
  RelabelledMesh(TetMesh& mesh, const Domain& domain) : LabelledMesh(mesh, domain), changed_mesh_(mesh) {}

  void set_material(std::uint32_t t, Material m) { changed_mesh_.set_label(TetId(t), static_cast<Label>(m)); }
  void note_change(std::uint32_t /*tet*/) {}
  void sort_tets(std::vector<std::uint32_t>& tets) const {
    std::vector<std::pair<CornerPlaces, std::uint32_t>> places;
    for (const std::uint32_t t : tets) places.emplace_back(corner_places(mesh_, TetId(t)), t);
    std::ranges::sort(places, is_earlier,
                      [](const auto& place) -> const CornerPlaces& { return place.first; });
    std::ranges::transform(places, tets.begin(), [](const auto& place) { return place.second; });
  }
  void sort_vertices(std::vector<std::uint32_t>& vertices) const {
    std::ranges::sort(vertices, [&](std::uint32_t a, std::uint32_t b) {
      return precedes(mesh_.point(VertexId(a)), mesh_.point(VertexId(b)));
    });
  }
  [[nodiscard]] std::uint32_t seed(std::uint32_t v) const {
    const Vec3& x = mesh_.point(VertexId(v));
    std::uint64_t mixed = 0;
    for (int axis = 0; axis < 3; ++axis)
      mixed = (mixed ^ std::bit_cast<std::uint64_t>(x[axis])) * 0x9E3779B97F4A7C15ull;
    return static_cast<std::uint32_t>(mixed >> 32);
  }

 private:
  TetMesh& changed_mesh_;
};

}  // namespace lumesh::delaunay
