#include <algorithm>
#include <array>
#include <utility>

#include "lumesh/core/assert.hpp"
#include "lumesh/core/uninitialised.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/parallel/key_table.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

/// array[i] = old array[from[i]].
template <class T>
void gather(parallel::StableArray<T>& array, std::size_t slots, const std::vector<std::uint32_t>& from) {
  const std::span<T> entries = array.first(slots);
  UninitialisedVector<T> old(slots);
  parallel::for_each_index(slots, [&](std::size_t i) { old[i] = entries[i]; });
  parallel::for_each_index(from.size(), [&](std::size_t i) { entries[i] = old[from[i]]; });
}

/// place[order[i]] = i, for orders of some of `slots` numbers.
UninitialisedVector<std::uint32_t> places_of(const std::vector<std::uint32_t>& order, std::size_t slots) {
  UninitialisedVector<std::uint32_t> places(slots);
  parallel::for_each_index(order.size(),
                           [&](std::size_t i) { places[order[i]] = static_cast<std::uint32_t>(i); });
  return places;
}

/// The slots of live vertices or tetrahedra, ascending. @param slots  Of all of them.
template <class Id>
std::vector<std::uint32_t> live_slots(const TetMesh& mesh, std::uint32_t slots) {
  return parallel::collect<std::uint32_t>(slots, [&](std::size_t i, std::vector<std::uint32_t>& out) {
    if (const auto slot = static_cast<std::uint32_t>(i); mesh.alive(Id(slot))) out.push_back(slot);
  });
}
std::vector<std::uint32_t> live_vertices(const TetMesh& mesh) {
  return live_slots<VertexId>(mesh, mesh.vertex_slots());
}
std::vector<std::uint32_t> live_tets(const TetMesh& mesh) {
  return live_slots<TetId>(mesh, mesh.tet_slots());
}

/// A tetrahedron by its vertices, ascending, so that it is sorted by the lowest, then the next ones.
struct KeyedTet {
  Cell<4> vertices;
  std::uint32_t slot;
  bool operator<(const KeyedTet& other) const { return vertices < other.vertices; }
};

Cell<4> sorted_vertices(Cell<4> vertices) {
  std::ranges::sort(vertices);
  return vertices;
}

/// True if reordering would leave every number as it is, as where nothing has changed since the last time.
bool is_ordered(const TetMesh& mesh, std::span<const std::uint32_t> order) {
  constexpr std::size_t kBlock = 1 << 14;
  if (!mesh.is_compact()) return false;
  for (std::size_t v = 0; v < order.size(); ++v)
    if (order[v] != v) return false;
  const std::span<const Cell<4>> tets = mesh.tets();
  const int all = parallel::reduce_blocks<int>(
      tets.size(), kBlock, 1,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = std::max<std::size_t>(begin, 1); t < end; ++t)
          if (!(sorted_vertices(tets[t - 1]) < sorted_vertices(tets[t]))) return 0;
        return 1;
      },
      [](int a, int b) { return a * b; });
  return all != 0;
}

/// `slots` sorted by the new numbers of their vertices, lowest first.
std::vector<std::uint32_t> sorted_by_vertices(const TetMesh& mesh, const std::vector<std::uint32_t>& slots,
                                              std::span<const std::uint32_t> new_vertex,
                                              std::size_t vertices) {
  const parallel::KeyTable<KeyedTet> tets(
      slots.size(), vertices,
      [&](std::size_t i, const auto& take) {
        KeyedTet key{mesh.tet(TetId(slots[i])), slots[i]};
        for (std::uint32_t& v : key.vertices) v = new_vertex[v];
        key.vertices = sorted_vertices(key.vertices);
        take(key);
      },
      [](const KeyedTet& tet) { return tet.vertices[0]; });
  std::vector<std::uint32_t> sorted(slots.size());
  parallel::for_each_index(sorted.size(), [&](std::size_t i) { sorted[i] = tets.items()[i].slot; });
  return sorted;
}

}  // namespace

void TetMesh::compact() {
  if (is_compact()) return;
  const auto vertices = live_vertices(*this);
  renumber(vertices, places_of(vertices, vertex_slots()), live_tets(*this));
}

void TetMesh::keep_only(std::span<const std::uint8_t> kept) {
  std::vector<std::uint8_t> used(vertex_slots(), 0);
  parallel::for_each_index(tet_slots(), [&](std::size_t t) {
    if (!alive(TetId(static_cast<std::uint32_t>(t)))) return;
    if (kept[t] == 0) {
      tets_[t].fill(VertexId::kNone);
      tet_stamps_[t] = kDeadStamp;
      return;
    }
    for (const std::uint32_t v : tets_[t]) {
      parallel::raise(used[v]);
      // Any of them will do, and is read after the loop. Test: TetMesh.CompactClosesGapsInTheMiddle.
      parallel::store_relaxed(incident_[v].value, static_cast<std::uint32_t>(t));
    }
  });
  parallel::for_each_index(vertex_slots(), [&](std::size_t v) {
    if (used[v] == 0) dimensions_[v] = VertexDimension::kFreed;
  });
  const auto vertices = live_vertices(*this);
  renumber(vertices, places_of(vertices, vertex_slots()), live_tets(*this));
}

void TetMesh::reorder_along_curve() {
  const std::vector<std::uint32_t> vertices = live_vertices(*this);
  UninitialisedVector<Vec3> live_points(vertices.size());
  parallel::for_each_index(vertices.size(), [&](std::size_t i) { live_points[i] = points_[vertices[i]]; });
  std::vector<std::uint32_t> order = hilbert_order(live_points);
  parallel::for_each_index(order.size(), [&](std::size_t i) { order[i] = vertices[order[i]]; });
  if (is_ordered(*this, order)) {
    free_owners();
  } else {
    const auto new_vertex = places_of(order, vertex_slots());
    renumber(order, new_vertex, sorted_by_vertices(*this, live_tets(*this), new_vertex, order.size()));
  }
  parallel::for_each_index(vertex_slots(), [&](std::size_t v) { vertex_stamps_[v] = 0; });
  parallel::for_each_index(tet_slots(), [&](std::size_t t) { tet_stamps_[t] = 0; });
}

void TetMesh::normalise() {
  LUMESH_ASSERT(is_compact());
  // places[t][i]: which corner of before becomes the i-th.
  UninitialisedVector<std::array<std::uint8_t, 4>> places(tet_slots());
  parallel::for_each_index(tet_slots(), [&](std::size_t t) {
    std::array<std::uint8_t, 4> order = {0, 1, 2, 3};
    int swaps = 0;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 3; j > i; --j)
        if (tets_[t][order[j]] < tets_[t][order[j - 1]]) std::swap(order[j], order[j - 1]), ++swaps;
    if (swaps % 2 == 1) std::swap(order[2], order[3]);
    places[t] = order;
  });
  const auto new_face = [&](FaceLink link) {
    if (link.is_boundary()) return link;
    const auto& order = places[link.tet().value];
    return FaceLink::to(link.tet(), static_cast<int>(std::ranges::find(order, link.face()) - order.begin()));
  };
  parallel::for_each_index(tet_slots(), [&](std::size_t t) {
    const Cell<4> corners = tets_[t];
    const std::array<FaceLink, 4> links = links_[t];
    for (std::size_t i = 0; i < 4; ++i) {
      tets_[t][i] = corners[places[t][i]];
      links_[t][i] = new_face(links[places[t][i]]);
    }
    if (!has_interfaces()) return;
    const std::array<std::uint16_t, 4> patches = interface_patches_[t];
    for (std::size_t i = 0; i < 4; ++i) interface_patches_[t][i] = patches[places[t][i]];
  });
  parallel::for_each_index(vertex_slots(), [&](std::size_t v) { incident_[v] = TetId(); });
  parallel::for_each_index(tet_slots(), [&](std::size_t t) {
    for (const std::uint32_t v : tets_[t])
      parallel::lower_to(incident_[v].value, static_cast<std::uint32_t>(t));
  });
}

/// Puts the live slots in this order. @param new_vertex  Of each old one.
void TetMesh::renumber(const std::vector<std::uint32_t>& vertices, std::span<const std::uint32_t> new_vertex,
                       const std::vector<std::uint32_t>& tets) {
  const auto new_tet = places_of(tets, tet_slots());
  const std::size_t vertex_count = vertices.size(), tet_count = tets.size();
  const auto gather_vertices = [&](auto&... arrays) { (gather(arrays, vertex_slots(), vertices), ...); };
  const auto gather_tets = [&](auto&... arrays) { (gather(arrays, tet_slots(), tets), ...); };
  gather_vertices(points_, incident_, dimensions_, vertex_stamps_);
  gather_tets(tets_, links_, labels_, tet_stamps_);
  if (has_metric()) {
    gather_vertices(metric_, log_metric_, metric_hints_, change_epochs_);
    gather_tets(qualities_, trial_epochs_);
  }
  if (has_interfaces()) gather_tets(interface_patches_);
  parallel::for_each_index(vertex_count, [&](std::size_t v) {
    if (incident_[v].valid()) incident_[v] = TetId(new_tet[incident_[v].value]);
  });
  parallel::for_each_index(tet_count, [&](std::size_t t) {
    for (std::uint32_t& v : tets_[t]) v = new_vertex[v];
    for (FaceLink& link : links_[t])
      if (!link.is_boundary()) link = FaceLink::to(TetId(new_tet[link.tet().value]), link.face());
  });
  vertex_pool_ = parallel::SlotPool(static_cast<std::uint32_t>(vertex_count), 1, 1);
  tet_pool_ = parallel::SlotPool(static_cast<std::uint32_t>(tet_count), 1, 1);
  free_owners();
  points_.shrink(vertex_count);
  tets_.shrink(tet_count);
  links_.shrink(tet_count);
}

/// A compact mesh with one owner, and nobody who holds a vertex.
void TetMesh::free_owners() {
  vertex_pool_ = parallel::SlotPool(vertex_pool_.live(), 1, 1);
  tet_pool_ = parallel::SlotPool(tet_pool_.live(), 1, 1);
  parallel::for_each_index(vertex_slots(), [&](std::size_t v) { lock_words_[v] = 0; });
}

}  // namespace lumesh
