#include "cavity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "links.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/edge_key.hpp"
#include "surface_rules.hpp"

namespace lumesh::operators {
namespace {

constexpr std::uint32_t kAbsorbedEdge =
    0x80000000u;  // With the patch; others hold tetrahedron << 2 | corner.
constexpr int kMaxRounds = 50;

/// True if a face of a patch is replaced by smaller ones with the new vertex: it lies on the same patch, and
/// where that is curved not on another side of it.
bool absorbs(const TetMesh& mesh, const NewVertex& vertex, const Cell<3>& corners, PatchId patch,
             const PatchShapes& shapes) {
  if (std::ranges::find(vertex.patches, patch) == vertex.patches.end()) return false;
  const PatchShape& shape = shapes[patch.value];
  if (shape.freedom != PatchFreedom::kCurved) return shape.freedom == PatchFreedom::kPlane;
  constexpr double kSameSide = 0.3;
  const auto at = [&](int k) { return mesh.point(VertexId(corners[k])); };
  return triangle_normal(at(0), at(1), at(2)).dot(patch_normal(shape, vertex.point)) > kSameSide;
}

/// Distance of the origin from the plane through three points.
double height_over(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  return std::abs(normal.dot(a)) / normal.norm();
}

/// How deep an inner vertex lies below a surface, in its metric; negative outside.
double depth_below(const Surface& surface, const NewVertex& vertex) {
  const SurfacePoint nearest = surface.closest(vertex.point);
  return nearest.normal.dot(nearest.point - vertex.point) *
         std::sqrt(vertex.metric.metric.quadratic(nearest.normal));
}

}  // namespace

MetricFrame::MetricFrame(const SymTensor& m, const Vec3& origin) : origin_(origin) {
  xx_ = std::sqrt(m.xx);
  xy_ = m.xy / xx_;
  xz_ = m.xz / xx_;
  constexpr double kTiny = 1e-300;  // Rounding may leave nothing under the root.
  yy_ = std::sqrt(std::max(kTiny, m.yy - xy_ * xy_));
  yz_ = (m.yz - xz_ * xy_) / yy_;
  zz_ = std::sqrt(std::max(kTiny, m.zz - xz_ * xz_ - yz_ * yz_));
}

void Cavity::begin(std::span<const TetId> tets) {
  tets_.assign(tets.begin(), tets.end());
  kept_ = tets.size();
  places_.clear();
  for (const TetId t : tets) places_.insert(t.value, Place::kInside);
}

void Cavity::keep_inside_only() {
  const auto first = tets_.begin() + static_cast<std::ptrdiff_t>(kept_);
  tets_.erase(std::remove_if(first, tets_.end(), [&](TetId t) { return !is_inside(t); }), tets_.end());
}

bool Cavity::take_out_blind_tets(const TetMesh& mesh, const NewVertex& vertex, const PatchShapes& shapes,
                                 bool& stuck) {
  bool changed = false;
  hull_.clear();
  for (std::size_t i = 0; i < tets_.size(); ++i) {
    const TetId t = tets_[i];
    for (int f = 0; f < 4; ++f) {
      const FaceLink link = mesh.link(t, f);
      if (!link.is_boundary() && is_inside(link.tet())) continue;
      const auto [x, y, z] = mesh.face_corners(t, f);  // From outside; from inside the other way round.
      const PatchId patch = mesh.patch(t, f);
      const bool absorbed = link.is_boundary() && absorbs(mesh, vertex, {x, y, z}, patch, shapes);
      if (!absorbed && orient3d(mesh.point(VertexId(x)), mesh.point(VertexId(z)), mesh.point(VertexId(y)),
                                vertex.point) <= 0) {
        if (i < kept_) {
          stuck = true;
          return true;
        }
        *places_.find(t.value) = Place::kOutside;
        changed = true;
        break;
      }
      hull_.push_back({{x, z, y}, t, link, patch, mesh.label(t), absorbed, TetId(), 0});
    }
  }
  return changed;
}

bool Cavity::take_out_lost_vertices(const TetMesh& mesh, bool& stuck) {
  hull_vertices_.clear();
  hull_vertex_list_.clear();
  for (const HullFace& face : hull_)
    for (const std::uint32_t v : face.corners)
      if (hull_vertices_.insert(v, 0).added) hull_vertex_list_.push_back(v);
  const auto loses_one = [&](TetId t) {
    const Cell<4>& v = mesh.tet(t);
    return std::ranges::any_of(v, [&](std::uint32_t x) { return !hull_vertices_.contains(x); });
  };
  bool lost = false, changed = false;
  for (std::size_t i = 0; i < tets_.size(); ++i) {
    if (!loses_one(tets_[i])) continue;
    lost = true;
    if (i < kept_) continue;
    *places_.find(tets_[i].value) = Place::kOutside;
    changed = true;
  }
  stuck = lost && !changed;
  return changed;
}

bool Cavity::shrink_to_star_shaped(const TetMesh& mesh, const NewVertex& vertex, const PatchShapes& shapes) {
  for (int round = 0; round < kMaxRounds; ++round) {
    bool stuck = false;
    const bool changed =
        take_out_blind_tets(mesh, vertex, shapes, stuck) || (!stuck && take_out_lost_vertices(mesh, stuck));
    if (stuck) return false;
    if (!changed) return true;
    keep_inside_only();
  }
  return false;
}

bool Cavity::has_sphere_as_hull() {
  // By Euler's formula: each edge has two faces, in opposite directions, and so E = 3 F / 2. A hull that
  // touches itself in a vertex has one vertex less, one with a handle two.
  if (2 * hull_vertex_list_.size() != hull_.size() + 4) return false;
  open_edges_.clear();
  for (const HullFace& face : hull_)
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t from = face.corners[k], to = face.corners[(k + 1) % 3];
      if (!open_edges_.insert(from << 32 | to, 0).added) return false;
    }
  return true;
}

bool Cavity::accept(const TetMesh& mesh, const NewVertex& vertex, const PatchShapes& shapes,
                    const InsertionRules& rules) {
  const SymTensor& metric = vertex.metric.metric;
  too_near_.clear();
  for (const std::uint32_t w : hull_vertex_list_) {
    const VertexId v(w);
    if (metric::edge_length(vertex.point, metric, mesh.point(v), mesh.metric(v)) >= rules.min_length)
      continue;
    if (mesh.dimension(v) <= vertex.dimension) return false;
    if (mesh.dimension(v) == VertexDimension::kVolume) too_near_.push_back(v);
  }
  if (vertex.dimension == VertexDimension::kVolume && is_near_patch(mesh, vertex, shapes, rules.min_height))
    return false;
  if (is_any_curved(vertex.patches, shapes) &&
      !(absorbs_disc(vertex) && keeps_to_surface(mesh, vertex, shapes)))
    return false;
  shapes_.clear();
  for (const HullFace& face : hull_)
    if (!face.absorbed)
      shapes_.add(mesh, VertexId(face.corners[0]), VertexId(face.corners[1]), VertexId(face.corners[2]));
  const double min_cubed = metric::cube(rules.min_quality);
  const std::span<const double> cubed = shapes_.ratios_cubed_at(vertex.point, vertex.metric.log);
  std::size_t next = 0;
  for (HullFace& face : hull_) {
    if (face.absorbed) continue;
    if (!(cubed[next] >= min_cubed)) return false;
    face.quality = static_cast<float>(metric::cube_root(cubed[next++]));
  }
  return has_sphere_as_hull();
}

double Cavity::shortest_patch_edge(const TetMesh& mesh) const {
  double shortest2 = std::numeric_limits<double>::infinity();
  for (const HullFace& face : hull_)
    for (std::size_t k = 0; k < 3; ++k) {
      const VertexId a(face.corners[k]), b(face.corners[(k + 1) % 3]);
      if (mesh.dimension(a) != VertexDimension::kVolume && mesh.dimension(b) != VertexDimension::kVolume)
        shortest2 = std::min(shortest2, (mesh.point(a) - mesh.point(b)).squaredNorm());
    }
  return std::sqrt(shortest2);
}

double Cavity::optimise(const TetMesh& mesh, Vec3& place, AngleStar& angles, const ShapeMeasure& measure,
                        const AngleRules& rules) {
  double worst = 1;
  for (const TetId t : tets_) worst = std::min<double>(worst, mesh.quality(t));
  const auto at = [&](std::uint32_t v) -> const Vec3& { return mesh.point(VertexId(v)); };
  angles.begin(measure.obtuse_weight);
  for (const HullFace& face : hull_)
    angles.add(at(face.corners[0]), at(face.corners[1]), at(face.corners[2]));
  const double best = angles.climb(place, rules.max_steps);
  if (best < worst + rules.min_gain) return -1;
  for (HullFace& face : hull_) {
    const auto [a, b, c] = face.corners;
    if (orient3d(at(a), at(b), at(c), place) <= 0 || measure.refuses(at(a), at(b), at(c), place)) return -1;
    face.quality = static_cast<float>(angle_quality(at(a), at(b), at(c), place, measure.obtuse_weight));
  }
  return best;
}

bool Cavity::is_near_patch(const TetMesh& mesh, const NewVertex& vertex, const PatchShapes& shapes,
                           double min_height) const {
  const MetricFrame frame(vertex.metric.metric, vertex.point);
  const auto at = [&](std::uint32_t v) { return frame(mesh.point(VertexId(v))); };
  return std::ranges::any_of(hull_, [&](const HullFace& face) {
    if (!face.patch.valid()) return false;
    if (height_over(at(face.corners[0]), at(face.corners[1]), at(face.corners[2])) < min_height) return true;
    const PatchShape& shape = shapes[face.patch.value];  // The face may yet be split and move inwards.
    return shape.freedom == PatchFreedom::kCurved && depth_below(*shape.surface, vertex) < min_height;
  });
}

void Cavity::note_interfaces(const TetMesh& mesh) {
  interface_edges_.clear();
  if (!mesh.has_interfaces()) return;
  for (const TetId t : tets_) {
    for (int f = 0; f < 4; ++f) {
      const PatchId patch = mesh.interface_patch(t, f);
      if (!patch.valid() || !is_inside(mesh.link(t, f).tet())) continue;
      const Cell<3> corners = mesh.face_corners(t, f);
      for (int k = 0; k < 3; ++k) interface_edges_.push_back({corners[k], corners[(k + 1) % 3], patch});
    }
  }
}

PatchId Cavity::patch_of_edge(std::uint32_t a, std::uint32_t b) const {
  for (const PatchEdge& edge : interface_edges_)
    if ((edge.a == a && edge.b == b) || (edge.a == b && edge.b == a)) return edge.patch;
  LUMESH_ASSERT(false);  // Two labels meet at an edge of the hull only where an interface met it before.
  return {};
}

VertexId Cavity::fill(Builder& builder, const NewVertex& vertex) {
  TetMesh& mesh = builder.mesh;
  note_interfaces(mesh);
  const VertexId v = builder.add_vertex(vertex.point);
  mesh.set_metric(v, vertex.metric.metric, vertex.metric.log);
  mesh.set_metric_hint(v, vertex.hint);
  mesh.set_dimension(v, vertex.dimension);
  for (const TetId t : tets_) builder.free_tet(t);
  for (HullFace& face : hull_) {
    if (face.absorbed) continue;
    const auto [a, b, c] = face.corners;
    face.filled = builder.add_tet({a, b, c, v.value}, face.label);
    mesh.set_quality(face.filled, face.quality);
    put_behind(mesh, face.filled, 3, {face.behind, face.patch});
    for (const std::uint32_t corner : face.corners) mesh.set_incident_tet(VertexId(corner), face.filled);
    mesh.set_incident_tet(v, face.filled);
  }
  link_new_tets(mesh);
  return v;
}

void Cavity::link_new_tets(TetMesh& mesh) {
  open_edges_.clear();
  for (std::size_t i = 0; i < hull_.size(); ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t a = hull_[i].corners[(corner + 1) % 3], b = hull_[i].corners[(corner + 2) % 3];
      const std::uint32_t mine =
          hull_[i].absorbed ? kAbsorbedEdge | hull_[i].patch.value
                            : static_cast<std::uint32_t>(i << 2) | static_cast<std::uint32_t>(corner);
      const auto [other, added] = open_edges_.insert(edge_key(a, b), mine);
      if (!added) link_across(mesh, i, corner, other);
    }
  }
}

void Cavity::link_across(TetMesh& mesh, std::size_t i, int corner, std::uint32_t other) {
  const bool other_absorbed = (other & kAbsorbedEdge) != 0;
  if (hull_[i].absorbed && other_absorbed) return;  // The edge of a curve, replaced by two.
  const HullFace& theirs = hull_[other_absorbed ? i : other >> 2];
  if (other_absorbed) {
    mesh.set_link(hull_[i].filled, corner, FaceLink::boundary(PatchId(other & ~kAbsorbedEdge)));
  } else if (hull_[i].absorbed) {
    mesh.set_link(theirs.filled, static_cast<int>(other & 3), FaceLink::boundary(hull_[i].patch));
  } else {
    const int their_corner = static_cast<int>(other & 3);
    link_to(mesh, hull_[i].filled, corner, FaceLink::to(theirs.filled, their_corner));
    if (hull_[i].label == theirs.label) return;
    const auto& v = hull_[i].corners;
    const PatchId patch = patch_of_edge(v[(corner + 1) % 3], v[(corner + 2) % 3]);
    mesh.set_interface_patch(hull_[i].filled, corner, patch);
    mesh.set_interface_patch(theirs.filled, their_corner, patch);
  }
}

}  // namespace lumesh::operators
