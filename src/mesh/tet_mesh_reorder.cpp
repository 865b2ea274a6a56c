#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

/// array[new_place[i]] = old array[i] for all i < new_place.size().
template <class T>
void permute(parallel::StableArray<T>& array, const std::vector<std::uint32_t>& new_place) {
  const std::span<T> entries = array.first(new_place.size());
  UninitialisedVector<T> old(entries.size());
  parallel::for_each_index(entries.size(), [&](std::size_t i) { old[i] = entries[i]; });
  parallel::for_each_index(entries.size(), [&](std::size_t i) { entries[new_place[i]] = old[i]; });
}

/// The place of each tetrahedron when they are sorted by their vertices, lowest first.
std::vector<std::uint32_t> places_by_vertices(std::span<const Cell<4>> tets, std::size_t vertices) {
  // The three other vertices, ascending.
  const auto others = [&](std::uint32_t t, std::uint32_t lowest_vertex) {
    std::array<std::uint32_t, 3> v{};
    int n = 0;
    for (const std::uint32_t w : tets[t])
      if (w != lowest_vertex) v[n++] = w;
    if (v[1] < v[0]) std::swap(v[0], v[1]);
    if (v[2] < v[1]) std::swap(v[1], v[2]);
    if (v[1] < v[0]) std::swap(v[0], v[1]);
    return v;
  };
  std::vector<std::uint32_t> begin(vertices + 1, 0), sorted(tets.size()), place(tets.size());
  UninitialisedVector<std::uint32_t> lowest(tets.size());
  parallel::for_each_index(
      tets.size(), [&](std::size_t t) { lowest[t] = *std::min_element(tets[t].begin(), tets[t].end()); });
  for (const std::uint32_t v : lowest) ++begin[v + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (std::uint32_t t = 0; t < tets.size(); ++t) sorted[next[lowest[t]]++] = t;
  using Keyed = std::pair<std::array<std::uint32_t, 3>, std::uint32_t>;
  parallel::for_each_block(vertices, 1024, [&](std::size_t, std::size_t first, std::size_t last) {
    std::vector<Keyed> group;
    for (std::size_t v = first; v < last; ++v) {
      group.clear();
      for (std::uint32_t i = begin[v]; i < begin[v + 1]; ++i)
        group.push_back({others(sorted[i], static_cast<std::uint32_t>(v)), sorted[i]});
      std::sort(group.begin(), group.end());
      for (std::size_t i = 0; i < group.size(); ++i)
        place[group[i].second] = begin[v] + static_cast<std::uint32_t>(i);
    }
  });
  return place;
}

}  // namespace

void TetMesh::reorder_along_curve() {
  compact();
  const std::vector<std::uint32_t> order = hilbert_order(points());
  std::vector<std::uint32_t> new_vertex(order.size());
  parallel::for_each_index(order.size(),
                           [&](std::size_t i) { new_vertex[order[i]] = static_cast<std::uint32_t>(i); });
  permute(points_, new_vertex);
  permute(incident_, new_vertex);
  permute(dimensions_, new_vertex);
  if (has_metric()) {
    permute(metric_, new_vertex);
    permute(log_metric_, new_vertex);
    permute(metric_hints_, new_vertex);
    permute(change_epochs_, new_vertex);
  }
  parallel::for_each_index(tet_count(), [&](std::size_t t) {
    for (std::uint32_t& v : tets_[t]) v = new_vertex[v];
  });

  const std::vector<std::uint32_t> new_tet = places_by_vertices(tets(), order.size());
  parallel::for_each_index(tet_count(), [&](std::size_t t) {
    for (FaceLink& link : links_[t])
      if (!link.is_boundary()) link = FaceLink::to(TetId(new_tet[link.tet().value]), link.face());
  });
  parallel::for_each_index(order.size(), [&](std::size_t v) {
    if (incident_[v].valid()) incident_[v] = TetId(new_tet[incident_[v].value]);
  });
  permute(tets_, new_tet);
  permute(links_, new_tet);
  permute(labels_, new_tet);
  if (has_metric()) {
    permute(qualities_, new_tet);
    permute(trial_epochs_, new_tet);
  }
  if (has_interfaces()) permute(interface_patches_, new_tet);
  parallel::for_each_index(order.size(), [&](std::size_t v) { vertex_stamps_[v] = 0; });
  parallel::for_each_index(tet_count(), [&](std::size_t t) { tet_stamps_[t] = 0; });
}

}  // namespace lumesh
