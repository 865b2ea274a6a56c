#include "lumesh/mesh/label_shapes.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/relaxed.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh {
namespace {

constexpr std::size_t kTetsPerBlock = 8192;

/// Sets of numbers that many threads unite: each points to a smaller one of its set, the smallest to itself.
class SharedSets {
 public:
  explicit SharedSets(std::size_t count) : parents_(count) {
    parallel::for_each_index(count, [&](std::size_t i) { parents_[i] = static_cast<std::uint32_t>(i); });
  }
  [[nodiscard]] std::uint32_t smallest_of(std::uint32_t i) {
    for (std::uint32_t parent = of(i); parent != i; parent = of(i)) {
      // Halves the way for those who come later; a smaller parent may be there by now.
      parallel::lower_to(parents_[i], of(parent));
      i = parent;
    }
    return i;
  }
  void unite(std::uint32_t i, std::uint32_t j) {
    for (;;) {
      i = smallest_of(i);
      j = smallest_of(j);
      if (i == j) return;
      if (i < j) std::swap(i, j);
      // Only the smallest of a set is given another set: nothing is torn apart.
      if (parallel::replace_relaxed(parents_[i], i, j)) return;
    }
  }

 private:
  [[nodiscard]] std::uint32_t of(std::uint32_t i) const { return parallel::load_relaxed(parents_[i]); }
  std::vector<std::uint32_t> parents_;
};

/// A corner of a face of a label's boundary.
struct Corner {
  Label label;
  std::uint32_t vertex;
  friend auto operator<=>(const Corner&, const Corner&) = default;
};

/// Corners of each boundary face in a row.
std::vector<Corner> boundary_corners(const TetMesh& mesh) {
  return parallel::collect<Corner>(mesh.tet_count(), kTetsPerBlock, [&](std::size_t i, auto& out) {
    const TetId t(static_cast<std::uint32_t>(i));
    for (int f = 0; f < 4; ++f) {
      const FaceLink behind = mesh.link(t, f);
      if (!behind.is_boundary() && mesh.label(behind.tet()) == mesh.label(t)) continue;
      for (const std::uint32_t v : mesh.face_corners(t, f)) out.push_back({mesh.label(t), v});
    }
  });
}

/// One vertex of each part of the boundaries that edges or vertices join.
/// @param vertices  Ascending, each once.
std::vector<Corner> surfaces(std::span<const Corner> corners, std::span<const Corner> vertices) {
  SharedSets sets(vertices.size());
  const auto place_of = [&](std::size_t corner) { return rank_in(vertices, corners[corner]); };
  parallel::for_each_index(corners.size() / 3, [&](std::size_t face) {
    const std::uint32_t first = place_of(3 * face);
    sets.unite(first, place_of(3 * face + 1));
    sets.unite(first, place_of(3 * face + 2));
  });
  std::vector<Corner> firsts;
  for (std::uint32_t v = 0; v < vertices.size(); ++v)
    if (sets.smallest_of(v) == v) firsts.push_back(vertices[v]);
  return firsts;
}

/// One tetrahedron of each piece.
std::vector<TetId> pieces(const TetMesh& mesh) {
  SharedSets sets(mesh.tet_count());
  parallel::for_each_index(mesh.tet_count(), [&](std::size_t i) {
    const TetId t(static_cast<std::uint32_t>(i));
    for (int f = 0; f < 4; ++f) {
      const FaceLink behind = mesh.link(t, f);
      if (!behind.is_boundary() && behind.tet() < t && mesh.label(behind.tet()) == mesh.label(t))
        sets.unite(t.value, behind.tet().value);
    }
  });
  return parallel::collect<TetId>(mesh.tet_count(), kTetsPerBlock, [&](std::size_t i, auto& out) {
    const auto number = static_cast<std::uint32_t>(i);
    if (sets.smallest_of(number) == number) out.emplace_back(number);
  });
}

}  // namespace

std::vector<LabelShape> label_shapes(const TetMesh& mesh) {
  std::vector<LabelShape> shapes;
  const auto shape_of = [&](Label label) -> LabelShape& {
    const auto at = std::ranges::lower_bound(shapes, label, {}, &LabelShape::label);
    return at != shapes.end() && at->label == label ? *at : *shapes.insert(at, {label});
  };
  for (const TetId t : pieces(mesh)) ++shape_of(mesh.label(t)).components;
  const std::vector<Corner> corners = boundary_corners(mesh);
  std::vector<Corner> vertices = corners;
  parallel::sort_unique(vertices);
  for (const Corner& first : surfaces(corners, vertices)) ++shape_of(first.label).surfaces;
  for (const Corner& vertex : vertices) shape_of(vertex.label).euler += 2;
  for (std::size_t face = 0; 3 * face < corners.size(); ++face) --shape_of(corners[3 * face].label).euler;
  for (LabelShape& shape : shapes)
    shape.euler /= 4;  // Each edge is one of two faces, and V - F / 2 twice that of the solid.
  return shapes;
}

std::uint32_t count_pieces(const TetMesh& mesh) {
  std::vector<std::uint8_t> seen(mesh.tet_count(), 0);
  std::vector<TetId> open;
  std::uint32_t pieces = 0;
  const auto reach = [&](TetId t) {
    if (std::exchange(seen[t.value], std::uint8_t{1}) == 0) open.push_back(t);
  };
  for (std::uint32_t first = 0; first < mesh.tet_count(); ++first) {
    if (seen[first] == 0) ++pieces;
    for (reach(TetId(first)); !open.empty();) {
      const TetId t = open.back();
      open.pop_back();
      for (int f = 0; f < 4; ++f)
        if (const FaceLink link = mesh.link(t, f); !link.is_boundary()) reach(link.tet());
    }
  }
  return pieces;
}

std::map<Label, double> volumes_of_labels(const TetMesh& mesh) {
  using Volumes = std::map<Label, double>;
  constexpr std::size_t kBlock = 1 << 14;
  return parallel::reduce(
      mesh.tet_count(), kBlock, Volumes(),
      [&](Volumes& volumes, std::size_t i) {
        const TetId t(static_cast<std::uint32_t>(i));
        volumes[mesh.label(t)] +=
            tetrahedron_volume(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3));
      },
      [](Volumes all, const Volumes& some) {
        for (const auto& [label, volume] : some) all[label] += volume;
        return all;
      });
}

double much_of_volume(double voxel_count) {
  constexpr double kLeast = 0.02, kMost = 0.05;
  // Centres within a smooth boundary vary by the square root of 0.085 for each voxel face of it, of which
  // thin vessels have 1.5 per voxel: this is 2.5 standard deviations.
  constexpr double kChance = 0.9;
  return std::clamp(kChance / std::sqrt(voxel_count), kLeast, kMost);
}

std::string volume_text(Label label, double change, std::size_t count) {
  return fmt::format("label {} fills {:.1f} % {} than its voxels", label, 100 * std::abs(change),
                     change < 0 ? "less" : "more") +
         (count > 1 ? fmt::format(", the worst of {} labels with another volume", count) : "");
}

}  // namespace lumesh
