// Where the patches of a mesh run, by a domain or by their shapes.
#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "lumesh/operators/settling.hpp"

namespace lumesh::operators {
namespace {

constexpr double kNearVoxels = 0.1;  // So near a boundary vertices stand.

/// The part of the outside behind a face: that on whose boundary its corners lie best; none where two are
/// as good, as between the rims of two openings.
std::optional<Material> outside_of(const Domain& domain, const TetMesh& mesh, const Cell<3>& corners,
                                   Material inside) {
  if (domain.label_count() == domain.material_count()) return 0;
  const double near_mm = kNearVoxels * domain.resolution_mm();
  std::optional<Material> best;
  double smallest = std::numeric_limits<double>::infinity(), second = smallest;
  for (Material m = 0; m < domain.material_count(); ++m) {
    if (domain.is_meshed(m)) continue;
    double off = 0;
    for (const std::uint32_t v : corners) {
      off = std::max(off, std::abs(domain.separation_value(mesh.point(VertexId(v)), inside, m)));
      if (off >= second) break;  // Other corners would not make it one of the two nearest.
    }
    if (off < smallest) {
      best = m;
      second = std::exchange(smallest, off);
    } else {
      second = std::min(second, off);
    }
  }
  return second > near_mm ? best : std::nullopt;
}

using Pair = std::array<Material, 2>;  // Inside, outside.

/// A quick look at whether a face on the outside is what others of its patch are.
bool lies_on(const Domain& domain, const TetMesh& mesh, const BoundaryFaces& faces, std::size_t face,
             const Pair& pair) {
  if (faces.tets[face][1].valid() || mesh.label(faces.tets[face][0]) != domain.label_of(pair[0]))
    return false;
  const Vec3& corner = mesh.point(VertexId(faces.triangles[face][0]));
  return domain.label_count() == domain.material_count() ||
         std::abs(domain.separation_value(corner, pair[0], pair[1])) <= kNearVoxels * domain.resolution_mm();
}

/// How many faces of a patch lie on each boundary.
class Votes {
 public:
  /// That most faces so far lie on.
  [[nodiscard]] std::optional<Pair> first() const {
    return of_pairs_.empty() ? std::nullopt : std::optional(of_pairs_.front().pair);
  }
  void add(const Pair& pair) {
    auto found = std::ranges::find_if(of_pairs_, [&](const Vote& v) { return v.pair == pair; });
    if (found == of_pairs_.end()) found = of_pairs_.insert(found, {pair, 0});
    ++found->faces;
    ++faces_;
    if (found->faces > of_pairs_.front().faces) std::iter_swap(found, of_pairs_.begin());
  }
  /// The boundary that the patch is, but for single faces that stretch over its rim.
  [[nodiscard]] std::optional<Pair> clear_winner() const {
    constexpr double kMax = 0.95;
    if (of_pairs_.empty() ||
        static_cast<double>(of_pairs_.front().faces) < kMax * static_cast<double>(faces_))
      return std::nullopt;
    return of_pairs_.front().pair;
  }

 private:
  struct Vote {
    Pair pair;
    std::size_t faces;
  };
  std::vector<Vote> of_pairs_;
  std::size_t faces_ = 0;
};

/// The boundary that each patch is; none for openings, and for patches that are several.
std::vector<std::optional<Pair>> boundaries_of_patches(const TetMesh& mesh, const Domain& domain) {
  const BoundaryFaces faces = mesh.boundary_faces();
  std::vector<Votes> votes(mesh.info().patches.size());
  for (std::size_t i = 0; i < faces.triangles.size(); ++i) {
    Votes& patch = votes[static_cast<std::size_t>(faces.patches[i])];
    if (const auto first = patch.first(); first && lies_on(domain, mesh, faces, i, *first)) {
      patch.add(*first);
      continue;
    }
    const auto inside = domain.material_of(mesh.label(faces.tets[i][0]));
    if (!inside) continue;
    const auto outside = faces.tets[i][1].valid() ? domain.material_of(mesh.label(faces.tets[i][1]))
                                                  : outside_of(domain, mesh, faces.triangles[i], *inside);
    if (outside) patch.add({*inside, *outside});
  }
  std::vector<std::optional<Pair>> pairs;
  for (const Votes& patch : votes) {
    const auto pair = patch.clear_winner();
    pairs.push_back(pair && domain.is_beyond_opening((*pair)[1]) ? std::nullopt : pair);
  }
  return pairs;
}

}  // namespace

std::optional<SurfacePoint> place_on_boundary(const Domain& domain, Material inside, Material outside,
                                              const Vec3& near) {
  constexpr double kOneStep =
      0.05;  // Voxels: from so near, one step of Newton's leaves 1e-3 of that or less.
  FieldSample there = domain.separation(near, inside, outside);
  Vec3 point = near;
  if (std::abs(there.value) <= kOneStep * domain.resolution_mm()) {
    const double squared = there.gradient.squaredNorm();
    if (!(squared > 0)) return std::nullopt;
    point -= there.value / squared * there.gradient;
  } else {
    const double reach_mm = 4 * domain.resolution_mm();
    const auto found = domain.project(near, {inside, outside}, reach_mm);
    if (!found) return std::nullopt;
    point = *found;
    there = domain.separation(point, inside, outside);
    if (!(there.gradient.squaredNorm() > 0)) return std::nullopt;
  }
  return SurfacePoint{point, -there.gradient.normalized()};  // The separation grows towards `inside`.
}

PlaceOnPatch places_in_domain(const TetMesh& mesh, const Domain& domain) {
  return [pairs = boundaries_of_patches(mesh, domain), &domain](
             PatchId patch, const Vec3& near) -> std::optional<SurfacePoint> {
    const std::optional<Pair>& pair = pairs[patch.value];
    if (!pair) return std::nullopt;
    return place_on_boundary(domain, (*pair)[0], (*pair)[1], near);
  };
}

PlaceOnPatch places_on_shapes(const PatchShapes& shapes) {
  return [&shapes](PatchId patch, const Vec3& near) -> std::optional<SurfacePoint> {
    const PatchShape& shape = shapes[patch.value];
    return shape.keeps_volume ? std::optional(shape.surface->closest(near)) : std::nullopt;
  };
}

Stays fixed_points_of(const Domain& domain) {
  if (domain.fixed_points().empty()) return {};
  return [&domain](const Vec3& place) { return domain.is_fixed(place); };
}

KeepWithin within_cuts_of(const Domain& domain) {
  return [&domain](const Vec3& place) { return domain.within_cuts(place); };
}

}  // namespace lumesh::operators
