#pragma once
/// @file Shorter edges at openings that a mesh does not have as its domain has them.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/domain/walls_in_planes.hpp"
#include "lumesh/parallel/cancellation.hpp"

namespace lumesh {

/// Longest edges within a disc around an opening.
struct OpeningSize {
  Vec3 centre_mm, normal;
  double radius_mm;
  double edge_mm;
  int halvings;  ///< Number of times that edges are halved from those of the first mesh.

  /// Distance of a place from the disc.
  [[nodiscard]] double distance_mm(const Vec3& place) const;
};

/// The openings of a domain, and sizes at them that meshes of it turned out to need.
class OpeningSizes {
 public:
  /// @param domain  Lives as long as this.
  explicit OpeningSizes(const Domain& domain);

  /// Whether the domain may have openings.
  [[nodiscard]] bool has_planes() const { return !openings_.empty() || !domain_->cut_planes().empty(); }
  [[nodiscard]] std::span<const Opening> openings() const { return openings_; }
  [[nodiscard]] std::span<const OpeningSize> sizes() const { return sizes_; }

  /// Openings that a mesh does not have as its domain has them.
  struct Faults {
    std::size_t weight = 0;          ///< Sum of the faults; openings that are wrong, and walls, weigh twice.
    std::vector<std::size_t> which;  ///< Numbers of openings.
    std::vector<double> edges_mm;    ///< The mean edges of their rims; 0 without one.
    std::vector<WallInPlane> walls = {};
  };
  [[nodiscard]] Faults faults_in(const MeshView& mesh) const;

  /// Halves the edges at faulty openings. False if that is in vain: they are much shorter than voxels, or the
  /// openings of a voxel or two.
  bool refine(const Faults& faults);

  /// The shortest edges of sizes(), and the names of openings and walls that have them.
  [[nodiscard]] std::string text() const;

 private:
  const Domain* domain_;
  std::vector<Opening> openings_;
  std::vector<double> edges_mm_;  // Of each opening; infinity: any.
  std::vector<int> halvings_;     // Of each opening.
  std::vector<OpeningSize> at_walls_;
  std::vector<OpeningSize> sizes_;
};

/// Result of best_at_openings().
template <class Mesh>
struct BestAtOpenings {
  Mesh mesh;
  bool is_complete = true;  ///< False if it was told to stop, and other meshes were not tried for that.
};

/// Most cells of a mesh that is made again, where the first one has so many.
[[nodiscard]] std::size_t max_cells_made_again(std::size_t cells);

/// The mesh that has the openings of its domain best of up to three. The second and third have shorter edges
/// at openings that the one before does not have as they are; with one that has all as they are it ends. A
/// stop during these attempts ends them, and keeps the best mesh so far (Context::results_exist()).
/// @param make  Makes a mesh: const OpeningSizes& -> Mesh.
/// @param faults_in  Calls OpeningSizes::faults_in() for one: const OpeningSizes&, const Mesh& -> Faults.
/// @param may_replace  Whether a mesh is otherwise about as good as the first one: const Mesh& -> bool.
/// @param is_complete  False for one whose making was told to stop.
template <class Make, class FaultsIn, class MayReplace, class IsComplete>
auto best_at_openings(const Domain& domain, Context& context, const Make& make, const FaultsIn& faults_in,
                      const MayReplace& may_replace, const IsComplete& is_complete) {
  constexpr int kAttempts = 3;
  OpeningSizes sizes(domain);
  BestAtOpenings<decltype(make(std::as_const(sizes)))> best{make(std::as_const(sizes))};
  best.is_complete = is_complete(best.mesh);
  if (!sizes.has_planes() || !best.is_complete) return best;
  OpeningSizes::Faults best_faults = faults_in(sizes, best.mesh), faults = best_faults;
  std::optional<decltype(best.mesh)> next;
  for (int attempt = 1; attempt < kAttempts && faults.weight > 0 && sizes.refine(faults); ++attempt) {
    context.info("openings of the mesh are not those of the input: made again with edges of " + sizes.text());
    context.results_exist();
    try {
      parallel::run_cancellable(context.stop_token(), [&] { next.emplace(make(std::as_const(sizes))); });
    } catch (const parallel::Cancelled&) {
      best.is_complete = false;
      break;
    }
    best.is_complete = is_complete(*next);
    if (!best.is_complete) break;
    faults = faults_in(sizes, *next);
    const bool is_better = faults.weight < best_faults.weight;
    if (!is_better || !may_replace(*next)) {
      context.info(is_better ? "its cells are too many, or too bad: the mesh before is kept"
                             : "its openings are no better: the mesh before is kept");
      if (is_better) break;
      continue;
    }
    best.mesh = std::move(*next);
    best_faults = faults;
  }
  return best;
}

}  // namespace lumesh
