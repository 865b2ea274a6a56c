#include "labelled_lattice.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/parallel/adjacency.hpp"
#include "lumesh/parallel/key_set.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

namespace {

using bcc::Corners;
using bcc::Key;

/// Majority of the centroid (which breaks ties) and the points halfway to the corners.
Material material_of(const Corners& t, const LatticeFrame& frame, const ImageDomain& domain) {
  std::array<Vec3, 4> p;
  for (std::size_t i = 0; i < 4; ++i) p[i] = frame.position_mm(t[i]);
  const Vec3 centre = 0.25 * (p[0] + p[1] + p[2] + p[3]);
  const auto [at_centre, clearance_mm] = domain.surroundings(centre);
  double reach2 = 0;
  for (const Vec3& corner : p) reach2 = std::max(reach2, 0.25 * (corner - centre).squaredNorm());
  if (clearance_mm * clearance_mm > 1.2 * reach2) return at_centre;
  std::array<Material, 4> seen;
  for (std::size_t i = 0; i < 4; ++i) seen[i] = domain.material_at(0.5 * (centre + p[i]));
  Material best = at_centre;
  std::ptrdiff_t most = 1 + std::ranges::count(seen, at_centre);
  for (const Material m : seen) {
    const std::ptrdiff_t votes = std::ranges::count(seen, m);
    if (m != at_centre && (votes > most || (votes == most && best != at_centre && m < best))) {
      most = votes;
      best = m;
    }
  }
  return best;
}

/// Keeps the object's tetrahedra and those that share a vertex with one.
void keep_object_ring(bcc::Lattice& lattice, UninitialisedVector<Material>& materials,
                      const ImageDomain& domain) {
  parallel::KeySet object;
  object.insert_all(lattice.size(), lattice.size() / 8, [&](std::size_t i, auto& put) {
    if (!domain.is_meshed(materials[i])) return;
    for (const Key key : lattice[i]) put(key);
  });
  const auto kept = parallel::collect_blocks<std::uint32_t>(
      lattice.size(), 4096, [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& out) {
        parallel::KeySet::Lookup lookup(object);
        for (std::size_t i = begin; i < end; ++i) {
          const bool near = std::ranges::any_of(lattice[i], [&](Key key) { return lookup.contains(key); });
          if (near) out.push_back(static_cast<std::uint32_t>(i));
        }
      });
  bcc::Lattice lattice_kept(kept.size());
  UninitialisedVector<Material> materials_kept(kept.size());
  parallel::for_each_index(kept.size(), [&](std::size_t i) {
    lattice_kept[i] = lattice[kept[i]];
    materials_kept[i] = materials[kept[i]];
  });
  lattice = std::move(lattice_kept);
  materials = std::move(materials_kept);
}

/// Vertices along the Morton curve, and the number of each.
class VertexNumbers {
 public:
  explicit VertexNumbers(const bcc::Lattice& lattice) {
    // There are about five tetrahedra for each vertex.
    set_.insert_all(lattice.size(), lattice.size() / 4, [&](std::size_t i, auto& put) {
      for (const Key key : lattice[i]) put(bcc::morton(key));
    });
    codes_ = set_.sorted_keys();
    number_.resize(set_.slot_count());
    parallel::for_each_index(
        codes_.size(), [&](std::size_t i) { number_[set_.find(codes_[i])] = static_cast<std::uint32_t>(i); });
  }
  /// The tetrahedra with their corners' numbers.
  [[nodiscard]] UninitialisedVector<Cell<4>> numbered(const bcc::Lattice& lattice) const {
    UninitialisedVector<Cell<4>> tets(lattice.size());
    parallel::for_each_block(lattice.size(), 4096, [&](std::size_t, std::size_t begin, std::size_t end) {
      parallel::KeySet::Lookup lookup(set_);
      for (std::size_t t = begin; t < end; ++t) {
        for (std::size_t c = 0; c < 4; ++c) tets[t][c] = number_[lookup.find(bcc::morton(lattice[t][c]))];
      }
    });
    return tets;
  }
  [[nodiscard]] std::size_t size() const { return codes_.size(); }
  [[nodiscard]] Key key(std::size_t number) const { return bcc::from_morton(codes_[number]); }

 private:
  parallel::KeySet set_;
  std::vector<Key> codes_;
  std::vector<std::uint32_t> number_;
};

/// The tetrahedra by their ascending corners, so that their order says nothing of how the lattice was made.
UninitialisedVector<std::uint32_t> order_by_corners(const UninitialisedVector<Cell<4>>& tets,
                                                    std::size_t vertex_count) {
  UninitialisedVector<Cell<4>> ascending(tets.size());
  parallel::for_each_index(tets.size(), [&](std::size_t t) {
    ascending[t] = tets[t];
    std::ranges::sort(ascending[t]);
  });
  parallel::Adjacency by_lowest = parallel::group_by_owner(
      tets.size(), vertex_count, [&](std::size_t t) { return std::span(ascending[t].data(), 1); });
  parallel::for_each_index(by_lowest.size(), [&](std::size_t v) {
    std::sort(by_lowest.items.begin() + by_lowest.starts[v],
              by_lowest.items.begin() + by_lowest.starts[v + 1],
              [&](std::uint32_t a, std::uint32_t b) { return ascending[a] < ascending[b]; });
  });
  return std::move(by_lowest.items);
}

}  // namespace

fitting::WorkMesh make_work_mesh(bcc::Lattice lattice, const LatticeFrame& frame, const ImageDomain& domain) {
  UninitialisedVector<Material> materials(lattice.size());
  parallel::for_each_index(lattice.size(), 256,
                           [&](std::size_t i) { materials[i] = material_of(lattice[i], frame, domain); });
  keep_object_ring(lattice, materials, domain);
  const VertexNumbers vertices(lattice);

  fitting::WorkMesh mesh;
  mesh.positions.resize(vertices.size());
  parallel::for_each_index(vertices.size(),
                           [&](std::size_t v) { mesh.positions[v] = frame.position_mm(vertices.key(v)); });
  const UninitialisedVector<Cell<4>> tets = vertices.numbered(lattice);
  const UninitialisedVector<std::uint32_t> order = order_by_corners(tets, vertices.size());
  mesh.tets.resize(tets.size());
  mesh.materials.resize(tets.size());
  parallel::for_each_index(tets.size(), [&](std::size_t i) {
    mesh.tets[i] = tets[order[i]];
    mesh.materials[i] = materials[order[i]];
  });

  fitting::build_stars(mesh);
  fitting::build_neighbours(mesh);
  return mesh;
}

}  // namespace lumesh
