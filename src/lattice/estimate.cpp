#include <cmath>
#include <numeric>

#include "lumesh/image/selection.hpp"
#include "lumesh/lattice/lattice.hpp"
#include "refinement.hpp"
#include "size_grid.hpp"

namespace lumesh {
namespace {

/// Level of the lattice there, as Refiner decides it for the tetrahedra around.
int level_at(const Vec3& place, const SizeGrid& sizes, double coarsest_mm, int levels) {
  int level = 0;
  while (level < levels &&
         sizes.level_wanted(place, kRefinementReach * coarsest_mm / std::exp2(level)) > level)
    ++level;
  return level;
}

}  // namespace

double estimated_tetrahedra(const LabelImage& image, const ImageDomain& domain,
                            const LatticeOptions& options) {
  // What tetrahedra of two sizes need between them adds some; measured on phantoms and aneurysms.
  constexpr double kTetsPerCube = 12, kTransitions = 1.04;
  constexpr std::size_t kPlaces = 20000;
  options.validate();
  options.require_labels_of(image);
  const std::vector<double> of_labels = count_kept_voxels(image, domain.cut_planes());
  const double voxels = std::accumulate(of_labels.begin(), of_labels.end(), 0.0);
  const auto object_voxels = static_cast<std::size_t>(std::ceil(voxels));
  const double coarsest_mm =
      SizeGrid::boundary_spacing_mm(image, domain, options) * std::exp2(options.coarsening);
  const int levels = options.coarsening + options.max_refinement;
  const SizeGrid sizes(image, domain, options, coarsest_mm, object_voxels, OpeningSizes(domain));
  std::vector<Vec3> places = sample_object(image, kPlaces).places;
  std::erase_if(places, [&](const Vec3& place) { return domain.material_at(place) == 0; });  // Beyond cuts.
  if (places.empty()) return 0;
  double sum = 0;
  for (const Vec3& place : places) sum += std::exp2(3 * level_at(place, sizes, coarsest_mm, levels));
  const double volume_mm3 = voxels * domain.frame().voxel_volume_mm3();
  return kTransitions * kTetsPerCube * volume_mm3 / std::pow(coarsest_mm, 3) * sum /
         static_cast<double>(places.size());
}

}  // namespace lumesh
