#include "notes.hpp"

#include <fmt/core.h>

#include <cmath>

#include "lumesh/core/counted.hpp"
#include "lumesh/mesh/label_shapes.hpp"

namespace lumesh {

namespace {

/// A bit for each material: it has voxels, but no tetrahedron.
std::vector<bool> lost_materials(const fitting::WorkMesh& mesh, const std::vector<double>& voxels) {
  std::vector<bool> lost(voxels.size());
  for (Material m = 1; m < voxels.size(); ++m) lost[m] = voxels[m] > 0;
  for (const Material m : mesh.materials) lost[m] = false;
  return lost;
}

void note_lost(const fitting::WorkMesh& mesh, const ImageDomain& domain, const std::vector<double>& voxels,
               LatticeReport& report) {
  const std::vector<bool> lost = lost_materials(mesh, voxels);
  for (Material m = 1; m < voxels.size(); ++m) {
    if (!lost[m]) continue;
    report.lost_labels.push_back(domain.label_of(m));
    report.notes.push_back(fmt::format("label {} ({} voxels) is too small for the lattice and is lost",
                                       domain.label_of(m), std::lround(voxels[m])));
  }
}

void note_fit(const fitting::FitReport& fit, LatticeReport& report) {
  report.deviating_points = fit.deviating_points;
  report.furthest_deviation_mm = fit.furthest_deviation_mm;
  if (fit.vertices_beyond > 0)
    report.notes.push_back(fmt::format(
        "{} up to {:.3f} mm beyond the image's border or a cut plane; another `edge_length` helps",
        counted(fit.vertices_beyond, "vertex lies", "vertices lie"), fit.furthest_beyond_mm));
}

void note_limits(const LatticeOptions& options, LatticeReport& report) {
  if (report.levels_given_up > 0)
    report.notes.push_back(
        fmt::format("thin parts are refined {} levels less than wanted, to stay near {} tetrahedra; raise "
                    "`max_tetrahedra`",
                    report.levels_given_up, options.max_tetrahedra));
  if (report.deviating_points > 0)
    report.notes.push_back(fmt::format(
        "the surface and the image's boundary are up to {:.2f} mm apart ({} points are off by more than "
        "1.25 voxels); a smaller `edge_length` or higher `fidelity` helps",
        report.furthest_deviation_mm, report.deviating_points));
}

/// Labels that are too thin for the lattice fill another volume than their voxels.
void note_volumes(const fitting::WorkMesh& mesh, const ImageDomain& domain, const std::vector<double>& voxels,
                  LatticeReport& report) {
  const std::vector<double> filled = fitting::material_volumes_mm3(mesh, voxels.size());
  std::size_t count = 0;
  double worst = 0;
  Label label = 0;
  for (Material m = 1; m < filled.size(); ++m) {
    const double wanted = voxels[m] * domain.frame().voxel_volume_mm3();
    const bool is_below_one_voxel = voxels[m] < 1;       // Grazed by a cut plane.
    if (filled[m] <= 0 || is_below_one_voxel) continue;  // Lost labels are reported by note_lost().
    const double change = filled[m] / wanted - 1;
    if (std::abs(change) <= much_of_volume(voxels[m])) continue;
    ++count;
    if (std::abs(change) <= std::abs(worst)) continue;
    worst = change;
    label = domain.label_of(m);
  }
  if (count == 0) return;
  report.notes.push_back(volume_text(label, worst, count) +
                         "; a smaller `edge_length` or higher `fidelity` helps");
}

}  // namespace

std::vector<Label> lost_labels(const fitting::WorkMesh& mesh, const ImageDomain& domain,
                               const std::vector<double>& voxels) {
  const std::vector<bool> lost = lost_materials(mesh, voxels);
  std::vector<Label> labels;
  for (Material m = 1; m < voxels.size(); ++m)
    if (lost[m]) labels.push_back(domain.label_of(m));
  return labels;
}

void add_shortcomings(const fitting::WorkMesh& mesh, const fitting::FitReport& fit, const ImageDomain& domain,
                      const LatticeOptions& options, const std::vector<double>& voxels,
                      LatticeReport& report) {
  note_lost(mesh, domain, voxels, report);
  note_fit(fit, report);
  note_limits(options, report);
  note_volumes(mesh, domain, voxels, report);
}

}  // namespace lumesh
