#include "lumesh/mesh/tet_mesh.hpp"

#include <type_traits>

#include "lumesh/core/assert.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

constexpr Cell<4> kDeadTet = {VertexId::kNone, VertexId::kNone, VertexId::kNone, VertexId::kNone};

template <class... Arrays>
void commit_all(std::uint32_t count, Arrays&... arrays) {
  (arrays.commit(count), ...);
}

}  // namespace

TetMesh::TetMesh()
    : points_(kMaxVertices),
      incident_(kMaxVertices),
      lock_words_(kMaxVertices),
      vertex_stamps_(kMaxVertices),
      dimensions_(kMaxVertices),
      tets_(kMaxTets),
      links_(kMaxTets),
      labels_(kMaxTets),
      tet_stamps_(kMaxTets),
      vertex_pool_(0, 1, 1),
      tet_pool_(0, 1, 1) {}

void TetMesh::commit_vertices(std::uint32_t count) {
  if (count > kMaxVertices)
    throw Error(ErrorKind::kMemory, "mesh: more than 2^30 vertices; choose a coarser mesh");
  commit_all(count, points_, incident_, lock_words_, vertex_stamps_, dimensions_);
  if (has_metric()) commit_all(count, metric_, log_metric_, metric_hints_, change_epochs_);
}

void TetMesh::commit_tets(std::uint32_t count) {
  if (count > kMaxTets)
    throw Error(ErrorKind::kMemory, "mesh: more than 10^9 tetrahedra; choose a coarser mesh");
  commit_all(count, tets_, links_, labels_, tet_stamps_);
  if (has_metric()) commit_all(count, qualities_, trial_epochs_);
  if (has_interfaces()) interface_patches_.commit(count);
}

void TetMesh::enable_metric() {
  if (has_metric()) return;
  const auto reserve = [](std::size_t most, auto&... arrays) {
    ((arrays = std::remove_reference_t<decltype(arrays)>(most)), ...);
  };
  reserve(kMaxVertices, metric_, log_metric_, metric_hints_, change_epochs_);
  reserve(kMaxTets, qualities_, trial_epochs_);
  commit_vertices(vertex_slots());
  commit_tets(tet_slots());
}

void TetMesh::enable_interfaces() {
  if (has_interfaces()) return;
  interface_patches_ = parallel::StableArray<std::array<std::uint16_t, 4>>(kMaxTets);
  interface_patches_.commit(tet_slots());
}

void TetMesh::set_interface_patch(TetId t, int face, PatchId patch) {
  interface_patches_[t.value][face] = patch.valid() ? static_cast<std::uint16_t>(patch.value + 1) : 0;
}

void TetMesh::set_owners(int owners, std::uint32_t block) {
  compact();
  vertex_pool_ = parallel::SlotPool(vertex_slots(), owners, block);
  tet_pool_ = parallel::SlotPool(tet_slots(), owners, block);
}

VertexId TetMesh::add_vertex(const Vec3& point, int owner, std::uint32_t stamp) {
  const std::uint32_t slot = vertex_pool_.take(owner, [this](std::uint32_t begin, std::uint32_t end) {
    commit_vertices(end);
    for (std::uint32_t v = begin; v < end; ++v) dimensions_[v] = VertexDimension::kFreed;
  });
  points_[slot] = point;
  incident_[slot] = TetId();
  // A thread with an old number of the slot may read it: nobody's, before as after. Test: SpeculativeLock.*.
  parallel::store_relaxed(lock_words_[slot], kNoOwner);
  set_stamp(VertexId(slot), stamp);
  dimensions_[slot] = VertexDimension::kVolume;
  if (has_metric()) {
    set_metric(VertexId(slot), {}, {});
    metric_hints_[slot] = TetId(0);
    change_epochs_[slot] = 0;
  }
  return VertexId(slot);
}

TetId TetMesh::add_tet(const Cell<4>& vertices, Label label, int owner, std::uint32_t stamp) {
  const std::uint32_t slot = tet_pool_.take(owner, [this](std::uint32_t begin, std::uint32_t end) {
    commit_tets(end);
    for (std::uint32_t t = begin; t < end; ++t) tets_[t] = kDeadTet;
  });
  set_tet(TetId(slot), vertices);
  links_[slot] = {};
  labels_[slot] = label;
  set_stamp(TetId(slot), stamp);
  if (has_metric()) qualities_[slot] = 0, trial_epochs_[slot] = 0;
  if (has_interfaces()) interface_patches_[slot] = {};
  return TetId(slot);
}

void TetMesh::free_vertex(VertexId v, int owner) {
  LUMESH_DEBUG_ASSERT(alive(v));
  dimensions_[v.value] = VertexDimension::kFreed;
  incident_[v.value] = TetId();
  set_stamp(v, kDeadStamp);
  vertex_pool_.give(owner, v.value);
}

void TetMesh::free_tet(TetId t, int owner) {
  LUMESH_DEBUG_ASSERT(alive(t));
  set_tet(t, kDeadTet);
  set_stamp(t, kDeadStamp);
  tet_pool_.give(owner, t.value);
}

BoundaryFaces TetMesh::boundary_faces() const {
  struct PatchFace {
    Cell<3> corners;
    std::int32_t patch;
    std::array<TetId, 2> tets;
  };
  const auto faces = collect_from_tets<PatchFace>(*this, [&](TetId t, std::vector<PatchFace>& out) {
    for (int f = 0; f < 4; ++f) {
      const FaceLink behind = link(t, f);
      const PatchId on_face = patch(t, f);
      if (behind.is_boundary()) {
        out.push_back({face_corners(t, f), static_cast<std::int32_t>(on_face.value), {t, TetId()}});
      } else if (on_face.valid()) {
        const Label first =
            on_face.value < info_.patches.size() ? info_.patches[on_face.value].labels[0] : kBackground;
        const Label mine = label(t), other = label(behind.tet());
        const bool points_out_of_me = first == mine    ? (other != mine || t < behind.tet())
                                      : first == other ? false
                                                       : t < behind.tet();
        if (points_out_of_me)
          out.push_back({face_corners(t, f), static_cast<std::int32_t>(on_face.value), {t, behind.tet()}});
      }
    }
  });
  BoundaryFaces result{std::vector<Cell<3>>(faces.size()), std::vector<std::int32_t>(faces.size()),
                       std::vector<std::array<TetId, 2>>(faces.size())};
  parallel::for_each_index(faces.size(), [&](std::size_t i) {
    result.triangles[i] = faces[i].corners;
    result.patches[i] = faces[i].patch;
    result.tets[i] = faces[i].tets;
  });
  return result;
}

MeshView TetMesh::view() const {
  LUMESH_ASSERT(is_compact());
  MeshView view;
  view.points = points();
  view.tetrahedra = tets();
  view.tetrahedron_labels = labels();
  view.info = &info_;
  if (has_metric()) view.metric = metric_.first(vertex_slots());
  return view;
}

MeshView TetMesh::view(const BoundaryFaces& faces) const {
  MeshView with_triangles = view();
  with_triangles.triangles = faces.triangles;
  with_triangles.triangle_patches = faces.patches;
  return with_triangles;
}

}  // namespace lumesh
