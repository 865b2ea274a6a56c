#include "unlayered.hpp"

#include <algorithm>

#include "lumesh/parallel/loops.hpp"

namespace lumesh::layers {
namespace {

bool has(const LayerSurface& surface, std::uint32_t t, std::uint32_t v) {
  const Cell<3>& c = surface.triangles[t];
  return std::ranges::find(c, v) != c.end();
}

/// Whether the layered patches touch themselves at a vertex, as where two ends of an opening meet: a column
/// there would join the two by a line.
bool is_between_fans(const LayerSurface& surface, std::uint32_t v) {
  const auto around = surface.triangles_around.of(v);
  const auto neighbours = surface.neighbours.of(v);
  const auto ends = std::ranges::count_if(neighbours, [&](std::uint32_t w) {
    return std::ranges::count_if(around, [&](std::uint32_t t) { return has(surface, t, w); }) == 1;
  });
  return ends > 2;
}

class TerminationCheck {
 public:
  TerminationCheck(const LayerSurface& surface, const Columns& columns)
      : surface_(surface), columns_(columns), is_unlayered_(surface.triangles.size()) {
    parallel::for_each_index(is_unlayered_.size(), [&](std::size_t t) {
      is_unlayered_[t] = columns.has_layers(surface.triangles[t]) ? 0 : 1;
    });
  }

  [[nodiscard]] bool is_gone(std::uint32_t v) const { return columns_.fraction[v] == 0; }

  /// Whether the layers touch themselves at a vertex without a column.
  [[nodiscard]] bool pinches(std::uint32_t v) const {
    std::size_t layered = 0, changes = 0, layered_ends = 0, ends = 0;
    const auto around = surface_.triangles_around.of(v);
    for (const std::uint32_t t : around) layered += is_unlayered_[t] == 0 ? 1 : 0;
    for (const std::uint32_t w : surface_.neighbours.of(v)) {
      std::size_t shared = 0, unlayered = 0;
      for (const std::uint32_t t : around)
        if (has(surface_, t, w)) ++shared, unlayered += is_unlayered_[t];
      if (shared == 2 && unlayered == 0 && is_gone(w)) return true;  // Along the whole edge.
      changes += shared == 2 && unlayered == 1 ? 1 : 0;
      ends += shared == 1 ? 1 : 0;
      layered_ends += shared == 1 && unlayered == 0 ? 1 : 0;
    }
    if (layered == 0) return false;
    if (ends == 0) return changes != 2;
    return changes + layered_ends > 2;
  }

 private:
  const LayerSurface& surface_;
  const Columns& columns_;
  std::vector<std::uint8_t> is_unlayered_;
};

}  // namespace

bool make_termination_manifold(const LayerSurface& surface, Columns& columns) {
  const std::size_t count = surface.points.size();
  std::vector<std::uint8_t> goes(count);
  parallel::for_each_index(count, [&](std::size_t v) {
    const auto vertex = static_cast<std::uint32_t>(v);
    goes[v] = columns.fraction[v] != 0 && is_between_fans(surface, vertex) ? 1 : 0;
    if (goes[v] != 0) columns.shorten(v, 0, LayerLimit::kNeighbour);
  });
  for (bool changed = std::ranges::find(goes, 1) != goes.end();; changed = true) {
    const TerminationCheck check(surface, columns);
    std::vector<std::uint8_t> pinches(count);
    parallel::for_each_index(count, [&](std::size_t v) {
      const auto vertex = static_cast<std::uint32_t>(v);
      pinches[v] = check.is_gone(vertex) && check.pinches(vertex) ? 1 : 0;
    });
    if (std::ranges::find(pinches, 1) == pinches.end()) return changed;
    parallel::for_each_index(count, [&](std::size_t v) {
      const auto around = surface.neighbours.of(v);
      if (std::ranges::any_of(around, [&](std::uint32_t w) { return pinches[w] != 0; }))
        columns.shorten(v, 0, LayerLimit::kNeighbour);
    });
  }
}

}  // namespace lumesh::layers
