#pragma once
/// @file Shorter edges at openings that a mesh does not have as its domain has them.

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/domain/walls_in_planes.hpp"

namespace lumesh {

/// Longest edges within a disc around an opening.
struct OpeningSize {
  Vec3 centre_mm, normal;
  double radius_mm;
  double edge_mm;

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
    std::size_t weight = 0;          ///< Of all; openings that are wrong, and walls, weigh twice.
    std::vector<std::size_t> which;  ///< Numbers of openings.
    std::vector<double> edges_mm;    ///< The mean edges of their rims; 0 without one.
    std::vector<WallInPlane> walls = {};
  };
  [[nodiscard]] Faults faults_in(const MeshView& mesh) const;

  /// Halves the edges at faulty openings. False if that is in vain: they are much shorter than voxels.
  bool refine(const Faults& faults);

  /// The names of openings and walls with sizes, joined by commas.
  [[nodiscard]] std::string names() const;

 private:
  const Domain* domain_;
  std::vector<Opening> openings_;
  std::vector<double> edges_mm_;  // Of each opening; infinity: any.
  std::vector<OpeningSize> at_walls_;
  std::vector<OpeningSize> sizes_;
};

/// The mesh that has the openings of its domain best of up to three. The second and third have shorter edges
/// at openings that the one before does not have as they are; with one that has all as they are it ends.
/// @param make  Makes a mesh: const OpeningSizes& -> Mesh.
/// @param faults_in  Calls OpeningSizes::faults_in() for one: const OpeningSizes&, const Mesh& -> Faults.
/// @param is_complete  False for one whose making was told to stop, which ends the attempts.
template <class Make, class FaultsIn, class IsComplete>
auto best_at_openings(const Domain& domain, Context& context, const Make& make, const FaultsIn& faults_in,
                      const IsComplete& is_complete) {
  constexpr int kAttempts = 3;
  OpeningSizes sizes(domain);
  auto best = make(std::as_const(sizes));
  if (!sizes.has_planes() || !is_complete(best)) return best;
  OpeningSizes::Faults best_faults = faults_in(sizes, best), faults = best_faults;
  for (int attempt = 1; attempt < kAttempts && faults.weight > 0 && sizes.refine(faults); ++attempt) {
    context.info("meshed again with shorter edges at " + sizes.names());
    auto next = make(std::as_const(sizes));
    if (!is_complete(next)) break;
    faults = faults_in(sizes, next);
    if (faults.weight >= best_faults.weight) continue;
    best = std::move(next);
    best_faults = faults;
  }
  return best;
}

}  // namespace lumesh
