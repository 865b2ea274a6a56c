#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <map>

#include "commands.hpp"
#include "field.hpp"
#include "lumesh/core/error.hpp"
#include "mesh_figures.hpp"
#include "meshers.hpp"
#include "table.hpp"

namespace lumesh::boundary {

namespace {

/// Spacing of vertices, in radii and at least, in mm.
double spacing_for(const Shape& shape) {
  return std::max(0.6, 0.4 * shape.radius_mm);
}

/// Normals of a wall may be off by this many times what flat triangles cost, and by what the domain's are.
constexpr double kFloors = 1.5;

nlohmann::ordered_json json_of(const std::string& name, int seed, Mesher mesher, const MeshFigures& f,
                               double field_normal_deg) {
  return {{"case", name},
          {"seed", seed},
          {"mesher", name_of(mesher)},
          {"tetrahedra", f.tetrahedra},
          {"wall_vertices", f.wall_vertices},
          {"distance_max_voxels", f.distance_max_mm},
          {"distance_rms_voxels", f.distance_rms_mm},
          {"lift_voxels", f.lift_mm},
          {"border_distance_max_voxels", f.border_distance_max_mm},
          {"border_worst", {f.border_worst_mm.x(), f.border_worst_mm.y(), f.border_worst_mm.z()}},
          {"mean_voxels", f.wall.mean_mm},
          {"roughness_voxels", f.wall.roughness_mm},
          {"aligned_roughness_voxels", f.wall.aligned_mm},
          {"normal_deg", f.wall.normal_deg},
          {"floor_normal_deg", f.floor.normal_deg},
          {"field_normal_deg", field_normal_deg},
          {"volume_percent", f.volume_percent},
          {"voxel_volume_percent", f.voxel_volume_percent},
          {"section_radius_percent", f.section_radius_percent},
          {"floor_section_radius_percent", f.floor_section_radius_percent},
          {"radius_variation_percent", f.wall.radius_variation_percent},
          {"mesh_seconds", f.seconds}};
}

struct Row {
  Summary rms, lift, roughness, aligned, normal, floor, field, volume, voxel_volume, radius, floor_radius,
      tetrahedra, seconds;
  double furthest = 0, border_furthest = 0;
  int failures = 0;

  void add(const MeshFigures& f, double field_normal_deg) {
    field.add(field_normal_deg);
    rms.add(f.distance_rms_mm);
    lift.add(f.lift_mm);
    roughness.add(f.wall.roughness_mm);
    aligned.add(f.wall.aligned_mm);
    normal.add(f.wall.normal_deg);
    floor.add(f.floor.normal_deg);
    volume.add(f.volume_percent);
    voxel_volume.add(f.voxel_volume_percent);
    radius.add(f.section_radius_percent);
    floor_radius.add(f.floor_section_radius_percent);
    tetrahedra.add(static_cast<double>(f.tetrahedra));
    seconds.add(f.seconds);
    furthest = std::max(furthest, f.distance_max_mm);
    border_furthest = std::max(border_furthest, f.border_distance_max_mm);
  }
};

constexpr const char* kLayout =
    "{:<28} {:<9} {:>8} {:>7} {:>7} {:>7} {:>7} {:>6} {:>7} {:>12} {:>6} {:>6} {:>7} {:>7} {:>7} {:>7} "
    "{:>6}  {}\n";

void print_head() {
  fmt::print(
      "{}",
      "max, rms, lift: distances of the wall's vertices to the domain's boundary, in voxels: the largest,\n"
      "r.m.s., and mean outwards; border: the largest near the cuts at the image's border, which all else\n"
      "but volumes leaves out. normal: the normals' error and its bound, 1.5 floor + field: the same with\n"
      "the vertices on the exact surface, and the domain's. radius: mean of sections, and its floor.\n"
      "volume, and that of the voxels: against the exact one, per cent.\n");
  fmt::print(kLayout, "case", "mesher", "tets", "max", "border", "rms", "lift", "rough", "aligned", "normal",
             "floor", "field", "volume", "voxels", "radius", "floor", "s", "verdict");
}

Tally print_row(const std::string& name, Mesher mesher, const Row& row) {
  const double floor = row.floor.root_mean_square(), field = row.field.root_mean_square();
  Tally tally;
  const std::string normal =
      tally.judge_bound("normal", row.normal.root_mean_square(), kFloors * floor + field, 2);
  fmt::print(kLayout, name, name_of(mesher), number(row.tetrahedra.mean(), 0), number(row.furthest, 3),
             number(row.border_furthest, 2), number(row.rms.root_mean_square(), 4),
             number(row.lift.mean(), 4), number(row.roughness.root_mean_square(), 3),
             number(row.aligned.root_mean_square(), 3), normal, number(floor, 2), number(field, 2),
             number(row.volume.mean(), 2), number(row.voxel_volume.mean(), 2), number(row.radius.mean(), 2),
             number(row.floor_radius.mean(), 2), number(row.seconds.mean(), 1),
             tally.verdict() + (row.failures > 0 ? fmt::format(", {} not meshed", row.failures) : ""));
  std::fflush(stdout);
  return tally;
}

void measure_one(const Case& c, int seed, std::map<Mesher, Row>& rows, JsonLines& lines) {
  const auto number_of_seed = static_cast<std::uint64_t>(seed);
  const Shape shape = c.make(number_of_seed);
  const LabelImage image = labels_of(shape, c.error, number_of_seed);
  const ImageDomain domain(image, ImageDomainOptions{});
  const double field_normal_deg = measure_field(shape, image, number_of_seed).normal_deg;
  for (const Mesher mesher : kMeshers) {
    const auto start = std::chrono::steady_clock::now();
    try {
      const MixedMesh mesh = mesh_by(mesher, image, domain, spacing_for(shape));
      const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
      MeshFigures figures = measure_mesh(shape, image, domain, mesh, spacing_for(shape));
      figures.seconds = elapsed.count();
      lines.write(json_of(c.name, seed, mesher, figures, field_normal_deg));
      rows[mesher].add(figures, field_normal_deg);
    } catch (const Error& error) {
      lines.write({{"case", c.name}, {"seed", seed}, {"mesher", name_of(mesher)}, {"error", error.what()}});
      ++rows[mesher].failures;
    }
  }
}

}  // namespace

void run_mesh(const RunOptions& options) {
  JsonLines lines(options.json_path);
  print_head();
  int compared = 0, good = 0;
  for (const Case& c : all_cases()) {
    if (!matches(c.name, options)) continue;
    std::map<Mesher, Row> rows;
    for (int seed = options.first_seed; seed < options.first_seed + options.seeds; ++seed)
      measure_one(c, seed, rows, lines);
    for (const Mesher mesher : kMeshers) {
      const Tally tally = print_row(c.name, mesher, rows[mesher]);
      compared += tally.compared();
      good += tally.good();
    }
  }
  fmt::print("{} of {} figures within their bounds\n", good, compared);
}

}  // namespace lumesh::boundary
