#pragma once
/// @file The tetrahedral mesh that every kernel stage works on.
///
/// Structure of arrays with 32-bit ids, growing without moving (parallel/stable_array.hpp), so that
/// references and spans stay good while other threads add elements. Bytes per element:
///   tetrahedron  40: vertices 16, face links 16, label 4, stamp 4; + 8 where interfaces between labels exist
///   vertex       37: position 24, incident tetrahedron 4, lock word 4, stamp 4, dimension 1
///   with a metric: + 104 per vertex (metric, its logarithm, hint, epoch) and 8 per tetrahedron (quality,
///   epoch)
/// so about 46 bytes per tetrahedron of a one-label mesh (5.8 tetrahedra per vertex).
///
/// Faces: face f of a tetrahedron is opposite its vertex f, with the corners kTetFaces[f]
/// (mixed_mesh.hpp). Its link word is either the neighbour, packed as (tetrahedron << 2 | face), or
/// a boundary word that carries the patch. The 2^20 highest words are boundary words: a range test costs as
/// much as a tag bit and leaves ids up to 1.07e9. A face between two labels needs both its neighbours and a
/// patch. Its patch stands in an array parallel to the links (16 bits per face, held by both sides), made
/// when the first interface appears: a one-label mesh pays nothing, an access is one load guarded by the same
/// locks as the link, and several patches between the same labels are possible, which a table by label pair
/// would not allow; a hash table would need locks of its own.
///
/// Slots freed stay in the arrays, marked dead, until compact(). Loops over slots test alive(); where
/// compact() is known to have run (after build()) the spans hold live elements only.

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/parallel/relaxed.hpp"
#include "lumesh/parallel/stable_array.hpp"

namespace lumesh {

/// The other side of a face: a face of the neighbour, or the outside with a patch.
class FaceLink {
 public:
  constexpr FaceLink() = default;
  [[nodiscard]] static constexpr FaceLink to(TetId tet, int face) {
    return FaceLink(tet.value << 2 | static_cast<std::uint32_t>(face));
  }
  [[nodiscard]] static constexpr FaceLink boundary(PatchId patch) {
    return FaceLink(kFirstBoundary + patch.value);
  }

  [[nodiscard]] constexpr bool is_boundary() const { return word_ >= kFirstBoundary; }
  /// tet() and face() unless is_boundary(), patch() if so.
  [[nodiscard]] constexpr TetId tet() const { return TetId(word_ >> 2); }
  [[nodiscard]] constexpr int face() const { return static_cast<int>(word_ & 3u); }
  [[nodiscard]] constexpr PatchId patch() const { return PatchId(word_ - kFirstBoundary); }
  constexpr bool operator==(const FaceLink&) const = default;

  static constexpr std::uint32_t kFirstBoundary = 0xFFF00000u;
  static constexpr std::uint32_t kNoPatch = 0xFFFFu;  // Patches are below it.

 private:
  constexpr explicit FaceLink(std::uint32_t word) : word_(word) {}
  std::uint32_t word_ = kFirstBoundary + kNoPatch;
};

/// On what a vertex lies; it may move freely only within that.
enum class VertexDimension : std::uint8_t {
  kCorner = 0,
  kCurve = 1,
  kSurface = 2,
  kVolume = 3,
  kFreed = 255
};

/// The faces that carry a patch, each once. They point out of the tetrahedron of the patch's first label; on
/// the outside of the mesh, out of the mesh.
struct BoundaryFaces {
  std::vector<Cell<3>> triangles;
  std::vector<std::int32_t> patches;
  std::vector<std::array<TetId, 2>>
      tets;  ///< The one the face points out of, and the other or an invalid id.
};

/// Patches of faces by table: `triangles` in any order and orientation, one patch (index into
/// MeshInfo::patches) each.
struct PatchTable {
  std::span<const Cell<3>> triangles;
  std::span<const std::int32_t> patches;
};

/// Patch of a face between label `inside` and label `outside` (kBackground: nothing there), whose corners
/// point away from `inside`. Interfaces are asked once, from the lower label. Called from several threads.
using PatchChooser = std::function<std::int32_t(Label inside, Label outside, const Cell<3>& corners)>;

/// Threads: const members may run at the same time. Members with an `owner` may run at the same time for
/// different owners. Setters touch one element: the caller sees to it that nobody else does (the lock words
/// are for that). All other members need the mesh alone.
class TetMesh {
 public:
  static constexpr std::uint32_t kMaxTets = FaceLink::kFirstBoundary >> 2;
  static constexpr std::uint32_t kMaxVertices = 1u << 30;
  static constexpr std::uint32_t kMaxPatches = FaceLink::kNoPatch;
  static constexpr std::uint32_t kDeadStamp = ~0u;

  TetMesh();

  /// Builds the mesh with its adjacency, vertex links and vertex dimensions. Ids are the input's order.
  ///
  /// @param points  Finite; each used by a tetrahedron or not.
  /// @param tets    VTK order, positively oriented by the exact predicate.
  /// @param labels  One per tetrahedron, >= 0.
  /// @param patches The patch of every face on the outside or between labels, and of no other face.
  /// @param info    Taken over; patch numbers index info.patches.
  /// @throws Error{kBadInput} naming the first offender if sizes differ, an index is out of range, a
  /// coordinate is not
  ///         finite, a tetrahedron is flat or inverted, a face has more than two tetrahedra or two on the
  ///         same side, or a patch is missing, contradictory or out of place. Error{kMemory} if storage
  ///         cannot be had.
  /// Parallel inside; the same result for every thread count. Cost: O(n), about 0.3 s per million tetrahedra
  /// on two cores.
  [[nodiscard]] static TetMesh build(std::span<const Vec3> points, std::span<const Cell<4>> tets,
                                     std::span<const Label> labels, const PatchTable& patches, MeshInfo info);
  /// A mesh as above, with the patches chosen by a function.
  [[nodiscard]] static TetMesh build(std::span<const Vec3> points, std::span<const Cell<4>> tets,
                                     std::span<const Label> labels, const PatchChooser& patches,
                                     MeshInfo info);
  /// A mesh as above, with one patch per pair of labels that meet: "wall" (several labels: "wall_L"),
  /// "interface_A_B". They replace info.patches.
  [[nodiscard]] static TetMesh build(std::span<const Vec3> points, std::span<const Cell<4>> tets,
                                     std::span<const Label> labels, MeshInfo info = {});
  /// From a view of tetrahedra only; patches from its triangles, or by labels if it has none.
  /// @throws as above, and Error{kBadInput} if the view has cells of other shapes.
  [[nodiscard]] static TetMesh build(const MeshView& view);

  // --- Sizes ---
  /// Ids are below; some may be dead.
  [[nodiscard]] std::uint32_t vertex_slots() const { return vertex_pool_.end(); }
  [[nodiscard]] std::uint32_t tet_slots() const { return tet_pool_.end(); }
  [[nodiscard]] std::uint32_t vertex_count() const { return vertex_pool_.live(); }  ///< Live ones.
  [[nodiscard]] std::uint32_t tet_count() const { return tet_pool_.live(); }
  [[nodiscard]] bool is_compact() const {
    return vertex_count() == vertex_slots() && tet_count() == tet_slots();
  }
  [[nodiscard]] bool alive(VertexId v) const { return dimensions_[v.value] != VertexDimension::kFreed; }
  [[nodiscard]] bool alive(TetId t) const { return tets_[t.value][0] != VertexId::kNone; }

  // --- Vertices ---
  [[nodiscard]] const Vec3& point(VertexId v) const { return points_[v.value]; }
  void set_point(VertexId v, const Vec3& point) { points_[v.value] = point; }
  /// Invalid if v is unused.
  [[nodiscard]] TetId incident_tet(VertexId v) const { return incident_[v.value]; }
  void set_incident_tet(VertexId v, TetId t) { incident_[v.value] = t; }
  [[nodiscard]] VertexDimension dimension(VertexId v) const { return dimensions_[v.value]; }
  void set_dimension(VertexId v, VertexDimension dimension) { dimensions_[v.value] = dimension; }
  /// Derives the dimensions of all vertices from the faces that carry patches, each once: patches meet in
  /// curves, curves end or meet in corners. build() has done so.
  void classify_vertices(const PatchTable& faces);
  /// Numbers that an execution gives to what it makes; kDeadStamp for freed slots. Stamps may be read by
  /// threads that hold nothing: a stamp says by itself whether an element is still the one that was meant.
  [[nodiscard]] std::uint32_t stamp(VertexId v) const {
    return parallel::load_relaxed(vertex_stamps_[v.value]);
  }
  void set_stamp(VertexId v, std::uint32_t stamp) { parallel::store_relaxed(vertex_stamps_[v.value], stamp); }
  /// The word of an execution: in the ordered one, the bucket the vertex belongs to; in the speculative one,
  /// who holds it. A new vertex has kNoOwner, until its maker gives it another.
  [[nodiscard]] std::uint32_t& lock_word(VertexId v) { return lock_words_[v.value]; }
  static constexpr std::uint32_t kNoOwner = ~0u;

  /// Room for the metric of every vertex and its logarithm, and the quality of every tetrahedron: what
  /// adaptation works with. All zero at first.
  void enable_metric();
  [[nodiscard]] bool has_metric() const { return metric_.reserved(); }
  /// Metric in 1/mm^2 and its matrix logarithm. Only if has_metric().
  [[nodiscard]] const SymTensor& metric(VertexId v) const { return metric_[v.value]; }
  [[nodiscard]] const SymTensor& log_metric(VertexId v) const { return log_metric_[v.value]; }
  void set_metric(VertexId v, const SymTensor& metric, const SymTensor& log_metric) {
    metric_[v.value] = metric;
    log_metric_[v.value] = log_metric;
  }
  /// The tetrahedron of its metric's background in which a vertex was last found; not checked.
  [[nodiscard]] TetId metric_hint(VertexId v) const { return metric_hints_[v.value]; }
  void set_metric_hint(VertexId v, TetId hint) { metric_hints_[v.value] = hint; }
  /// When something around v changed last, and when operators last failed on t, in epochs that an
  /// execution counts; 0: never. Only if has_metric().
  [[nodiscard]] std::uint32_t change_epoch(VertexId v) const { return change_epochs_[v.value]; }
  void set_change_epoch(VertexId v, std::uint32_t epoch) { change_epochs_[v.value] = epoch; }
  [[nodiscard]] std::uint32_t trial_epoch(TetId t) const { return trial_epochs_[t.value]; }
  void set_trial_epoch(TetId t, std::uint32_t epoch) { trial_epochs_[t.value] = epoch; }

  // --- Tetrahedra ---
  [[nodiscard]] const Cell<4>& tet(TetId t) const { return tets_[t.value]; }
  [[nodiscard]] VertexId vertex(TetId t, int i) const { return VertexId(tets_[t.value][i]); }
  [[nodiscard]] const Vec3& corner(TetId t, int i) const { return points_[tets_[t.value][i]]; }
  [[nodiscard]] Vec3 centroid(TetId t) const {
    return 0.25 * (corner(t, 0) + corner(t, 1) + corner(t, 2) + corner(t, 3));
  }
  void set_tet(TetId t, const Cell<4>& vertices) {
    for (int i = 0; i < 4; ++i) parallel::store_relaxed(tets_[t.value][i], vertices[i]);
  }
  /// The vertices of t for a thread that holds nothing: some may be those of another tetrahedron, or
  /// VertexId::kNone. Only the stamp tells, once the thread holds all that it read.
  [[nodiscard]] Cell<4> unheld_tet(TetId t) const {
    Cell<4> v{};
    for (int i = 0; i < 4; ++i) v[i] = parallel::load_relaxed(tets_[t.value][i]);
    return v;
  }
  [[nodiscard]] Label label(TetId t) const { return labels_[t.value]; }
  void set_label(TetId t, Label label) { labels_[t.value] = label; }
  [[nodiscard]] std::uint32_t stamp(TetId t) const { return parallel::load_relaxed(tet_stamps_[t.value]); }
  void set_stamp(TetId t, std::uint32_t stamp) { parallel::store_relaxed(tet_stamps_[t.value], stamp); }
  /// Mean ratio of t in the metric, as whoever changed t last measured it. Only if has_metric().
  [[nodiscard]] float quality(TetId t) const { return qualities_[t.value]; }
  void set_quality(TetId t, float quality) { qualities_[t.value] = quality; }
  /// Index (0 to 3) of vertex v in t, or -1.
  [[nodiscard]] int index_of(TetId t, VertexId v) const {
    const Cell<4>& corners = tets_[t.value];
    for (int i = 0; i < 4; ++i)
      if (corners[i] == v.value) return i;
    return -1;
  }

  // --- Faces ---
  [[nodiscard]] FaceLink link(TetId t, int face) const { return links_[t.value][face]; }
  void set_link(TetId t, int face, FaceLink link) { links_[t.value][face] = link; }
  /// Corners of a face, seen anticlockwise from outside t.
  [[nodiscard]] Cell<3> face_corners(TetId t, int face) const {
    const Cell<4>& v = tets_[t.value];
    const auto& [i, j, k] = kTetFaces[face];
    return {v[i], v[j], v[k]};
  }
  /// Patch of a face on the outside or between labels; invalid for any other face.
  [[nodiscard]] PatchId patch(TetId t, int face) const {
    const FaceLink link = links_[t.value][face];
    return link.is_boundary() ? link.patch() : interface_patch(t, face);
  }
  /// Patch of a face that has a neighbour; invalid if it has none.
  [[nodiscard]] PatchId interface_patch(TetId t, int face) const {
    if (!interface_patches_.reserved()) return {};
    const std::uint16_t plus_one = interface_patches_[t.value][face];
    return plus_one == 0 ? PatchId() : PatchId(plus_one - 1u);
  }
  /// Sets one side; the neighbour's side must be set alike. An invalid id takes the patch away.
  void set_interface_patch(TetId t, int face, PatchId patch);
  [[nodiscard]] bool has_interfaces() const { return interface_patches_.reserved(); }
  void enable_interfaces();  ///< Before the first set_interface_patch(); needs the mesh alone.

  // --- Growing and shrinking ---
  /// Prepares for `owners` concurrent owners, whose blocks have `block` slots.
  void set_owners(int owners, std::uint32_t block = 1024);
  /// A new vertex in the volume, without incident tetrahedron. @throws Error{kMemory}.
  VertexId add_vertex(const Vec3& point, int owner = 0, std::uint32_t stamp = 0);
  /// A new tetrahedron whose faces are boundary without patch. Links stay the caller's duty. @throws
  /// Error{kMemory}.
  TetId add_tet(const Cell<4>& vertices, Label label, int owner = 0, std::uint32_t stamp = 0);
  void free_vertex(VertexId v, int owner = 0);
  void free_tet(TetId t, int owner = 0);
  /// Frees all tetrahedra but those named by 1 in `kept` (one byte per slot), and vertices that are left
  /// without; the caller has seen to the links of what stays. What else it leaves is compact(). Parallel
  /// inside.
  void keep_only(std::span<const std::uint8_t> kept);
  /// Closes the gaps of dead slots; the order of the live ones stays. Invalidates ids and owners. Parallel
  /// inside. Cost: O(slots).
  void compact();
  /// compact(), and numbers vertices along the Hilbert curve and tetrahedra by their lowest vertex, so that
  /// what is near in space is near in memory. The numbers before do not matter: ties go by coordinates, and
  /// by the other vertices. Stamps become 0. Owners as after compact(). Parallel inside; the same result for
  /// every thread count. Cost: about 0.1 s per million tetrahedra.
  void reorder_along_curve();
  /// Lists the corners of every tetrahedron in a fixed order (the lowest first, but for one swap where
  /// orientation wants it), and gives every vertex the lowest tetrahedron around it: what is left does not
  /// depend on how the mesh came about, but on numbers alone. Needs is_compact(). Parallel inside.
  void normalise();

  // --- The whole mesh ---
  [[nodiscard]] std::span<const Vec3> points() const { return points_.first(vertex_slots()); }
  [[nodiscard]] std::span<const Cell<4>> tets() const { return tets_.first(tet_slots()); }
  [[nodiscard]] std::span<const Label> labels() const { return labels_.first(tet_slots()); }
  /// Parallel inside; in the order of tetrahedra and faces.
  [[nodiscard]] BoundaryFaces boundary_faces() const;
  /// A view without copies, and without boundary triangles. Needs is_compact(). It ends with the mesh or its
  /// next change.
  [[nodiscard]] MeshView view() const;
  /// A view with the triangles of `faces`, which must live as long as the view.
  [[nodiscard]] MeshView view(const BoundaryFaces& faces) const;

  [[nodiscard]] const MeshInfo& info() const { return info_; }
  [[nodiscard]] MeshInfo& info() { return info_; }

 private:
  struct Assembly;  // Steps of build().

  void renumber(const std::vector<std::uint32_t>& vertices, std::span<const std::uint32_t> new_vertex,
                const std::vector<std::uint32_t>& tets);
  void free_owners();
  void commit_vertices(std::uint32_t count);
  void commit_tets(std::uint32_t count);

  parallel::StableArray<Vec3> points_;
  parallel::StableArray<TetId> incident_;
  parallel::StableArray<std::uint32_t> lock_words_;
  parallel::StableArray<std::uint32_t> vertex_stamps_;
  parallel::StableArray<VertexDimension> dimensions_;
  parallel::StableArray<SymTensor> metric_;      // On demand.
  parallel::StableArray<SymTensor> log_metric_;  // With metric_, as the next one.
  parallel::StableArray<TetId> metric_hints_;
  parallel::StableArray<std::uint32_t> change_epochs_;

  parallel::StableArray<Cell<4>> tets_;
  parallel::StableArray<std::array<FaceLink, 4>> links_;
  parallel::StableArray<Label> labels_;
  parallel::StableArray<std::uint32_t> tet_stamps_;
  parallel::StableArray<float> qualities_;  // With metric_, as the next one.
  parallel::StableArray<std::uint32_t> trial_epochs_;
  parallel::StableArray<std::array<std::uint16_t, 4>> interface_patches_;  // Patch + 1, 0: none. On demand.

  parallel::SlotPool vertex_pool_;
  parallel::SlotPool tet_pool_;
  MeshInfo info_;
};

}  // namespace lumesh
