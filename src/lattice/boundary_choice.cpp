#include "boundary_choice.hpp"

#include <algorithm>
#include <bit>
#include <deque>

#include "lumesh/parallel/loops.hpp"

namespace lumesh {

namespace {

constexpr std::size_t kMaxStar = 64;    // stars of a red-green lattice stay well below
constexpr std::uint8_t kMaxChanges = 3;  // a tetrahedron changes its material this often at most

/// The tetrahedra around a vertex and which of them share a face that holds the vertex.
class Star {
 public:
  Star(const WorkMesh& mesh, std::uint32_t vertex) : mesh_(mesh), tets_(mesh.star(vertex)) {
    if (tets_.size() > kMaxStar) return;
    for (std::size_t i = 0; i < tets_.size(); ++i) {
      const Corner4& corners = mesh.tets[tets_[i]];
      for (std::size_t c = 0; c < 4; ++c) {
        const std::uint32_t other = mesh.neighbours[tets_[i]][c];
        if (corners[c] == vertex || other == kNoTet) continue;
        const auto at = std::lower_bound(tets_.begin(), tets_.end(), other);
        links_[i] |= std::uint64_t{1} << (at - tets_.begin());
      }
    }
  }

  [[nodiscard]] bool too_large() const { return tets_.size() > kMaxStar; }
  [[nodiscard]] std::span<const std::uint32_t> tets() const { return tets_; }
  [[nodiscard]] std::uint64_t all() const {
    return tets_.size() == kMaxStar ? ~std::uint64_t{0} : (std::uint64_t{1} << tets_.size()) - 1;
  }
  [[nodiscard]] std::uint64_t of_material(Material m) const {
    std::uint64_t mask = 0;
    for (std::size_t i = 0; i < tets_.size(); ++i) {
      if (mesh_.materials[tets_[i]] == m) mask |= std::uint64_t{1} << i;
    }
    return mask;
  }
  /// The part of `region` connected to its first tetrahedron.
  [[nodiscard]] std::uint64_t component(std::uint64_t region) const {
    std::uint64_t reached = region & (~region + 1);
    std::uint64_t front = reached;
    while (front != 0) {
      const auto i = static_cast<std::size_t>(std::countr_zero(front));
      front &= front - 1;
      const std::uint64_t next = links_[i] & region & ~reached;
      reached |= next;
      front |= next;
    }
    return reached;
  }
  [[nodiscard]] bool connected(std::uint64_t region) const { return component(region) == region; }

 private:
  const WorkMesh& mesh_;
  std::span<const std::uint32_t> tets_;
  std::array<std::uint64_t, kMaxStar> links_ = {};
};

class BoundaryChooser {
 public:
  BoundaryChooser(WorkMesh& mesh, const ImageDomain& domain)
      : mesh_(mesh), domain_(domain), changes_(mesh.tets.size()), queued_(mesh.tets.size()) {}

  BoundaryChoice run() {
    queue_boundary();
    smooth_out_spikes();
    for (int round = 0; round < 30; ++round) {
      const std::vector<std::uint32_t> bad = non_manifold_vertices();
      result_.non_manifold_vertices = bad.size();
      if (bad.empty()) break;
      for (const std::uint32_t v : bad) mend(v, round);
      smooth_out_spikes();
    }
    return result_;
  }

 private:
  [[nodiscard]] bool manifold_at(std::uint32_t vertex) const {
    const Star star(mesh_, vertex);
    if (star.too_large()) return true;
    std::uint64_t left = star.all();
    while (left != 0) {
      const Material m = mesh_.materials[star.tets()[static_cast<std::size_t>(std::countr_zero(left))]];
      const std::uint64_t own = star.of_material(m);
      left &= ~own;
      if (!domain_.is_meshed(m) || own == star.all()) continue;
      if (!star.connected(own) || !star.connected(star.all() & ~own)) return false;
    }
    return true;
  }

  [[nodiscard]] std::vector<std::uint32_t> non_manifold_vertices() const {
    return parallel::collect<std::uint32_t>(mesh_.positions.size(), [&](std::size_t v, auto& out) {
      const auto star = mesh_.star(static_cast<std::uint32_t>(v));
      const Material first = mesh_.materials[star[0]];
      const bool inner = std::all_of(star.begin(), star.end(), [&](auto t) { return mesh_.materials[t] == first; });
      if (!inner && !manifold_at(static_cast<std::uint32_t>(v))) out.push_back(static_cast<std::uint32_t>(v));
    });
  }

  void enqueue(std::uint32_t t) {
    if (queued_[t] != 0) return;
    queued_[t] = 1;
    queue_.push_back(t);
  }

  void queue_boundary() {
    const auto first = parallel::collect<std::uint32_t>(mesh_.tets.size(), [&](std::size_t t, auto& out) {
      int others = 0;
      for (const std::uint32_t n : mesh_.neighbours[t])
        others += n != kNoTet && mesh_.materials[n] != mesh_.materials[t] ? 1 : 0;
      if (others >= 2) out.push_back(static_cast<std::uint32_t>(t));
    });
    for (const std::uint32_t t : first) enqueue(t);
  }

  void smooth_out_spikes() {
    while (!queue_.empty()) {
      const std::uint32_t t = queue_.front();
      queue_.pop_front();
      queued_[t] = 0;
      consider(t);
    }
  }

  /// Gives a spike to the material around it: three faces or more, or two towards the outside. A tetrahedron with two
  /// faces on the boundary would have to open to nearly 180 degrees once the boundary is smooth.
  void consider(std::uint32_t t) {
    const Material own = mesh_.materials[t];
    Material other = own;
    int faces = 0;
    for (const std::uint32_t n : mesh_.neighbours[t]) {
      if (n == kNoTet || mesh_.materials[n] == own) continue;
      const Material m = mesh_.materials[n];
      int same = 0;
      for (const std::uint32_t k : mesh_.neighbours[t]) same += k != kNoTet && mesh_.materials[k] == m ? 1 : 0;
      if (same > faces || (same == faces && m < other)) {
        faces = same;
        other = m;
      }
    }
    const int enough = domain_.is_meshed(own) && !domain_.is_meshed(other) ? 2 : 3;
    if (faces >= enough && near_boundary(t, own, other)) try_change(t, other);
  }

  /// Guards thin vessels: only tetrahedra that the boundary passes close by may change sides.
  [[nodiscard]] bool near_boundary(std::uint32_t t, Material own, Material other) const {
    const Corner4& c = mesh_.tets[t];
    double longest = 0;
    for (const auto& [a, b] : bcc::kEdge)
      longest = std::max(longest, (mesh_.positions[c[a]] - mesh_.positions[c[b]]).squaredNorm());
    const double depth = domain_.separation(mesh_.centroid(t), own, other).value;
    return depth < 0.3 * std::sqrt(longest);
  }

  bool try_change(std::uint32_t t, Material to) {
    if (changes_[t] >= kMaxChanges) return false;
    const Material from = mesh_.materials[t];
    std::array<bool, 4> was_good;
    for (std::size_t c = 0; c < 4; ++c) was_good[c] = manifold_at(mesh_.tets[t][c]);
    mesh_.materials[t] = to;
    for (std::size_t c = 0; c < 4; ++c) {
      if (was_good[c] && !manifold_at(mesh_.tets[t][c])) {
        mesh_.materials[t] = from;
        return false;
      }
    }
    note_change(t);
    return true;
  }

  void note_change(std::uint32_t t) {
    ++changes_[t];
    ++result_.relabelled;
    for (const std::uint32_t n : mesh_.neighbours[t]) {
      if (n != kNoTet) enqueue(n);
    }
  }

  /// Makes one vertex manifold: the smaller parts of a label, or of what is not the label, go to their surroundings.
  void mend(std::uint32_t vertex, int round) {
    const Star star(mesh_, vertex);
    if (star.too_large()) return;
    std::uint64_t left = star.all();
    while (left != 0) {
      const Material m = mesh_.materials[star.tets()[static_cast<std::size_t>(std::countr_zero(left))]];
      const std::uint64_t own = star.of_material(m);
      left &= ~own;
      if (!domain_.is_meshed(m) || own == star.all()) continue;
      const bool own_broken = !star.connected(own);
      const bool rest_broken = !star.connected(star.all() & ~own);
      if (!own_broken && !rest_broken) continue;
      // Early rounds keep the label together by filling; later ones give way, which always ends.
      const bool fill = rest_broken && (!own_broken || round % 2 == 0);
      if (fill) {
        give_small_parts(star, star.all() & ~own, m);
      } else {
        give_small_parts(star, own, kNobody);
      }
      return;
    }
  }

  static constexpr Material kNobody = ~Material{0};

  /// All but the largest part of a region goes to `to`, or to the commonest material around each tetrahedron.
  void give_small_parts(const Star& star, std::uint64_t region, Material to) {
    std::uint64_t largest = 0;
    for (std::uint64_t left = region; left != 0;) {
      const std::uint64_t part = star.component(left);
      left &= ~part;
      if (std::popcount(part) > std::popcount(largest)) largest = part;
    }
    for (std::uint64_t left = region & ~largest; left != 0; left &= left - 1) {
      const std::uint32_t t = star.tets()[static_cast<std::size_t>(std::countr_zero(left))];
      const Material give_to = to == kNobody ? commonest_around(t) : to;
      if (give_to == mesh_.materials[t]) continue;
      mesh_.materials[t] = give_to;
      note_change(t);
    }
  }

  [[nodiscard]] Material commonest_around(std::uint32_t t) const {
    Material best = mesh_.materials[t];
    int most = 0;
    for (const std::uint32_t n : mesh_.neighbours[t]) {
      if (n == kNoTet || mesh_.materials[n] == mesh_.materials[t]) continue;
      int same = 0;
      for (const std::uint32_t k : mesh_.neighbours[t])
        same += k != kNoTet && mesh_.materials[k] == mesh_.materials[n] ? 1 : 0;
      if (same > most || (same == most && mesh_.materials[n] < best)) {
        most = same;
        best = mesh_.materials[n];
      }
    }
    return best;
  }

  WorkMesh& mesh_;
  const ImageDomain& domain_;
  std::vector<std::uint8_t> changes_;
  std::vector<std::uint8_t> queued_;
  std::deque<std::uint32_t> queue_;
  BoundaryChoice result_;
};

}  // namespace

BoundaryChoice choose_boundary(WorkMesh& mesh, const ImageDomain& domain) {
  return BoundaryChooser(mesh, domain).run();
}

}  // namespace lumesh
