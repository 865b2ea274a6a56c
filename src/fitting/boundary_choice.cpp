#include "lumesh/fitting/boundary_choice.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/relaxed.hpp"

namespace lumesh::fitting {

namespace {

/// A set of tetrahedra of one star. Stars of 96 have been seen where several levels meet.
__extension__ using Mask = unsigned __int128;
constexpr std::size_t kMaxStar = 128;

constexpr Mask single(std::size_t i) {
  return Mask{1} << i;
}
std::size_t lowest(Mask mask) {
  const auto low = static_cast<std::uint64_t>(mask);
  return static_cast<std::size_t>(low != 0 ? std::countr_zero(low)
                                           : 64 + std::countr_zero(static_cast<std::uint64_t>(mask >> 64)));
}
int size_of(Mask mask) {
  return std::popcount(static_cast<std::uint64_t>(mask)) +
         std::popcount(static_cast<std::uint64_t>(mask >> 64));
}

constexpr int kRepairRounds = 16;  // clean images need one or two
constexpr int kMergeRounds =
    60;  // until then what still is in the way goes to a neighbouring label, later it is dropped
constexpr int kMaxRounds = 200;  // dropping always ends; the limit is there for safety
constexpr double kDeepest =
    0.6;  // longest edges inside its material, for a centroid whose tetrahedron may change
constexpr std::uint8_t kMaxChanges = 3;  // a tetrahedron changes its material this often at most

/// The tetrahedra around a vertex and which of them share a face that holds the vertex.
class Star {
 public:
  Star(const WorkMesh& mesh, std::uint32_t vertex) : mesh_(mesh), tets_(mesh.star(vertex)) {
    if (tets_.size() > kMaxStar) return;
    slots_.fill(kFree);
    for (std::size_t i = 0; i < tets_.size(); ++i) slots_[slot_of(tets_[i])] = static_cast<std::uint8_t>(i);
    for (std::size_t i = 0; i < tets_.size(); ++i) {
      const Corner4& corners = mesh.tets[tets_[i]];
      links_[i] = 0;
      for (std::size_t c = 0; c < 4; ++c) {
        const std::uint32_t other = mesh.neighbours[tets_[i]][c];
        if (corners[c] == vertex) continue;
        if (other != kNoTet)
          links_[i] |= single(place_of(other));
        else
          hull_ |= single(i);
      }
    }
  }

  [[nodiscard]] bool too_large() const { return tets_.size() > kMaxStar; }
  [[nodiscard]] std::span<const std::uint32_t> tets() const { return tets_; }
  [[nodiscard]] Mask all() const { return tets_.size() == kMaxStar ? ~Mask{0} : single(tets_.size()) - 1; }
  [[nodiscard]] Mask of_material(Material m) const {
    Mask mask = 0;
    for (std::size_t i = 0; i < tets_.size(); ++i) {
      if (mesh_.materials[tets_[i]] == m) mask |= single(i);
    }
    return mask;
  }
  /// The part of `region` connected to its first tetrahedron.
  [[nodiscard]] Mask component(Mask region) const {
    Mask reached = region & (~region + 1);
    Mask front = reached;
    while (front != 0) {
      const auto i = lowest(front);
      front &= front - 1;
      const Mask next = links_[i] & region & ~reached;
      reached |= next;
      front |= next;
    }
    return reached;
  }
  [[nodiscard]] bool connected(Mask region) const { return component(region) == region; }
  /// The same for a part of the outside, which goes on beyond the lattice.
  [[nodiscard]] bool connected_outside(Mask region) const {
    for (Mask left = region; left != 0;) {
      const Mask part = component(left);
      if ((part & hull_) == 0) return part == region;
      left &= ~part;
    }
    return true;
  }

 private:
  /// Where a tetrahedron of the star is noted, or the free slot for it: a hash table half full at most, for
  /// this is what most of the time goes into.
  [[nodiscard]] std::size_t slot_of(std::uint32_t tet) const {
    std::size_t at = (tet * std::uint32_t{0x9e3779b1}) >> 24;
    while (slots_[at] != kFree && tets_[slots_[at]] != tet) at = (at + 1) % kSlots;
    return at;
  }
  [[nodiscard]] std::size_t place_of(std::uint32_t tet) const { return slots_[slot_of(tet)]; }

  static constexpr std::size_t kSlots = 256;
  static constexpr std::uint8_t kFree = 255;
  const WorkMesh& mesh_;
  std::span<const std::uint32_t> tets_;
  std::array<std::uint8_t, kSlots> slots_;  // of a hash table: places of tetrahedra in the star
  std::array<Mask, kMaxStar> links_;        // the first as many as there are tetrahedra
  Mask hull_ = 0;                           // tetrahedra with a face at the vertex and nothing behind it
};

class BoundaryChooser {
 public:
  BoundaryChooser(WorkMesh& mesh, const ImageDomain& domain)
      : mesh_(mesh),
        domain_(domain),
        changes_(mesh.tets.size()),
        queued_(mesh.tets.size()),
        claim_(mesh.positions.size()) {}

  BoundaryChoice run() {
    queue_boundary();
    relabel_exposed();
    std::vector<std::uint32_t> bad = non_manifold_vertices();
    for (int round = 0; round < kMaxRounds && !bad.empty(); ++round) {
      touched_ = bad;
      for (const std::uint32_t v : bad) round < kRepairRounds ? repair(v, round) : erode(v, round);
      if (round < kRepairRounds) relabel_exposed();
      bad = still_bad();
    }
    result_.non_manifold_vertices = bad.size();
    return result_;
  }

 private:
  [[nodiscard]] bool manifold_at(std::uint32_t vertex) const {
    const Star star(mesh_, vertex);
    if (star.too_large()) return false;
    const Mask object = object_part(star);
    if (!star.connected(object) || !star.connected_outside(star.all() & ~object)) return false;
    Mask left = object;
    while (left != 0) {
      const Material m = mesh_.materials[star.tets()[lowest(left)]];
      const Mask own = star.of_material(m);
      left &= ~own;
      if (own == star.all() || own == object) continue;
      if (!star.connected(own) || !star.connected(star.all() & ~own)) return false;
    }
    return true;
  }

  /// The tetrahedra around a vertex that belong to any label.
  [[nodiscard]] Mask object_part(const Star& star) const {
    Mask mask = 0;
    for (std::size_t i = 0; i < star.tets().size(); ++i) {
      if (domain_.is_meshed(mesh_.materials[star.tets()[i]])) mask |= single(i);
    }
    return mask;
  }

  [[nodiscard]] std::vector<std::uint32_t> non_manifold_vertices() const {
    return parallel::collect<std::uint32_t>(mesh_.positions.size(), [&](std::size_t v, auto& out) {
      const auto star = mesh_.star(static_cast<std::uint32_t>(v));
      const Material first = mesh_.materials[star[0]];
      const bool inner =
          std::all_of(star.begin(), star.end(), [&](auto t) { return mesh_.materials[t] == first; });
      if (!inner && !manifold_at(static_cast<std::uint32_t>(v))) out.push_back(static_cast<std::uint32_t>(v));
    });
  }

  /// Bad vertices among those that the last round touched.
  [[nodiscard]] std::vector<std::uint32_t> still_bad() {
    sort_unique(touched_);
    return parallel::collect<std::uint32_t>(touched_.size(), 256, [&](std::size_t i, auto& out) {
      if (!manifold_at(touched_[i])) out.push_back(touched_[i]);
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

  struct Relabelling {
    std::uint32_t tet = 0;
    Material to = 0;
    double depth = 0;  // of its centroid inside its own material, in units of its longest edge
  };

  /// Round by round, an independent set of the tetrahedra to be relabelled is tried: those of the highest
  /// priority at all of their vertices.
  void relabel_exposed() {
    while (!queue_.empty()) {
      const std::vector<std::uint32_t> now = std::exchange(queue_, {});
      const auto relabellings =
          parallel::collect<Relabelling>(now.size(), 256, [&](std::size_t i, auto& out) {
            queued_[now[i]] = 0;
            const Relabelling relabelling = relabelling_of(now[i]);
            if (relabelling.to != mesh_.materials[now[i]]) out.push_back(relabelling);
          });
      ++round_;
      relabel_independent(relabellings);
    }
  }

  void relabel_independent(const std::vector<Relabelling>& relabellings) {
    const auto for_each_relabelling = [&](const auto& body) {
      parallel::for_each_index(relabellings.size(), 64, [&](std::size_t i) { body(i, relabellings[i]); });
    };
    for_each_relabelling([&](std::size_t, const Relabelling& w) {
      for (const std::uint32_t v : mesh_.tets[w.tet]) parallel::raise_to(claim_[v], priority(w));
    });
    enum class Outcome : std::uint8_t { kLater, kRefused, kDone };
    std::vector<Outcome> outcome(relabellings.size(), Outcome::kLater);
    for_each_relabelling([&](std::size_t i, const Relabelling& w) {
      const Corner4& c = mesh_.tets[w.tet];
      const bool first =
          std::all_of(c.begin(), c.end(), [&](std::uint32_t v) { return claim_[v] == priority(w); });
      // No other that comes first shares a vertex with it, so nobody else looks at its material.
      if (first) outcome[i] = try_change(w.tet, w.to) ? Outcome::kDone : Outcome::kRefused;
    });
    for (std::size_t i = 0; i < relabellings.size(); ++i) {
      if (outcome[i] == Outcome::kDone) note_change(relabellings[i].tet);
      if (outcome[i] == Outcome::kLater) enqueue(relabellings[i].tet);
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

  bool try_change(std::uint32_t t, Material to) {
    const Material from = mesh_.materials[t];
    for (const std::uint32_t v : mesh_.tets[t]) {
      mesh_.materials[t] = to;
      if (manifold_at(v)) continue;
      mesh_.materials[t] = from;
      if (manifold_at(v)) return false;  // it would break a good place
    }
    mesh_.materials[t] = to;
    return true;
  }

  void note_change(std::uint32_t t) {
    ++changes_[t];
    ++result_.relabelled;
    touched_.insert(touched_.end(), mesh_.tets[t].begin(), mesh_.tets[t].end());
    for (const std::uint32_t n : mesh_.neighbours[t]) {
      if (n != kNoTet) enqueue(n);
    }
  }

  /// Makes one vertex manifold: tries to give each part of each label around it, and each gap, to every other
  /// material around, and keeps what leaves the fewest bad vertices. Where nothing helps, later rounds make
  /// any of the changes (a pseudo-random one, the same in every run), which breaks deadlocks between
  /// neighbours.
  void repair(std::uint32_t vertex, int round) {
    const Star star(mesh_, vertex);
    if (star.too_large() || manifold_at(vertex)) return;
    const std::vector<Change> options = possible_changes(star);
    const Change* best = nullptr;
    int best_gain = 0;
    for (const Change& option : options) {
      const int gain = gain_of(star, option);
      if (best == nullptr || gain > best_gain) {
        best = &option;
        best_gain = gain;
      }
    }
    if (best == nullptr) return;
    constexpr int kPatience = 3;  // rounds
    if (best_gain <= 0) {
      if (round < kPatience) return;
      best = &options[(vertex * std::size_t{2654435761} + static_cast<std::size_t>(round) * 40503) %
                      options.size()];
    }
    apply(star, *best);
  }

  /// Where repairs go in circles, as with labels one tetrahedron thick: takes the offending label away from
  /// around the vertex, its smaller parts if it is in pieces, all of it if it encloses something.
  void erode(std::uint32_t vertex, int round) {
    const Star star(mesh_, vertex);
    if (star.too_large() || manifold_at(vertex)) return;
    std::vector<std::pair<int, Material>> by_size;
    for (Mask left = star.all(); left != 0;) {
      const Material m = mesh_.materials[star.tets()[lowest(left)]];
      by_size.emplace_back(size_of(star.of_material(m)), m);
      left &= ~star.of_material(m);
    }
    std::sort(by_size.begin(), by_size.end());  // the smallest is taken away
    const Material largest = by_size.back().second;
    const bool has_outside = object_part(star) != star.all();
    for (const auto& [count, m] : by_size) {
      const Mask own = star.of_material(m);
      if (!domain_.is_meshed(m) || own == star.all()) continue;
      const bool whole = star.connected(own);
      if (whole && star.connected(star.all() & ~own)) continue;
      // The background only where it is already: no bubbles within.
      const Material other = largest != m ? largest : by_size[by_size.size() - 2].second;
      const Material to = has_outside && (round >= kMergeRounds || largest == m) ? 0 : other;
      apply(star, {whole ? own : own & ~star.component(own), to});
      return;
    }
    if (has_outside) apply(star, {object_part(star), 0});
  }

  /// Tetrahedra of a star (as a mask) that shall get another material.
  struct Change {
    Mask tets = 0;
    Material to = 0;
  };

  [[nodiscard]] std::vector<Change> possible_changes(const Star& star) const {
    std::vector<Material> around;  // the background only if it is there: no bubbles within
    for (const std::uint32_t t : star.tets()) {
      if (std::find(around.begin(), around.end(), mesh_.materials[t]) == around.end())
        around.push_back(mesh_.materials[t]);
    }
    std::vector<Change> options;
    const auto add_parts = [&](Mask region, Material own) {
      if (region == star.all() || star.connected(region)) return;
      for (Mask left = region; left != 0;) {
        const Mask part = star.component(left);
        left &= ~part;
        if (2 * size_of(part) > size_of(region)) continue;  // the main part stays
        for (const Material m : around) {
          if (m == own) continue;
          options.push_back({part, m});
          for (Mask tets = part; size_of(part) > 1 && tets != 0; tets &= tets - 1)
            options.push_back({tets & (~tets + 1), m});
        }
      }
    };
    for (const Material m : around) {
      const Mask own = star.of_material(m);
      if (!domain_.is_meshed(m) || own == 0) continue;
      add_parts(own, m);
      add_parts(star.all() & ~own, kNobody);
    }
    const Mask object = object_part(star);
    add_parts(object, kNobody);
    add_parts(star.all() & ~object, kNobody);
    return options;
  }

  static constexpr Material kNobody = ~Material{0};

  /// How many vertices of the changed tetrahedra become good, less those that become bad.
  int gain_of(const Star& star, const Change& change) {
    std::vector<std::uint32_t> vertices;
    std::vector<Material> before;
    for (Mask left = change.tets; left != 0; left &= left - 1) {
      const std::uint32_t t = star.tets()[lowest(left)];
      before.push_back(mesh_.materials[t]);
      vertices.insert(vertices.end(), mesh_.tets[t].begin(), mesh_.tets[t].end());
    }
    sort_unique(vertices);
    const auto count_bad = [&] {
      return std::count_if(vertices.begin(), vertices.end(),
                           [&](std::uint32_t v) { return !manifold_at(v); });
    };
    const auto bad_before = count_bad();
    set_materials(star, change.tets, [&](std::size_t) { return change.to; });
    const auto bad_after = count_bad();
    set_materials(star, change.tets, [&](std::size_t n) { return before[n]; });
    return static_cast<int>(bad_before - bad_after);
  }

  template <class MaterialOf>
  void set_materials(const Star& star, Mask tets, const MaterialOf& material_of) {
    std::size_t n = 0;
    for (Mask left = tets; left != 0; left &= left - 1)
      mesh_.materials[star.tets()[lowest(left)]] = material_of(n++);
  }

  void apply(const Star& star, const Change& change) {
    set_materials(star, change.tets, [&](std::size_t) { return change.to; });
    for (Mask left = change.tets; left != 0; left &= left - 1) note_change(star.tets()[lowest(left)]);
  }

  WorkMesh& mesh_;
  const ImageDomain& domain_;
  std::vector<std::uint8_t> changes_;
  std::vector<std::uint8_t> queued_;
  std::vector<std::uint32_t> touched_;  // vertices around which something changed in this round
  std::vector<std::uint32_t> queue_;
  std::uint32_t round_ = 0;
  std::vector<std::uint64_t> claim_;  // per vertex: the highest priority of those that want to change
  BoundaryChoice result_;
};

}  // namespace

BoundaryChoice choose_boundary(WorkMesh& mesh, const ImageDomain& domain) {
  return BoundaryChooser(mesh, domain).run();
}

}  // namespace lumesh::fitting
