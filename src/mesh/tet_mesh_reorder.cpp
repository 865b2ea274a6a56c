#include <algorithm>
#include <numeric>

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

/// The place of each tetrahedron when they are sorted by their lowest vertex, equal ones by number.
std::vector<std::uint32_t> places_by_lowest_vertex(std::span<const Cell<4>> tets, std::size_t vertices) {
  const auto lowest = [&](std::size_t t) { return *std::min_element(tets[t].begin(), tets[t].end()); };
  std::vector<std::uint32_t> next(vertices + 1, 0), place(tets.size());
  for (std::size_t t = 0; t < tets.size(); ++t) ++next[lowest(t) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  for (std::size_t t = 0; t < tets.size(); ++t) place[t] = next[lowest(t)]++;
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
  permute(vertex_stamps_, new_vertex);
  permute(dimensions_, new_vertex);
  if (has_metric()) {
    permute(metric_, new_vertex);
    permute(log_metric_, new_vertex);
    permute(metric_hints_, new_vertex);
  }
  parallel::for_each_index(tet_count(), [&](std::size_t t) {
    for (std::uint32_t& v : tets_[t]) v = new_vertex[v];
  });

  const std::vector<std::uint32_t> new_tet = places_by_lowest_vertex(tets(), order.size());
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
  permute(tet_stamps_, new_tet);
  if (has_metric()) permute(qualities_, new_tet);
  if (has_interfaces()) permute(interface_patches_, new_tet);
}

}  // namespace lumesh
