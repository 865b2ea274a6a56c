#include "lumesh/fitting/boundary_choice.hpp"

#include <algorithm>
#include <utility>

#include "lumesh/domain/manifold_labels.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/relaxed.hpp"

namespace lumesh::fitting {

namespace {

constexpr double kDeepest =
    0.6;  // longest edges inside its material, for a centroid whose tetrahedron may change
constexpr std::uint8_t kMaxChanges = 3;  // a tetrahedron changes its material this often at most

class BoundaryChooser {
 public:
  BoundaryChooser(WorkMesh& mesh, const ImageDomain& domain)
      : mesh_(mesh),
        domain_(domain),
        changes_(mesh.tets.size()),
        queued_(mesh.tets.size()),
        claim_(mesh.positions.size()) {}

  std::size_t run() {
    queue_boundary();
    relabel_exposed();
    ManifoldRepair repair(*this);
    repair.run(non_manifold_among(*this, mesh_.positions.size(),
                                  [](std::size_t v) { return static_cast<std::uint32_t>(v); }),
               repair.kFit, [&] { return relabel_exposed(); });
    return relabelled_;
  }

  // The tetrahedra for LabelStar and ManifoldRepair, in the order of their numbers.
  struct StarScratch {};
  void gather_star(std::uint32_t v, StarScratch& /*none*/, std::vector<std::uint32_t>& tets) const {
    tets.assign(mesh_.star(v).begin(), mesh_.star(v).end());
  }
  [[nodiscard]] const Corner4& corners(std::uint32_t t) const { return mesh_.tets[t]; }
  [[nodiscard]] std::uint32_t behind(std::uint32_t t, std::size_t face) const {
    return mesh_.neighbours[t][face];
  }
  [[nodiscard]] Material material(std::uint32_t t) const { return mesh_.materials[t]; }
  [[nodiscard]] bool is_object(Material m) const { return domain_.is_meshed(m); }
  void set_material(std::uint32_t t, Material m) { mesh_.materials[t] = m; }
  void note_change(std::uint32_t t) {
    ++changes_[t];
    ++relabelled_;
    for (const std::uint32_t n : mesh_.neighbours[t]) {
      if (n != kNoTet) enqueue(n);
    }
  }
  void sort_tets(std::vector<std::uint32_t>& /*sorted*/) const {}
  void sort_vertices(std::vector<std::uint32_t>& /*sorted*/) const {}
  [[nodiscard]] std::uint32_t seed(std::uint32_t v) const { return v; }

 private:
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

  struct Relabelling {
    std::uint32_t tet = 0;
    Material to = 0;
    double depth = 0;  // of its centroid inside its own material, in units of its longest edge
  };

  /// Round by round, an independent set of the tetrahedra to be relabelled is tried: those of the highest
  /// priority at all of their vertices.
  /// @return What has been relabelled.
  std::vector<std::uint32_t> relabel_exposed() {
    std::vector<std::uint32_t> changed;
    while (!queue_.empty()) {
      const std::vector<std::uint32_t> now = std::exchange(queue_, {});
      const auto relabellings =
          parallel::collect<Relabelling>(now.size(), 256, [&](std::size_t i, auto& out) {
            queued_[now[i]] = 0;
            const Relabelling relabelling = relabelling_of(now[i]);
            if (relabelling.to != mesh_.materials[now[i]]) out.push_back(relabelling);
          });
      ++round_;
      relabel_independent(relabellings, changed);
    }
    return changed;
  }

  void relabel_independent(const std::vector<Relabelling>& relabellings,
                           std::vector<std::uint32_t>& changed) {
    parallel::for_each_index(relabellings.size(), 64, [&](std::size_t i) {
      const Relabelling& w = relabellings[i];
      for (const std::uint32_t v : mesh_.tets[w.tet]) parallel::raise_to(claim_[v], priority(w));
    });
    enum class Outcome : std::uint8_t { kLater, kRefused, kDone };
    std::vector<Outcome> outcome(relabellings.size(), Outcome::kLater);
    parallel::for_each_block(relabellings.size(), 64, [&](std::size_t, std::size_t begin, std::size_t end) {
      LabelStar star(*this);
      for (std::size_t i = begin; i < end; ++i) {
        const Relabelling& w = relabellings[i];
        const bool first =
            std::ranges::all_of(mesh_.tets[w.tet], [&](std::uint32_t v) { return claim_[v] == priority(w); });
        // No other that comes first shares a vertex with it, so nobody else looks at its material.
        if (first)
          outcome[i] = relabel_if_manifold(*this, w.tet, w.to, star) ? Outcome::kDone : Outcome::kRefused;
      }
    });
    for (std::size_t i = 0; i < relabellings.size(); ++i) {
      if (outcome[i] == Outcome::kLater) enqueue(relabellings[i].tet);
      if (outcome[i] != Outcome::kDone) continue;
      note_change(relabellings[i].tet);
      changed.push_back(relabellings[i].tet);
    }
  }

  /// The shallowest come first; different for different tetrahedra, and higher in each round than in those
  /// before.
  [[nodiscard]] std::uint64_t priority(const Relabelling& relabelling) const {
    const double shallow = std::clamp((kDeepest - relabelling.depth) / 2, 0.0, 0.999);
    return std::uint64_t{round_} << 44 | static_cast<std::uint64_t>(4096 * shallow) << 32 | relabelling.tet;
  }

  /// An exposed tetrahedron shall take the material around it: that of three faces or more, or of two towards
  /// the outside. A tetrahedron with two faces on the boundary would have to open to nearly 180 degrees once
  /// the boundary is smooth.
  [[nodiscard]] Relabelling relabelling_of(std::uint32_t t) const {
    const Material own = mesh_.materials[t];
    Material other = own;
    int faces = 0;
    for (const std::uint32_t n : mesh_.neighbours[t]) {
      if (n == kNoTet || mesh_.materials[n] == own) continue;
      const Material m = mesh_.materials[n];
      int same = 0;
      for (const std::uint32_t k : mesh_.neighbours[t])
        same += k != kNoTet && mesh_.materials[k] == m ? 1 : 0;
      if (same > faces || (same == faces && m < other)) {
        faces = same;
        other = m;
      }
    }
    const int enough = domain_.is_meshed(own) && !domain_.is_meshed(other) ? 2 : 3;
    Relabelling relabelling{t, own};
    if (faces < enough || changes_[t] >= kMaxChanges) return relabelling;
    const double longest = mesh_.longest_edge_mm(t);
    const Vec3 centroid = mesh_.centroid(t);
    const FieldSample here = domain_.separation(centroid, own, other);
    relabelling.depth = here.value / longest;
    if (near_boundary(here, centroid, longest, own, other)) relabelling.to = other;
    return relabelling;
  }

  /// Guards thin vessels: only tetrahedra that the boundary passes close by may change sides, and where the
  /// label goes on behind them also somewhat deeper ones, because the boundary can be drawn out again.
  [[nodiscard]] bool near_boundary(const FieldSample& here, const Vec3& centroid, double longest,
                                   Material own, Material other) const {
    if (here.value < 0.3 * longest) return true;
    if (here.value > kDeepest * longest) return false;
    const Vec3 behind = centroid + here.gradient.normalized() * longest;
    return domain_.separation(behind, own, other).value > here.value + 0.5 * longest;
  }

  WorkMesh& mesh_;
  const ImageDomain& domain_;
  std::vector<std::uint8_t> changes_;
  std::vector<std::uint8_t> queued_;
  std::vector<std::uint32_t> queue_;
  std::uint32_t round_ = 0;
  std::vector<std::uint64_t> claim_;  // per vertex: the highest priority of those that want to change
  std::size_t relabelled_ = 0;
};

}  // namespace

std::size_t choose_boundary(WorkMesh& mesh, const ImageDomain& domain) {
  return BoundaryChooser(mesh, domain).run();
}

}  // namespace lumesh::fitting
