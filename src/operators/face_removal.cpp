#include <algorithm>
#include <array>
#include <span>

#include "apply.hpp"
#include "lumesh/operators/reconnection.hpp"

namespace lumesh::operators {
namespace {

constexpr std::size_t kMaxRim = kMaxFaces + 2;

/// Faces that lie between two vertices, `below` and `above`, joined by edges. What is on both sides of them
/// can be replaced by tetrahedra around a new edge from one vertex to the other, one for each edge of the
/// faces' rim.
template <class Lock>
class SandwichedFaces {
 public:
  /// An edge of the rim, anticlockwise seen from above, with the tetrahedra at it and their corner opposite.
  struct RimEdge {
    std::uint32_t from, to;
    VertexId opposite;
    TetId lower, upper;
  };

  /// @param min_cubed  Of the quality of each new tetrahedron: it must be above.
  SandwichedFaces(const TetMesh& mesh, const ShapeMeasure& measure, Lock& lock, double min_cubed,
                  std::size_t max_faces)
      : mesh_(mesh), measure_(measure), lock_(lock), min_cubed_(min_cubed), max_faces_(max_faces) {}

  /// Begins with a face of `lower`, whose vertices are held as those of `upper` are, and adds faces next to
  /// it where the rim's tetrahedra would not do.
  /// @return false if none do.
  bool find(TetId lower, int face, TetId upper, int upper_face) {
    below_ = mesh_.vertex(lower, face);
    above_ = mesh_.vertex(upper, upper_face);
    const Cell<3> corners = mesh_.face_corners(lower, face);
    add(lower, upper);
    for (int k = 0; k < 3; ++k)
      if (!close_at({corners[k], corners[(k + 1) % 3], VertexId(corners[(k + 2) % 3]), lower, upper}))
        return false;
    return true;
  }
  [[nodiscard]] VertexId below() const { return below_; }
  [[nodiscard]] VertexId above() const { return above_; }
  [[nodiscard]] std::span<const TetId> tets() const { return {tets_.data(), 2 * faces_}; }
  [[nodiscard]] std::span<const RimEdge> rim() const { return {rim_.data(), rim_size_}; }
  [[nodiscard]] std::span<const double> cubed() const { return {cubed_.data(), rim_size_}; }
  /// True if a vertex was not to be locked where a face might have been added.
  [[nodiscard]] bool contended() const { return contended_; }

 private:
  void add(TetId lower, TetId upper) {
    tets_[2 * faces_] = lower;
    tets_[2 * faces_ + 1] = upper;
    ++faces_;
  }

  /// Puts a tetrahedron at the edge, or adds the face behind it.
  bool close_at(const RimEdge& edge) {
    const VertexId u(edge.from), w(edge.to);
    const double cubed = quality_cubed(measure_, mesh_, u, w, below_, above_);
    if (cubed > min_cubed_ &&
        orient3d(mesh_.point(u), mesh_.point(w), mesh_.point(below_), mesh_.point(above_)) > 0) {
      cubed_[rim_size_] = cubed;
      rim_[rim_size_++] = edge;
      return true;
    }
    const auto behind = [&](TetId t) {
      const int face = mesh_.index_of(t, edge.opposite);
      return mesh_.patch(t, face).valid() ? FaceLink() : mesh_.link(t, face);
    };
    const FaceLink lower = behind(edge.lower), upper = behind(edge.upper);
    if (faces_ == max_faces_ || lower.is_boundary() || upper.is_boundary()) return false;
    const VertexId far = mesh_.vertex(lower.tet(), lower.face());
    if (mesh_.vertex(upper.tet(), upper.face()) != far || !is_face_between(lower.tet(), upper.tet()))
      return false;
    if (!lock_.try_lock(far)) {
      contended_ = true;
      return false;
    }
    add(lower.tet(), upper.tet());
    return close_at({edge.from, far.value, w, lower.tet(), upper.tet()}) &&
           close_at({far.value, edge.to, u, lower.tet(), upper.tet()});
  }
  /// True if they share the face opposite `below` and `above`, without a patch, and do not go yet.
  [[nodiscard]] bool is_face_between(TetId lower, TetId upper) const {
    const int face = mesh_.index_of(lower, below_);
    const FaceLink link = mesh_.link(lower, face);
    return !link.is_boundary() && link.tet() == upper && !mesh_.interface_patch(lower, face).valid() &&
           std::find(tets().begin(), tets().end(), lower) == tets().end();
  }

  const TetMesh& mesh_;
  const ShapeMeasure& measure_;
  Lock& lock_;
  double min_cubed_;
  std::size_t max_faces_;
  VertexId below_, above_;
  std::array<TetId, 2 * kMaxFaces> tets_;
  std::size_t faces_ = 0;
  std::array<RimEdge, kMaxRim> rim_;
  std::array<double, kMaxRim> cubed_;
  std::size_t rim_size_ = 0;
  bool contended_ = false;
};

/// Puts the tetrahedra around the new edge in the place of those at the faces.
template <class Lock>
void replace(Builder& builder, const SandwichedFaces<Lock>& faces) {
  TetMesh& mesh = builder.mesh;
  std::array<Side, kMaxRim> over, under;
  std::array<TetId, kMaxRim> made;
  const auto rim = faces.rim();
  for (std::size_t k = 0; k < rim.size(); ++k) {
    const auto& [from, to, opposite, lower, upper] = rim[k];
    over[k] = side_of(mesh, upper, mesh.index_of(upper, opposite));
    under[k] = side_of(mesh, lower, mesh.index_of(lower, opposite));
  }
  const Label label = mesh.label(faces.tets()[0]);
  for (const TetId t : faces.tets()) builder.free_tet(t);
  for (std::size_t k = 0; k < rim.size(); ++k) {
    made[k] = builder.add_tet({rim[k].from, rim[k].to, faces.below().value, faces.above().value}, label);
    mesh.set_quality(made[k], static_cast<float>(metric::cube_root(faces.cubed()[k])));
    put_behind(mesh, made[k], 2, over[k]);
    put_behind(mesh, made[k], 3, under[k]);
    for (const std::uint32_t v : mesh.tet(made[k])) mesh.set_incident_tet(VertexId(v), made[k]);
  }
  for (std::size_t k = 0; k < rim.size(); ++k)
    link_to(mesh, made[k], 0, FaceLink::to(made[(k + 1) % rim.size()], 1));
}

}  // namespace

Outcome FaceRemoval::operator()(auto& site, const TetFace& at) const {
  const auto [t, face] = at;
  const TetMesh& mesh = site.mesh;
  const FaceLink link = mesh.link(t, face);
  if (link.is_boundary() || mesh.interface_patch(t, face).valid()) return Outcome::kRejected;
  if (!site.lock.try_lock(mesh.vertex(link.tet(), link.face()))) return Outcome::kContended;
  const double min_quality = std::min(mesh.quality(t), mesh.quality(link.tet())) + rules.min_gain;
  SandwichedFaces faces(mesh, site.subject.measure, site.lock, metric::cube(min_quality), rules.max_faces);
  if (!faces.find(t, face, link.tet(), link.face()))
    return faces.contended() ? Outcome::kContended : Outcome::kRejected;
  if (is_longer_than(rules.max_length, mesh, faces.below(), faces.above())) return Outcome::kRejected;
  const Joined joined = are_joined(mesh, faces.below(), faces.above(), site.lock, site.scratch.ball);
  if (const auto refusal = refusal_of(joined)) return *refusal;
  replace(site.scratch.builder, faces);
  return Outcome::kApplied;
}

template struct OperatorCode<FaceRemoval>;

}  // namespace lumesh::operators
