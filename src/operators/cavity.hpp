#pragma once
/// @file The hole in which a new vertex is put: a star-shaped set of tetrahedra that is filled with new ones,
/// from each face of its hull to the vertex.

#include <span>
#include <vector>

#include "angle_star.hpp"
#include "builder.hpp"
#include "lumesh/core/local_map.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/metric/measures.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/operators/patch_shapes.hpp"
#include "lumesh/operators/rules.hpp"
#include "lumesh/operators/shape_measure.hpp"
#include "star_shapes.hpp"

namespace lumesh::operators {

/// A vertex to be.
struct NewVertex {
  Vec3 point;
  metric::MetricPair metric;
  TetId hint;
  VertexDimension dimension = VertexDimension::kVolume;
  std::span<const PatchId> patches;  ///< Patches that it will lie on.
  VertexId edge_a, edge_b;           ///< The edge that it splits.
};

class Cavity {
 public:
  /// Begins with the tetrahedra around the new vertex; they stay in.
  void begin(std::span<const TetId> tets);

  /// Adds neighbours, and theirs, whose circumsphere in the metric of the new vertex holds it; never through
  /// a face with a patch, nor what is not to be locked.
  /// @return false if that are more than `max_tets` tetrahedra.
  template <class Lock>
  bool enlarge(const TetMesh& mesh, const NewVertex& vertex, int max_tets, Lock& lock);

  /// Removes tetrahedra until the cavity is star-shaped: every face of the hull sees the new vertex, and no
  /// old vertex is lost. @return false if a tetrahedron would go that must stay.
  bool shrink_to_star_shaped(const TetMesh& mesh, const NewVertex& vertex, const PatchShapes& shapes);

  /// Measures the tetrahedra that would fill the cavity. @return false if a rule speaks against them.
  bool accept(const TetMesh& mesh, const NewVertex& vertex, const PatchShapes& shapes,
              const InsertionRules& rules);

  /// Moves `place`, where the vertex would be, to where the worst angle of the new tetrahedra is best.
  /// @return the worst quality there, or -1 if that is not better than the worst one inside now.
  double optimise(const TetMesh& mesh, Vec3& place, AngleStar& angles, const ShapeMeasure& measure,
                  const AngleRules& rules);

  /// Puts the vertex in. Cannot fail but for memory.
  VertexId fill(Builder& builder, const NewVertex& vertex);

  /// Inner vertices nearer than rules.min_length to a new vertex of a surface; known after accept().
  [[nodiscard]] std::span<const VertexId> too_near() const { return too_near_; }
  /// The shortest edge of the hull between vertices of patches; infinite if there is none.
  [[nodiscard]] double shortest_patch_edge(const TetMesh& mesh) const;
  /// Vertices that a new one is joined to; known after shrink_to_star_shaped().
  [[nodiscard]] std::span<const std::uint32_t> hull_vertices() const { return hull_vertex_list_; }

 private:
  struct HullFace {
    Cell<3> corners;  ///< Positively oriented with a point inside as the fourth.
    TetId tet;        ///< The tetrahedron inside.
    FaceLink behind;
    PatchId patch;  ///< Invalid if there is none.
    Label label;    ///< Label of `tet`.
    bool absorbed;  ///< A face of a patch that the new vertex lies on: it is replaced by smaller ones.
    TetId filled;   ///< The new tetrahedron on it.
    float quality;
  };
  struct PatchEdge {
    std::uint32_t a, b;
    PatchId patch;
  };

  enum class Place : char { kInside, kOutside };

  bool take_out_blind_tets(const TetMesh& mesh, const NewVertex& vertex, const PatchShapes& shapes,
                           bool& stuck);
  bool take_out_lost_vertices(const TetMesh& mesh, bool& stuck);
  void keep_inside_only();
  [[nodiscard]] bool is_near_patch(const TetMesh& mesh, const NewVertex& vertex, const PatchShapes& shapes,
                                   double min_height) const;
  /// True unless the hull touches itself. Where the mesh is embedded that follows from what the new vertex
  /// sees; where a surface that moves has come to overlap itself, it does not.
  [[nodiscard]] bool has_sphere_as_hull();
  /// For vertices of curved patches (cavity_surface.cpp), where neither holds by itself as in planes. The
  /// absorbed faces are a disc with all its vertices on its rim, cut by no curve but the split edge:
  [[nodiscard]] bool absorbs_disc(const NewVertex& vertex);
  /// and the triangles from the rim to the vertex keep to the surface.
  [[nodiscard]] bool keeps_to_surface(const TetMesh& mesh, const NewVertex& vertex,
                                      const PatchShapes& shapes) const;
  [[nodiscard]] bool is_inside(TetId t) {
    const Place* place = places_.find(t.value);
    return place != nullptr && *place == Place::kInside;
  }
  void note_interfaces(const TetMesh& mesh);
  void link_new_tets(TetMesh& mesh);
  void link_across(TetMesh& mesh, std::size_t face, int corner, std::uint32_t other);
  [[nodiscard]] PatchId patch_of_edge(std::uint32_t a, std::uint32_t b) const;

  std::vector<TetId> tets_;
  std::size_t kept_ = 0;  // The first ones of tets_, which stay.
  LocalMap<std::uint32_t, Place> places_;
  std::vector<HullFace> hull_;
  LocalMap<std::uint32_t, char> hull_vertices_;
  std::vector<std::uint32_t> hull_vertex_list_;
  LocalMap<std::uint64_t, std::uint32_t> open_edges_;
  std::vector<PatchEdge> interface_edges_;  // Edges of faces between labels inside the hole.
  std::vector<PatchEdge> rim_;              // Rim of the absorbed faces; anticlockwise from outside.
  std::vector<VertexId> too_near_;
  StarShapes shapes_;
};

/// Carries space into the one where a metric is the identity, the origin to the new vertex.
class MetricFrame {
 public:
  /// @param metric  Positive definite; its Cholesky factor is the map.
  MetricFrame(const SymTensor& metric, const Vec3& origin);
  [[nodiscard]] Vec3 operator()(const Vec3& point) const {
    const Vec3 e = point - origin_;
    return {xx_ * e[0] + xy_ * e[1] + xz_ * e[2], yy_ * e[1] + yz_ * e[2], zz_ * e[2]};
  }
  /// The vector v with v . (p - origin) = a . frame(p).
  [[nodiscard]] Vec3 covector(const Vec3& a) const {
    return {xx_ * a[0], xy_ * a[0] + yy_ * a[1], xz_ * a[0] + yz_ * a[1] + zz_ * a[2]};
  }

 private:
  Vec3 origin_;
  double xx_, xy_, xz_, yy_, yz_, zz_;
};

/// True if the origin lies inside the circumsphere of a positively oriented tetrahedron. In floating point:
/// the caller corrects what is wrong.
[[nodiscard]] inline bool circumsphere_holds_origin(const Vec3& a, const Vec3& b, const Vec3& c,
                                                    const Vec3& d) {
  return a.squaredNorm() * metric::triple_product(b, c, d) -
             b.squaredNorm() * metric::triple_product(a, c, d) +
             c.squaredNorm() * metric::triple_product(a, b, d) -
             d.squaredNorm() * metric::triple_product(a, b, c) >
         0;
}

template <class Lock>
bool Cavity::enlarge(const TetMesh& mesh, const NewVertex& vertex, int max_tets, Lock& lock) {
  const MetricFrame frame(vertex.metric.metric, vertex.point);
  for (std::size_t next = 0; next < tets_.size(); ++next) {
    for (int f = 0; f < 4; ++f) {
      const FaceLink link = mesh.link(tets_[next], f);
      if (link.is_boundary() || mesh.interface_patch(tets_[next], f).valid()) continue;
      const TetId t = link.tet();
      const auto [place, added] = places_.insert(t.value, Place::kOutside);
      if (!added) continue;
      const Cell<4>& v = mesh.tet(t);
      const bool holds =
          circumsphere_holds_origin(frame(mesh.point(VertexId(v[0]))), frame(mesh.point(VertexId(v[1]))),
                                    frame(mesh.point(VertexId(v[2]))), frame(mesh.point(VertexId(v[3]))));
      if (!holds || !lock.try_lock(mesh.vertex(t, link.face()))) continue;
      place = Place::kInside;
      tets_.push_back(t);
      if (static_cast<int>(tets_.size()) > max_tets) return false;
    }
  }
  return true;
}

}  // namespace lumesh::operators
