#pragma once
/// @file The tetrahedra around a vertex, and whether the boundaries of labels are manifolds there.

#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <vector>

#include "lumesh/core/local_map.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {

inline constexpr std::uint32_t kNoTet = ~std::uint32_t{0};

/// Tetrahedra with a material each, by their numbers, whatever structure holds them.
template <class Tets>
concept LabelledTets = requires(const Tets& tets, std::uint32_t n, std::size_t face, Material m,
                                typename Tets::StarScratch& scratch, std::vector<std::uint32_t>& star) {
  tets.gather_star(n, scratch, star);  // Fills in the tetrahedra around a vertex.
  { tets.corners(n) } -> std::convertible_to<std::array<std::uint32_t, 4>>;
  { tets.behind(n, face) } -> std::same_as<std::uint32_t>;  // Of a face; or kNoTet.
  { tets.material(n) } -> std::same_as<Material>;
  { tets.is_object(m) } -> std::same_as<bool>;
};

/// The tetrahedra around a vertex, numbered from 0, and which of them share a face that holds the vertex.
/// Keep one object per thread and use it again: it then allocates nothing but what parts() returns.
template <LabelledTets Tets>
class LabelStar {
 public:
  using Part = std::vector<std::uint32_t>;  ///< Numbers within the star, ascending.

  explicit LabelStar(const Tets& tets) : mesh_(tets) {}

  /// @param sort  Brings tetrahedra into an order on which results may depend.
  template <class Sort>
  void gather(std::uint32_t vertex, const Sort& sort) {
    mesh_.gather_star(vertex, scratch_, tets_);
    sort(tets_);
    find_materials();
    if (different_.size() > 1) link(vertex);  // Else nobody asks what is connected.
  }
  void gather(std::uint32_t vertex) {
    gather(vertex, [](const std::vector<std::uint32_t>&) {});
  }

  [[nodiscard]] const std::vector<std::uint32_t>& tets() const { return tets_; }
  [[nodiscard]] Material material(std::uint32_t i) const { return materials_[i]; }
  [[nodiscard]] bool is_object(std::uint32_t i) const { return is_object_[i] != 0; }
  /// Each material once, in the order in which tetrahedra have them.
  [[nodiscard]] const std::vector<Material>& materials() const { return different_; }

  /// True if the tetrahedra of each label, those of all others, those of all labels, and those outside are
  /// connected through faces; the outside goes on beyond the hull of the mesh.
  [[nodiscard]] bool is_manifold() {
    if (different_.size() < 2) return true;
    const auto object = [this](std::uint32_t i) { return is_object(i); };
    const auto outside = [this](std::uint32_t i) { return !is_object(i); };
    if (!is_connected(object) || !is_connected(outside, Hull::kConnects)) return false;
    const auto labels = static_cast<std::size_t>(
        std::ranges::count_if(different_, [&](Material m) { return is_object(first_of(m)); }));
    return labels == 1 || std::ranges::all_of(different_, [&](Material m) {
             return !is_object(first_of(m)) || (is_connected(of(m)) && is_connected(all_but(m)));
           });
  }

  enum class Hull : std::uint8_t { kEnds, kConnects };
  /// True of regions of one part, and of none.
  template <class In>
  [[nodiscard]] bool is_connected(const In& in, Hull hull = Hull::kEnds) {
    std::size_t count = 0;
    front_.clear();
    std::uint32_t first = kNone;
    for (std::uint32_t i = 0; i < tets_.size(); ++i) {
      is_left_[i] = in(i) ? 1 : 0;
      if (is_left_[i] == 0) continue;
      ++count;
      first = std::min(first, i);
      if (hull == Hull::kConnects && at_hull_[i] != 0) reach(i);
    }
    if (count > 0 && front_.empty()) reach(first);
    flood();
    return front_.size() == count;
  }
  /// The parts of a region, in the order of their first tetrahedra.
  template <class In>
  [[nodiscard]] std::vector<Part> parts(const In& in) {
    for (std::uint32_t i = 0; i < tets_.size(); ++i) is_left_[i] = in(i) ? 1 : 0;
    std::vector<Part> parts;
    for (std::uint32_t i = 0; i < tets_.size(); ++i) {
      if (is_left_[i] == 0) continue;
      front_.clear();
      reach(i);
      flood();
      std::ranges::sort(front_);
      parts.push_back(front_);
    }
    return parts;
  }
  [[nodiscard]] auto of(Material m) const {
    return [this, m](std::uint32_t i) { return materials_[i] == m; };
  }
  [[nodiscard]] auto all_but(Material m) const {
    return [this, m](std::uint32_t i) { return materials_[i] != m; };
  }

 private:
  void find_materials() {
    materials_.resize(tets_.size());
    different_.clear();
    for (std::size_t i = 0; i < tets_.size(); ++i) {
      materials_[i] = mesh_.material(tets_[i]);
      if (std::ranges::find(different_, materials_[i]) == different_.end())
        different_.push_back(materials_[i]);
    }
  }
  void link(std::uint32_t vertex) {
    const auto count = static_cast<std::uint32_t>(tets_.size());
    for (auto* flags : {&is_object_, &at_hull_, &is_left_}) flags->assign(count, 0);
    links_.resize(count);
    numbers_.clear();
    for (std::uint32_t i = 0; i < count; ++i) {
      numbers_.insert(tets_[i], i);
      is_object_[i] = mesh_.is_object(materials_[i]) ? 1 : 0;
    }
    for (std::uint32_t i = 0; i < count; ++i) link_one(vertex, i);
  }
  void link_one(std::uint32_t vertex, std::uint32_t i) {
    const std::array<std::uint32_t, 4> corners = mesh_.corners(tets_[i]);
    std::size_t n = 0;
    for (std::size_t face = 0; face < 4; ++face) {
      if (corners[face] == vertex) continue;
      const std::uint32_t other = mesh_.behind(tets_[i], face);
      const std::uint32_t* const number = other == kNoTet ? nullptr : numbers_.find(other);
      if (number == nullptr) at_hull_[i] = 1;
      links_[i][n++] = number == nullptr ? kNone : *number;
    }
  }

  void reach(std::uint32_t i) {
    is_left_[i] = 0;
    front_.push_back(i);
  }
  /// Goes on to all that is left of the region and connected to the front.
  void flood() {
    for (std::size_t next = 0; next < front_.size(); ++next)
      for (const std::uint32_t other : links_[front_[next]])
        if (other != kNone && is_left_[other] != 0) reach(other);
  }
  [[nodiscard]] std::uint32_t first_of(Material m) const {
    return static_cast<std::uint32_t>(std::ranges::find(materials_, m) - materials_.begin());
  }

  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  const Tets& mesh_;
  typename Tets::StarScratch scratch_;
  std::vector<std::uint32_t> tets_;
  std::vector<Material> materials_, different_;
  std::vector<std::uint8_t> is_object_, at_hull_, is_left_;
  std::vector<std::array<std::uint32_t, 3>> links_;
  std::vector<std::uint32_t> front_;
  LocalMap<std::uint32_t, std::uint32_t> numbers_;
};

/// Vertices, of vertex(i) for each i below `count`, around which the boundary of a label is not a manifold.
/// Parallel, in the order of i.
template <LabelledTets Tets, class VertexOf>
[[nodiscard]] std::vector<std::uint32_t> non_manifold_among(const Tets& tets, std::size_t count,
                                                            const VertexOf& vertex) {
  return parallel::collect_blocks<std::uint32_t>(
      count, 128, [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& out) {
        LabelStar<Tets> star(tets);
        for (std::size_t i = begin; i < end; ++i) {
          star.gather(vertex(i));
          if (!star.is_manifold()) out.push_back(vertex(i));
        }
      });
}

}  // namespace lumesh
