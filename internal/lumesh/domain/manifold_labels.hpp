#pragma once
/// @file Boundaries of labels made manifold, for the lattice and for Delaunay refinement: tetrahedra around
/// a vertex take the material of neighbours.

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "label_star.hpp"
#include "lumesh/core/local_map.hpp"
#include "lumesh/core/sort_unique.hpp"

namespace lumesh {

/// The tetrahedra that a repair may change.
template <class Tets>
concept RelabelledTets = LabelledTets<Tets> &&
    requires(Tets& tets, std::uint32_t n, Material m, std::vector<std::uint32_t>& list) {
  tets.set_material(n, m);
  tets.note_change(n);  // Of the material of a tetrahedron, for good.
  // Orders on which the result depends, and a number of a vertex that looks random.
  tets.sort_tets(list);
  tets.sort_vertices(list);
  { tets.seed(n) } -> std::same_as<std::uint32_t>;
};

/// Works on the materials alone, one vertex after another. Repairs of neighbours can go in circles, as with
/// labels one tetrahedron thick: what is asked of a vertex becomes more from round to round.
template <RelabelledTets Tets>
class ManifoldRepair {
 public:
  /// The first rounds of each way: parts of labels go where they fit best; the whole star becomes its most
  /// frequent material; it becomes of the outside, which comes to an end.
  static constexpr int kFit = 0, kLevel = 16, kClear = 60;

  explicit ManifoldRepair(Tets& tets) : tets_(tets), star_(tets), probe_(tets) {}

  /// Changes materials until all boundaries are manifolds.
  /// @param bad  All vertices where they are not. @param round  The one to begin with.
  /// @param between  Called after each round of the first way; returns the tetrahedra that it has changed.
  template <class Between>
  void run(std::vector<std::uint32_t> bad, int round, const Between& between) {
    for (; !bad.empty(); ++round) {
      touched_ = bad;
      tets_.sort_vertices(bad);
      for (const std::uint32_t v : bad) repair(v, round);
      if (round < kLevel)
        for (const std::uint32_t t : between()) touch(t);
      sort_unique(touched_);
      bad = non_manifold_among(tets_, touched_.size(), [&](std::size_t i) { return touched_[i]; });
    }
  }

 private:
  using Part = typename LabelStar<Tets>::Part;
  /// Tetrahedra of the star that shall get another material.
  struct Change {
    Part tets;
    Material to = 0;
  };

  void repair(std::uint32_t vertex, int round) {
    star_.gather(vertex, [&](auto& tets) { tets_.sort_tets(tets); });
    if (star_.is_manifold()) return;
    if (round < kLevel)
      give_parts(vertex, round);
    else
      apply({all_of([](std::uint32_t) { return true; }), round < kClear ? most_frequent() : 0});
  }

  /// Tries to give each part of each label around the vertex, and each gap, to every other material around,
  /// and keeps what leaves the fewest bad vertices. Where nothing helps, later rounds make any of the changes
  /// (a pseudo-random one, the same in every run), which breaks deadlocks between neighbours.
  void give_parts(std::uint32_t vertex, int round) {
    was_bad_.clear();
    const std::vector<Change> options = possible_changes();
    const Change* best = nullptr;
    int best_gain = 0;
    for (const Change& option : options) {
      const int gain = gain_of(option);
      if (best == nullptr || gain > best_gain) {
        best = &option;
        best_gain = gain;
      }
    }
    if (best == nullptr) return;
    constexpr int kPatience = 3;  // rounds
    if (best_gain <= 0) {
      if (round < kPatience) return;
      best =
          &options[(tets_.seed(vertex) * std::size_t{2654435761} + static_cast<std::size_t>(round) * 40503) %
                   options.size()];
    }
    apply(*best);
  }

  [[nodiscard]] std::vector<Change> possible_changes() {
    std::vector<Change> options;
    const auto add_parts = [&](const auto& region, const auto& may_become) {
      const std::vector<Part> parts = star_.parts(region);
      std::size_t size = 0;
      for (const Part& part : parts) size += part.size();
      for (const Part& part : parts) {
        if (parts.size() == 1 || 2 * part.size() > size) continue;  // The main part stays.
        // The outside only if it is there: no bubbles within.
        for (const Material m : star_.materials()) {
          if (!may_become(m)) continue;
          options.push_back({part, m});
          constexpr std::size_t kFew = 32;
          if (part.size() == 1 || part.size() > kFew) continue;
          for (const std::uint32_t i : part) options.push_back({{i}, m});
        }
      }
    };
    const auto anything = [](Material) { return true; };
    for (const Material m : star_.materials()) {
      if (!tets_.is_object(m)) continue;
      add_parts(star_.of(m), [m](Material to) { return to != m; });
      add_parts(star_.all_but(m), anything);
    }
    add_parts([this](std::uint32_t i) { return star_.is_object(i); }, anything);
    add_parts([this](std::uint32_t i) { return !star_.is_object(i); }, anything);
    return options;
  }

  /// How many vertices of the changed tetrahedra become good, less those that become bad.
  int gain_of(const Change& change) {
    vertices_.clear();
    for (const std::uint32_t i : change.tets) {
      const std::array<std::uint32_t, 4> corners = tets_.corners(star_.tets()[i]);
      vertices_.insert(vertices_.end(), corners.begin(), corners.end());
    }
    sort_unique(vertices_);
    const auto bad_before = std::ranges::count_if(vertices_, [&](std::uint32_t v) { return was_bad(v); });
    for (const std::uint32_t i : change.tets) tets_.set_material(star_.tets()[i], change.to);
    const auto bad_after = std::ranges::count_if(vertices_, [&](std::uint32_t v) { return is_bad(v); });
    for (const std::uint32_t i : change.tets) tets_.set_material(star_.tets()[i], star_.material(i));
    return static_cast<int>(bad_before - bad_after);
  }

  [[nodiscard]] bool is_bad(std::uint32_t v) {
    probe_.gather(v);
    return !probe_.is_manifold();
  }
  /// Answer of is_bad() before any change is tried.
  [[nodiscard]] bool was_bad(std::uint32_t v) {
    const auto known = was_bad_.insert(v, 0);
    if (known.added) known.value = is_bad(v) ? 1 : 0;
    return known.value != 0;
  }

  template <class In>
  [[nodiscard]] Part all_of(const In& in) const {
    Part found;
    for (std::uint32_t i = 0; i < star_.tets().size(); ++i)
      if (in(i)) found.push_back(i);
    return found;
  }
  [[nodiscard]] Material most_frequent() const {
    return *std::ranges::max_element(star_.materials(), {},
                                     [&](Material m) { return std::pair(all_of(star_.of(m)).size(), ~m); });
  }

  void apply(const Change& change) {
    for (const std::uint32_t i : change.tets) tets_.set_material(star_.tets()[i], change.to);
    for (const std::uint32_t i : change.tets) {
      touch(star_.tets()[i]);
      tets_.note_change(star_.tets()[i]);
    }
  }
  void touch(std::uint32_t tet) {
    const std::array<std::uint32_t, 4> corners = tets_.corners(tet);
    touched_.insert(touched_.end(), corners.begin(), corners.end());
  }

  Tets& tets_;
  LabelStar<Tets> star_, probe_;
  std::vector<std::uint32_t> touched_;   // vertices around which something changed in this round
  std::vector<std::uint32_t> vertices_;  // of gain_of()
  LocalMap<std::uint32_t, char> was_bad_;
};

/// Gives a tetrahedron another material unless that spoils the boundary at a vertex where it is a manifold.
/// @return False if it has been left as it was.
template <RelabelledTets Tets>
bool relabel_if_manifold(Tets& tets, std::uint32_t tet, Material to, LabelStar<Tets>& star) {
  const Material from = tets.material(tet);
  const auto is_manifold_at = [&](std::uint32_t v, Material m) {
    tets.set_material(tet, m);
    star.gather(v);
    return star.is_manifold();
  };
  const std::array<std::uint32_t, 4> corners = tets.corners(tet);
  const bool spoils = std::ranges::any_of(
      corners, [&](std::uint32_t v) { return !is_manifold_at(v, to) && is_manifold_at(v, from); });
  tets.set_material(tet, spoils ? from : to);
  return !spoils;
}

}  // namespace lumesh
