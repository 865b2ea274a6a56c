#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/quality/topology_places.hpp"
#include "lumesh/report/summary.hpp"
#include "numbers.hpp"

namespace lumesh::report {

namespace {

using namespace lumesh::quality;

constexpr std::size_t kMaxLabels = 24;  // Longer tables go to JSON and the report.

std::string counts_text(const Evaluation& e) {
  const MeshStatistics& m = e.statistics;
  std::string text = fmt::format("{:<15}", e.valid() ? "valid" : "INVALID");
  text += fmt::format("{} tetrahedra", grouped(m.tetrahedra.count));
  if (m.pyramids) text += fmt::format(", {} pyramids", grouped(m.pyramids));
  if (m.prisms) text += fmt::format(", {} prisms", grouped(m.prisms));
  if (m.hexahedra) text += fmt::format(", {} hexahedra", grouped(m.hexahedra));
  text += fmt::format(", {} vertices\n", grouped(m.vertices));
  for (std::size_t i = 0; i < std::min<std::size_t>(5, e.problems.size()); ++i)
    text += fmt::format("  problem: {}\n", e.problems[i]);
  if (e.problem_count > 5) text += fmt::format("  {} problems in all\n", grouped(e.problem_count));
  return text;
}

std::string quality_text(const Evaluation& e) {
  const TetrahedronStatistics& t = e.statistics.tetrahedra;
  std::string text;
  if (t.count > 0) {
    const auto &low = t.smallest_dihedral_deg, &high = t.largest_dihedral_deg;
    text += fmt::format("dihedral       {:.2f}° at {}  to  {:.2f}° at {}\n", low.value,
                        decimals_text(low.centre_mm, 1), high.value, decimals_text(high.centre_mm, 1));
    text += fmt::format(
        "               mean of smallest {:.1f}°; tetrahedra below 5/10/15°: {}/{}/{}, above 150/160/165°: "
        "{}/{}/{}\n",
        t.mean_smallest_dihedral_deg, t.below_5_deg, t.below_10_deg, t.below_15_deg, t.above_150_deg,
        t.above_160_deg, t.above_165_deg);
    text += fmt::format(
        "mean ratio     min {:.3f}  mean {:.3f}      aspect  max {:.2f}  mean {:.2f}      mean edge {:.3g} "
        "mm\n",
        t.smallest_mean_ratio.value, t.mean_mean_ratio, t.largest_aspect.value, t.mean_aspect,
        t.mean_edge_mm);
  }
  if (e.statistics.pyramids + e.statistics.prisms + e.statistics.hexahedra > 0)
    text += fmt::format("other cells    scaled Jacobian min {:.3f}\n", e.statistics.smallest_scaled_jacobian);
  return text;
}

std::string band_text(const EdgeBand& band) {
  return fmt::format("{:.1f} % in [0.71, 1.41], {:.1f} % below, {:.1f} % above",
                     100 * band.fraction_in_band(), 100 * band.fraction_short(), 100 * band.fraction_long());
}

std::string metric_text(const MetricStatistics& m) {
  std::string text = fmt::format("metric edges   {};  min {:.3f}  mean {:.3f}  max {:.3f}\n", band_text(m),
                                 m.shortest_edge, m.mean_edge, m.longest_edge);
  if (m.free_edges && m.free_edges->edges > 0)
    text += fmt::format("  free          {};  {} edges with an end inside\n", band_text(*m.free_edges),
                        grouped(m.free_edges->edges));
  text += fmt::format("metric ratio   min {:.3f}  mean {:.3f};  {} tetrahedra below 0.1\n",
                      m.smallest_mean_ratio.value, m.mean_mean_ratio, grouped(m.poor_tetrahedra));
  return text + fmt::format("complexity     {};  per unit {:.2f} vertices, {:.2f} tetrahedra\n",
                            five_digits(m.complexity), m.vertices_per_complexity(),
                            m.tetrahedra_per_complexity());
}

std::string boundary_text(const Evaluation& e) {
  const SurfaceTopology& b = e.boundary;
  std::string text =
      fmt::format("boundary       {}, {}, {}, genus {}, {} triangles", b.closed() ? "closed" : "OPEN",
                  b.manifold() ? "manifold" : "NOT MANIFOLD", counted(b.components.size(), "component"),
                  b.genus() < 0 ? "–" : std::to_string(b.genus()), grouped(b.triangles));
  if (e.interface_triangles) text += fmt::format(", {} between labels", grouped(e.interface_triangles));
  text += "\n";
  if (!b.manifold())
    text += fmt::format("               {} open and {} non-manifold edges, {} non-manifold vertices\n",
                        b.open_edges, b.non_manifold_edges, b.non_manifold_vertices);
  for (std::size_t i = 0; i < std::min(kMaxLabels, e.patches.size()); ++i) {
    const PatchSummary& p = e.patches[i];
    text += fmt::format("  {:<12} {:>8} faces {:>10} mm²   angles from {:.1f}°", p.name, grouped(p.faces),
                        five_digits(p.area_mm2), p.smallest_angle_deg);
    if (is_plane(p.kind)) text += fmt::format("   flat within {:.2g} mm", std::max(p.flatness_mm, 1e-3));
    text += "\n";
  }
  if (e.patches.size() > kMaxLabels)
    text += fmt::format("  … {} more patches\n", e.patches.size() - kMaxLabels);
  const CurvatureSummary& c = e.curvature;
  if (c.vertices > 0)
    text += fmt::format(
        "curvature      r.m.s. {:.3g}  mean {:.3g}  96 % from {:.3g} to {:.3g} 1/mm (mean curvature of the "
        "wall)\n",
        c.root_mean_square_per_mm, c.mean_per_mm, c.p2_per_mm, c.p98_per_mm);
  return text;
}

std::string union_row(const Evaluation& e) {
  return fmt::format("{:<22}{:>12}{:>12}{:>9}\n", "all", five_digits(e.volume_mm3()),
                     five_digits(e.image->all.volume_mm3),
                     fmt::format("{:+.2f}", e.image_volume_error_percent()));
}

std::string differences_text(const std::vector<std::string>& differences) {
  std::string text;
  for (std::size_t i = 0; i < std::min(kMaxLabels, differences.size()); ++i)
    text += "topology differs: " + differences[i] + "\n";
  if (differences.size() > kMaxLabels)
    text += fmt::format("… of {} more labels\n", differences.size() - kMaxLabels);
  return text;
}

std::string places_text(const std::vector<TopologyPlace>& places) {
  constexpr std::size_t kMaxPlaces = 12;
  std::string text;
  for (std::size_t i = 0; i < std::min(kMaxPlaces, places.size()); ++i) {
    text += fmt::format("  label {} at {} mm: {}\n", places[i].label, decimals_text(places[i].centre_mm, 2),
                        in_words(places[i]));
  }
  if (places.size() > kMaxPlaces)
    text += fmt::format("  … {} more places, which the JSON lists\n", places.size() - kMaxPlaces);
  return text;
}

std::string labels_text(const Evaluation& e) {
  std::string text = fmt::format("\n{:<22}{:>12}{:>12}{:>9}{:>13}{:>12}  {}\n", "label", "volume mm³",
                                 "image mm³", "error %", "components", "Euler", "surface");
  for (std::size_t i = 0; i < std::min(kMaxLabels, e.labels.size()); ++i) {
    const LabelEvaluation& l = e.labels[i];
    const std::string name = l.name.empty() ? std::to_string(l.label) : fmt::format("{} {}", l.label, l.name);
    const auto of_image = [&](auto value, auto image) {
      return l.image ? fmt::format("{} ({})", value, image) : fmt::format("{}", value);
    };
    text += fmt::format("{:<22.22}{:>12}{:>12}{:>9}{:>13}{:>12}  {}\n", name, five_digits(l.volume_mm3),
                        l.image ? five_digits(l.image->volume_mm3) : "–",
                        l.image ? fmt::format("{:+.2f}", l.image_volume_error_percent()) : "–",
                        of_image(l.components, l.image ? l.image->component_count : 0),
                        of_image(l.euler, l.image ? l.image->euler_number : 0),
                        l.lost()               ? "LOST"
                        : l.cells == 0         ? "cut off"
                        : l.surface.manifold() ? "manifold"
                                               : "NOT MANIFOLD");
  }
  if (e.labels.size() > kMaxLabels) text += fmt::format("… {} more labels\n", e.labels.size() - kMaxLabels);
  if (e.image && e.labels.size() > 1) text += union_row(e);
  const auto lost = std::ranges::count_if(e.labels, [](const auto& l) { return l.lost(); });
  if (lost > 0) text += fmt::format("{} of {} labels are not in the mesh\n", lost, e.labels.size());
  if (e.image) text += "in brackets: the voxels of the image, joined through faces";
  if (e.image && e.cut_planes > 0) text += ", as if it were not cut; volumes: of what the cuts keep";
  if (e.image) text += "\n";
  return text + differences_text(e.topology_differences) + places_text(e.topology_places);
}

std::string kept_row(const std::string& name, const KeptVoxels& kept, double voxel) {
  if (kept.counted == 0) return "";
  std::string text =
      fmt::format("  {:<10}{:>9} %{:>10}{:>12}", name, fmt::format("{:.3f}", 100 * kept.share()),
                  grouped(kept.counted - kept.kept), grouped(kept.counted));
  if (const auto& worst = kept.worst) {
    text += fmt::format("{:>8.3f}{:>8.3g}  {}  {}", worst->distance_mm / voxel, worst->distance_mm,
                        decimals_text(worst->centre_mm, 1), voxel_text(worst->voxel, " "));
  }
  return text + "\n";
}

std::string kept_text(const Evaluation& e) {
  std::string text = fmt::format("\n{:<12}{:>11}{:>10}{:>12}{:>8}{:>8}  {}\n", "voxels kept", "share",
                                 "missed", "of", "voxels", "mm", "the farthest, at mm and voxel");
  const double voxel = e.image->voxel_size_mm;
  std::size_t rows = 0;
  for (const LabelEvaluation& l : e.labels)
    if (l.voxels_kept && rows++ < kMaxLabels)
      text += kept_row(fmt::format("label {}", l.label), *l.voxels_kept, voxel);
  if (rows > kMaxLabels) text += fmt::format("  … {} more labels\n", rows - kMaxLabels);
  text += kept_row("background", e.image->background_kept, voxel);
  return text + kept_row("all", e.image->voxels_kept, voxel);
}

std::string openings_text(const OpeningsCompared& compared) {
  if (compared.openings.empty() && compared.others.empty()) return "";
  std::string text = fmt::format("\n{:<34}{:>12}{:>14}{:>11}{:>11}  {}\n", "openings", "mesh mm²",
                                 "image mm²", "change", "radius mm", "centre and normal");
  for (const OpeningInMesh& o : compared.openings) {
    text += fmt::format("  {:<32}{:>12}{:>13}{:>9.1f} %{:>11}  {}  {}{}\n",
                        o.patches.empty() ? "none" : o.patches, five_digits(o.mesh_area_mm2),
                        five_digits(o.opening.area_mm2), o.change_percent(),
                        five_digits(o.opening.radius_mm()), decimals_text(o.opening.centre_mm, 1),
                        decimals_text(o.opening.normal, 2), is_wrong(o) ? "  WRONG" : "");
  }
  for (const std::string& name : compared.others) text += fmt::format("  {:<32}none of the image's\n", name);
  return text;
}

/// The branches that lose most.
std::string sections_text(std::vector<NarrowestSection> sections, bool has_labels) {
  constexpr std::size_t kMaxBranches = 12;
  if (sections.empty()) return "";
  std::ranges::stable_sort(
      sections, [](const auto& a, const auto& b) { return a.change_percent() < b.change_percent(); });
  std::string text = fmt::format("\n{:<24}{:>12}{:>14}{:>11}  {}\n", "narrowest sections", "mesh mm²",
                                 "voxels mm²", "change", "at mm");
  for (std::size_t i = 0; i < std::min(kMaxBranches, sections.size()); ++i) {
    const NarrowestSection& s = sections[i];
    text +=
        fmt::format("  branch {:<15}{:>12}{:>13}{:>9.1f} %  {}{}\n", s.branch, five_digits(s.mesh_area_mm2),
                    five_digits(s.voxel_area_mm2), s.change_percent(), decimals_text(s.centre_mm, 1),
                    s.tightened() ? "  TIGHTENED"
                    : s.widened() ? "  WIDENED"
                                  : "");
  }
  if (sections.size() > kMaxBranches)
    text += fmt::format("  … {} more branches that lose less\n", sections.size() - kMaxBranches);
  if (has_labels) text += "  (all labels count together: a lumen with its wall)\n";
  return text;
}

std::string distance_row(const std::string& name, const DistanceSummary& d, double unit) {
  return fmt::format("  {:<34}{:>10.3f}{:>10.3f}{:>10.3f}\n", name, d.mean / unit, d.p95 / unit,
                     d.max / unit);
}

std::string distances_text(const std::string& title, const SurfaceDistances& d, double voxel) {
  std::string text = fmt::format("{:<36}{:>10}{:>10}{:>10}\n", title, "mean", "95 %", "max");
  text += distance_row("mesh to image", d.mesh_to_image_mm, voxel);
  text += distance_row("image to mesh", d.image_to_mesh_mm, voxel);
  text += fmt::format("  {:<34}{:>30.3f}   (to voxels {:.3f}, to vertices {:.3f})\n",
                      "vertices and voxels, two-sided", d.vertex_to_voxel_two_sided_mm / voxel,
                      d.vertices_to_voxels_mm / voxel, d.voxels_to_vertices_mm / voxel);
  return text;
}

std::string image_text(const Evaluation& e) {
  const double voxel = e.image->voxel_size_mm;
  std::string text = fmt::format("\ndistances in voxels of {:.4g} mm\n", voxel);
  if (e.image->distances) text += distances_text("whole surface", *e.image->distances, voxel);
  std::size_t with_distances = 0;
  const LabelEvaluation* worst = nullptr;
  const auto reach = [](const LabelEvaluation& l) {
    return std::max(l.distances->mesh_to_image_mm.max, l.distances->image_to_mesh_mm.max);
  };
  for (const LabelEvaluation& l : e.labels) {
    if (!l.distances) continue;
    if (!worst || reach(l) > reach(*worst)) worst = &l;
    ++with_distances;
  }
  if (with_distances > 1)
    text += distances_text(fmt::format("label {} (the worst)", worst->label), *worst->distances, voxel);
  text += kept_text(e);
  if (e.openings) text += openings_text(*e.openings);
  if (e.sections) text += sections_text(*e.sections, e.labels.size() > 1);
  return text;
}

std::string reference_text(const Evaluation& e) {
  std::string text = fmt::format("\nagainst the phantom{:>27}{:>10}{:>10}\n", "mean", "95 %", "max");
  for (const LabelEvaluation& l : e.labels) {
    if (!l.reference) continue;
    const LabelReference& r = *l.reference;
    const std::string volume = e.cut_planes > 0
                                   ? "volume not compared because of the cuts"
                                   : fmt::format("volume {:+.3f} %", l.reference_volume_error_percent());
    text += fmt::format("  label {}: {}, components {} (truth {}), Euler {} (truth {})\n", l.label, volume,
                        l.components, r.components, l.euler, r.euler);
    if (r.surface_distance_mm)
      text += distance_row("  mesh to truth, voxels", *r.surface_distance_mm, *e.reference_voxel_mm);
    if (r.truth_to_mesh_mm)
      text += distance_row("  truth to mesh, voxels", *r.truth_to_mesh_mm, *e.reference_voxel_mm);
    if (r.normal_angle_deg) text += distance_row("  angle of normals, degrees", *r.normal_angle_deg, 1);
  }
  return text;
}

}  // namespace

std::string grouped(std::uint64_t count) {
  const std::string digits = std::to_string(count);
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text.push_back(',');
    text.push_back(digits[i]);
  }
  return text;
}

std::string five_digits(double value) {
  if (!(value >= 1e4 && value < 1e15)) return fmt::format("{:.5g}", value);
  return grouped(static_cast<std::uint64_t>(std::llround(value)));
}

std::string voxel_text(const std::optional<Index3>& voxel, std::string_view between) {
  if (!voxel) return "beyond the image";
  return fmt::format("{}{}{}{}{}", voxel->x(), between, voxel->y(), between, voxel->z());
}

std::string summary_text(const Evaluation& e) {
  std::string text = counts_text(e) + quality_text(e);
  if (e.metric) text += metric_text(*e.metric);
  text += boundary_text(e) + labels_text(e);
  if (e.image) text += image_text(e);
  if (e.reference_voxel_mm) text += reference_text(e);
  return text;
}

}  // namespace lumesh::report
