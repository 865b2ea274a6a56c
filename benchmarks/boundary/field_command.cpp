#include <fmt/core.h>

#include <cmath>

#include "commands.hpp"
#include "field.hpp"
#include "references.hpp"
#include "shapes.hpp"
#include "table.hpp"

namespace lumesh::boundary {

namespace {

nlohmann::ordered_json json_of(const std::string& name, int seed, const FieldFigures& f) {
  return {{"case", name},
          {"seed", seed},
          {"points", f.points},
          {"lost_percent", f.lost_percent},
          {"mean_voxels", f.mean_mm},
          {"roughness_voxels", f.roughness_mm},
          {"aligned_roughness_voxels", f.aligned_mm},
          {"furthest_voxels", f.furthest_mm},
          {"normal_deg", f.normal_deg},
          {"radius_percent", f.radius_percent},
          {"radius_variation_percent", f.radius_variation_percent},
          {"volume_percent", f.volume_percent},
          {"voxel_volume_percent", f.voxel_volume_percent},
          {"border_roughness_voxels", f.border_roughness_mm},
          {"border_normal_deg", f.border_normal_deg},
          {"wrong_voxels", f.wrong_voxels},
          {"components", {f.voxels.component_count, f.samples.component_count}},
          {"euler", {f.voxels.euler_number, f.samples.euler_number}},
          {"domain_seconds", f.seconds}};
}

/// Figures of one case over its seeds.
struct Row {
  Summary lost, mean, roughness, aligned, normal, radius, variation, volume, border, border_normal, wrong,
      seconds;
  double furthest = 0;
  int other_topology = 0;

  void add(const FieldFigures& f) {
    lost.add(f.lost_percent);
    mean.add(f.mean_mm);
    roughness.add(f.roughness_mm);
    aligned.add(f.aligned_mm);
    normal.add(f.normal_deg);
    radius.add(f.radius_percent);
    variation.add(f.radius_variation_percent);
    volume.add(f.volume_percent);
    border.add(f.border_roughness_mm);
    border_normal.add(f.border_normal_deg);
    wrong.add(static_cast<double>(f.wrong_voxels));
    seconds.add(f.seconds);
    furthest = std::max(furthest, f.furthest_mm);
    other_topology += f.same_topology() ? 0 : 1;
  }
};

constexpr const char* kLayout =
    "{:<28} {:>7} {:>12} {:>12} {:>11} {:>7} {:>12} {:>6} {:>12} {:>5} {:>6} {:>6} {:>6} {:>4} {:>6} {:>5}  "
    "{}\n";

void print_head() {
  fmt::print(
      "R.m.s. over the seeds in voxels (the smallest edge), degrees and per cent; `mean', `radius' and the\n"
      "volume are means, max the largest. x/y: figure / reference, good within 1.2 of it. border: within 4\n"
      "voxels of the image's border. topo: images of another topology than their voxels'.\n");
  fmt::print(kLayout, "case", "mean", "rough", "aligned", "normal", "radius", "its rms", "var", "volume",
             "max", "lost%", "border", "normal", "topo", "wrong", "s", "verdict");
}

Tally print_row(const std::string& name, const Row& row) {
  const Reference ref = reference_of(name);
  Tally tally;
  const std::string rough = tally.judge("rough", row.roughness.root_mean_square(), ref.roughness, 3, 0.002);
  const std::string aligned =
      tally.judge("aligned", row.aligned.root_mean_square(), ref.aligned_roughness, 3, 0.002);
  const std::string normal = tally.judge("normal", row.normal.root_mean_square(), ref.normal_deg, 2, 0.02);
  const std::string radius =
      tally.judge("radius", row.radius.root_mean_square(), ref.radius_percent, 2, 0.05);
  const std::string volume = tally.judge("volume", row.volume.mean(), ref.volume_percent, 1, 0.3);
  fmt::print(kLayout, name, number(row.mean.mean(), 3), rough, aligned, normal, number(row.radius.mean(), 2),
             radius, number(row.variation.root_mean_square(), 2), volume, number(row.furthest, 2),
             number(row.lost.mean(), 1), number(row.border.root_mean_square(), 3),
             number(row.border_normal.root_mean_square(), 1), row.other_topology, number(row.wrong.mean(), 0),
             number(row.seconds.mean(), 2), tally.verdict());
  std::fflush(stdout);
  return tally;
}

}  // namespace

void run_field(const RunOptions& options) {
  JsonLines lines(options.json_path);
  print_head();
  int compared = 0, good = 0, other_topology = 0, images = 0;
  std::vector<Case> cases = all_cases();
  const std::vector<Case> of_values = value_cases();
  cases.insert(cases.end(), of_values.begin(), of_values.end());
  for (const Case& c : cases) {
    if (!matches(c.name, options)) continue;
    Row row;
    for (int seed = options.first_seed; seed < options.first_seed + options.seeds; ++seed) {
      const auto number_of_seed = static_cast<std::uint64_t>(seed);
      const Shape shape = c.make(number_of_seed);
      const FieldFigures figures =
          measure_field(shape, labels_of(shape, c.error, number_of_seed), number_of_seed);
      lines.write(json_of(c.name, seed, figures));
      row.add(figures);
      ++images;
    }
    const Tally tally = print_row(c.name, row);
    compared += tally.compared();
    good += tally.good();
    other_topology += row.other_topology;
  }
  fmt::print("{} of {} figures within 1.2 of their reference; topology differs in {} of {} images\n", good,
             compared, other_topology, images);
}

}  // namespace lumesh::boundary
