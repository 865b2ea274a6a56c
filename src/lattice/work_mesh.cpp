#include "work_mesh.hpp"

#include <algorithm>

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
  std::ptrdiff_t most = 1 + std::count(seen.begin(), seen.end(), at_centre);
  for (const Material m : seen) {
    const std::ptrdiff_t votes = std::count(seen.begin(), seen.end(), m);
    if (m != at_centre && (votes > most || (votes == most && best != at_centre && m < best))) {
      most = votes;
      best = m;
    }
  }
  return best;
}

/// Keeps the object's tetrahedra and those that share a vertex with one.
void keep_object_ring(std::vector<Corners>& lattice, std::vector<Material>& materials,
                      const ImageDomain& domain) {
  parallel::KeySet object;
  object.reserve(lattice.size());
  parallel::for_each_index(lattice.size(), [&](std::size_t i) {
    if (!domain.is_meshed(materials[i])) return;
    for (const Key key : lattice[i]) object.insert(key);
  });
  const auto kept = parallel::collect<std::uint32_t>(lattice.size(), [&](std::size_t i, auto& out) {
    const bool near =
        std::any_of(lattice[i].begin(), lattice[i].end(), [&](Key key) { return object.contains(key); });
    if (near) out.push_back(static_cast<std::uint32_t>(i));
  });
  std::vector<Corners> lattice_kept(kept.size());
  std::vector<Material> materials_kept(kept.size());
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
  explicit VertexNumbers(const std::vector<Corners>& lattice) {
    set_.reserve(lattice.size() + 1024);  // about six tetrahedra share a vertex's number
    parallel::for_each_index(lattice.size(), [&](std::size_t i) {
      for (const Key key : lattice[i]) set_.insert(bcc::morton(key));
    });
    codes_ = set_.sorted_keys();
    number_.resize(set_.slot_count());
    parallel::for_each_index(
        codes_.size(), [&](std::size_t i) { number_[set_.find(codes_[i])] = static_cast<std::uint32_t>(i); });
  }
  [[nodiscard]] std::uint32_t number(Key key) const { return number_[set_.find(bcc::morton(key))]; }
  [[nodiscard]] std::size_t size() const { return codes_.size(); }
  [[nodiscard]] Key key(std::size_t number) const { return bcc::from_morton(codes_[number]); }

 private:
  parallel::KeySet set_;
  std::vector<Key> codes_;
  std::vector<std::uint32_t> number_;
};

}  // namespace

WorkMesh make_work_mesh(std::vector<Corners> lattice, const LatticeFrame& frame, const ImageDomain& domain) {
  std::vector<Material> materials(lattice.size());
  parallel::for_each_index(
      lattice.size(), [&](std::size_t i) { materials[i] = material_of(lattice[i], frame, domain); }, 256);
  keep_object_ring(lattice, materials, domain);
  const VertexNumbers vertices(lattice);

  WorkMesh mesh;
  mesh.positions.resize(vertices.size());
  parallel::for_each_index(vertices.size(),
                           [&](std::size_t v) { mesh.positions[v] = frame.position_mm(vertices.key(v)); });
  std::vector<Corner4> tets(lattice.size());
  std::vector<std::uint64_t> order(lattice.size());
  parallel::for_each_index(lattice.size(), [&](std::size_t i) {
    for (std::size_t c = 0; c < 4; ++c) tets[i][c] = vertices.number(lattice[i][c]);
    order[i] = std::uint64_t{*std::min_element(tets[i].begin(), tets[i].end())} << 32 | i;
  });
  parallel::sort(order.begin(), order.end());
  mesh.tets.resize(tets.size());
  mesh.materials.resize(tets.size());
  parallel::for_each_index(tets.size(), [&](std::size_t i) {
    const std::size_t from = order[i] & 0xffffffffU;
    mesh.tets[i] = tets[from];
    mesh.materials[i] = materials[from];
  });
  build_stars(mesh);
  build_neighbours(mesh);
  return mesh;
}

void build_stars(WorkMesh& mesh) {
  std::vector<std::uint64_t> pairs(4 * mesh.tets.size());
  parallel::for_each_index(mesh.tets.size(), [&](std::size_t t) {
    for (std::size_t c = 0; c < 4; ++c) pairs[4 * t + c] = std::uint64_t{mesh.tets[t][c]} << 32 | t;
  });
  parallel::sort(pairs.begin(), pairs.end());
  mesh.star_tets.resize(pairs.size());
  mesh.star_begin.assign(mesh.positions.size() + 1, static_cast<std::uint32_t>(pairs.size()));
  parallel::for_each_index(pairs.size(), [&](std::size_t i) {
    mesh.star_tets[i] = static_cast<std::uint32_t>(pairs[i] & 0xffffffffU);
    const std::size_t vertex = pairs[i] >> 32;
    const std::size_t before = i == 0 ? 0 : (pairs[i - 1] >> 32) + 1;
    for (std::size_t v = before; v <= vertex; ++v) mesh.star_begin[v] = static_cast<std::uint32_t>(i);
  });
}

void build_neighbours(WorkMesh& mesh) {
  mesh.neighbours.resize(mesh.tets.size());
  parallel::for_each_index(
      mesh.tets.size(),
      [&](std::size_t t) {
        for (std::size_t c = 0; c < 4; ++c) {
          const std::uint32_t a = mesh.tets[t][(c + 1) % 4];
          const std::uint32_t b = mesh.tets[t][(c + 2) % 4];
          const std::uint32_t d = mesh.tets[t][(c + 3) % 4];
          std::uint32_t found = kNoTet;
          for (const std::uint32_t other : mesh.star(a)) {
            if (other == t) continue;
            const Corner4& o = mesh.tets[other];
            const bool has_b = o[0] == b || o[1] == b || o[2] == b || o[3] == b;
            const bool has_d = o[0] == d || o[1] == d || o[2] == d || o[3] == d;
            if (has_b && has_d) found = other;
          }
          mesh.neighbours[t][c] = found;
        }
      },
      256);
}

std::vector<std::uint32_t> keep_tetrahedra(WorkMesh& mesh, const std::vector<std::uint8_t>& keep) {
  const auto kept_tets = parallel::collect<std::uint32_t>(mesh.tets.size(), [&](std::size_t t, auto& out) {
    if (keep[t] != 0) out.push_back(static_cast<std::uint32_t>(t));
  });
  const auto kept_vertices =
      parallel::collect<std::uint32_t>(mesh.positions.size(), [&](std::size_t v, auto& out) {
        for (const std::uint32_t t : mesh.star(static_cast<std::uint32_t>(v))) {
          if (keep[t] == 0) continue;
          out.push_back(static_cast<std::uint32_t>(v));
          return;
        }
      });
  std::vector<std::uint32_t> number(mesh.positions.size(), kNoTet);
  WorkMesh small;
  small.positions.resize(kept_vertices.size());
  parallel::for_each_index(kept_vertices.size(), [&](std::size_t v) {
    number[kept_vertices[v]] = static_cast<std::uint32_t>(v);
    small.positions[v] = mesh.positions[kept_vertices[v]];
  });
  small.tets.resize(kept_tets.size());
  small.materials.resize(kept_tets.size());
  parallel::for_each_index(kept_tets.size(), [&](std::size_t t) {
    const Corner4& from = mesh.tets[kept_tets[t]];
    for (std::size_t c = 0; c < 4; ++c) small.tets[t][c] = number[from[c]];
    small.materials[t] = mesh.materials[kept_tets[t]];
  });
  mesh = std::move(small);
  build_stars(mesh);
  build_neighbours(mesh);
  return kept_vertices;
}

}  // namespace lumesh
