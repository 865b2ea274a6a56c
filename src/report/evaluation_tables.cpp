#include "evaluation_tables.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "html_parts.hpp"
#include "lumesh/core/counted.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/quality/topology_places.hpp"
#include "numbers.hpp"

namespace lumesh::report {

namespace {

using namespace lumesh::quality;

constexpr std::size_t kMaxRows = 400;

std::string marked(bool good, const std::string& text) {
  return fmt::format("{}{}", good ? "" : "!", text);
}

std::string direction_text(const Vec3& direction) {
  const Vec3 n = (direction.array().abs() < 0.005).select(Vec3::Zero(), direction);  // No "-0.00".
  return fmt::format("{:.2f}, {:.2f}, {:.2f}", n.x(), n.y(), n.z());
}

std::string flatness_text(double flatness_mm) {
  return flatness_mm < 1e-3 ? "0.001 mm" : fmt::format("{:.2g} mm", flatness_mm);
}

void add_distances(Table& table, const std::string& name, const SurfaceDistances& d, double voxel) {
  const auto row = [&](const std::string& what, const DistanceSummary& s) {
    table.push_back({what, fmt::format("{:.3f}", s.mean / voxel), fmt::format("{:.3f}", s.p95 / voxel),
                     fmt::format("{:.3f}", s.max / voxel), fmt::format("{:.3g}", s.max)});
  };
  row(name + ": mesh to image", d.mesh_to_image_mm);
  row(name + ": image to mesh", d.image_to_mesh_mm);
  table.push_back({name + ": vertices and voxel centres, two-sided", "", "",
                   fmt::format("{:.3f}", d.vertex_to_voxel_two_sided_mm / voxel),
                   fmt::format("{:.3g}", d.vertex_to_voxel_two_sided_mm)});
}

/// A number of the mesh, with the image's where that is another; "–" where the mesh has none.
template <class Value, class OfImage>
std::string against(const std::optional<Value>& found, const std::optional<OfImage>& of_image) {
  if (!found) return "–";
  if (!of_image || std::cmp_equal(*found, *of_image)) return std::to_string(*found);
  return fmt::format("{} (image {})", *found, *of_image);
}

std::string table_place(const Vec3& p) {
  return fmt::format("{:.1f}, {:.1f}, {:.1f}", p.x(), p.y(), p.z());
}

void add_kept(Table& table, const std::string& name, const KeptVoxels& kept, double voxel) {
  if (kept.counted == 0 || table.size() > kMaxRows) return;
  std::vector<std::string> row = {name, grouped(kept.counted), grouped(kept.counted - kept.kept),
                                  fmt::format("{:.3f} %", 100 * kept.share())};
  if (const auto& worst = kept.worst)
    row.insert(row.end(),
               {fmt::format("{:.3f}", worst->distance_mm / voxel), fmt::format("{:.3g}", worst->distance_mm),
                table_place(worst->centre_mm), voxel_text(worst->voxel, ", ")});
  else
    row.insert(row.end(), {"–", "–", "", ""});
  table.push_back(row);
}

std::string topology_places(const std::vector<TopologyPlace>& places) {
  if (places.empty()) return "";
  Table table = {{"label", "topology that differs", "at mm", "voxels"}};
  for (const TopologyPlace& p : places) {
    if (table.size() > kMaxRows) break;
    const auto range = [&](int axis) {
      const int low = p.box.low[axis], high = p.box.high[axis] - 1;
      return low == high ? std::to_string(low) : fmt::format("{}–{}", low, high);
    };
    table.push_back({std::to_string(p.label), in_words(p), table_place(p.centre_mm),
                     fmt::format("{}, {}, {}", range(0), range(1), range(2))});
  }
  return table_html(table);
}

/// Kinds of the patches that an opening is, joined by " + "; each once.
std::string kinds_of(const Evaluation& e, const std::string& patches) {
  constexpr std::string_view kBetween = " + ";
  std::string kinds;
  for (std::size_t at = 0; at <= patches.size();) {
    const std::size_t end = std::min(patches.find(kBetween, at), patches.size());
    const std::string name = patches.substr(at, end - at);
    at = end + kBetween.size();
    for (const PatchSummary& p : e.patches)
      if (const std::string kind(kind_word(p.kind, p.flow));
          p.name == name && kinds.find(kind) == std::string::npos)
        kinds += (kinds.empty() ? "" : ", ") + kind;
  }
  return kinds;
}

}  // namespace

std::string labels_section(const Evaluation& e) {
  Table table = {{"label", "cells", "volume mm³"}};
  if (e.image) table[0].insert(table[0].end(), {"voxels mm³", "error"});
  table[0].insert(table[0].end(), {"components", "cavities", "handles", "Euler number", "surface"});
  for (const LabelEvaluation& l : e.labels) {
    if (table.size() > kMaxRows) break;
    std::vector<std::string> row = {
        escaped(l.name.empty() ? std::to_string(l.label) : fmt::format("{} {}", l.label, l.name)),
        grouped(l.cells), five_digits(l.volume_mm3)};
    if (e.image) {
      row.push_back(l.image ? five_digits(l.image->volume_mm3) : "–");
      row.push_back(l.image ? fmt::format("{:+.2f} %", l.image_volume_error_percent()) : "–");
    }
    const auto of_image = [&](const auto& value_of) {
      return l.image ? std::optional(static_cast<std::int64_t>(value_of(*l.image))) : std::nullopt;
    };
    row.push_back(
        against(std::optional(l.components), of_image([](const auto& v) { return v.component_count; })));
    row.push_back(against(l.cavities(), of_image([](const auto& v) { return v.cavity_count; })));
    row.push_back(against(l.handles(), of_image([](const auto& v) { return v.handle_count(); })));
    row.push_back(against(std::optional(l.euler), of_image([](const auto& v) { return v.euler_number; })));
    row.push_back(l.lost()       ? "!lost"
                  : l.cells == 0 ? "cut off"
                                 : marked(l.surface.manifold(),
                                          l.surface.manifold() ? "closed manifold" : "not manifold"));
    table.push_back(row);
  }
  if (e.image && e.labels.size() > 1)
    table.push_back({"all", "", five_digits(e.volume_mm3()), five_digits(e.image->all.volume_mm3),
                     fmt::format("{:+.2f} %", e.image_volume_error_percent()), "", "", "", "", ""});
  std::string html = table_html(table);
  if (e.image && e.cut_planes > 0)
    html += "<p class=\"note\">Volumes of voxels are those of what the cuts keep.</p>";
  if (!e.topology_differences.empty()) {
    html += "<p class=\"note\">Topology that differs:";
    for (std::size_t i = 0; i < std::min(kMaxRows, e.topology_differences.size()); ++i)
      html += (i == 0 ? " " : "; ") + e.topology_differences[i];
    html += ".</p>";
  }
  return section("Labels", html + topology_places(e.topology_places));
}

std::string distances_section(const Evaluation& e) {
  if (!e.image) return "";
  Table table = {{"distance", "mean, voxels", "95 %, voxels", "largest, voxels", "largest, mm"}};
  if (e.image->distances)
    add_distances(table, e.labels.size() > 1 ? "outside" : "surface", *e.image->distances,
                  e.image->voxel_size_mm);
  const auto measured =
      std::ranges::count_if(e.labels, [](const auto& l) { return l.distances.has_value(); });
  if (measured > 1)
    for (const LabelEvaluation& l : e.labels)
      if (l.distances && table.size() < kMaxRows)
        add_distances(table, "label " + std::to_string(l.label), *l.distances, e.image->voxel_size_mm);
  return section("Distance to the image",
                 table_html(table) +
                     "<p class=\"note\">Between the triangles of the mesh and the faces between voxels of "
                     "different labels. The last row of each group is the Hausdorff distance between the "
                     "surface vertices and the centres of the boundary voxels.</p>");
}

std::string kept_section(const Evaluation& e) {
  if (!e.image) return "";
  Table table = {
      {"voxels", "counted", "missed", "kept", "farthest, voxels", "farthest, mm", "at mm", "voxel"}};
  const double voxel = e.image->voxel_size_mm;
  for (const LabelEvaluation& l : e.labels)
    if (l.voxels_kept) add_kept(table, fmt::format("label {}", l.label), *l.voxels_kept, voxel);
  add_kept(table, "background", e.image->background_kept, voxel);
  add_kept(table, "all", e.image->voxels_kept, voxel);
  return section(
      "Voxels kept",
      table_html(table) +
          "<p class=\"note\">Voxels are kept whose centres lie in cells of their own label. Background "
          "counts to two voxels from the object within the mesh's box, and is kept outside of all cells. "
          "The farthest are those whose centres are farthest from the boundary of their label.</p>");
}

std::string openings_section(const Evaluation& e) {
  if (!e.openings || (e.openings->openings.empty() && e.openings->others.empty())) return "";
  Table table = {{"opening", "kind", "mesh mm²", "image mm²", "change", "radius mm", "at mm", "outwards"}};
  for (const OpeningInMesh& o : e.openings->openings)
    table.push_back({o.patches.empty() ? "none" : escaped(o.patches), kinds_of(e, o.patches),
                     five_digits(o.mesh_area_mm2), five_digits(o.opening.area_mm2),
                     marked(!is_wrong(o), fmt::format("{:+.1f} %", o.change_percent())),
                     five_digits(o.opening.radius_mm()), table_place(o.opening.centre_mm),
                     direction_text(o.opening.normal)});
  for (const std::string& name : e.openings->others)
    table.push_back({escaped(name), kinds_of(e, name), "", marked(false, "none"), "", "", "", ""});
  return section(
      "Openings",
      table_html(table) +
          fmt::format(
              "<p class=\"note\">Where the object is cut off, at the image's borders and at cut planes: "
              "the area of the mesh's patch, and that of the image's boundary there. More than {:g} % off "
              "is marked.</p>",
              kWrongOpeningPercent));
}

std::string narrowest_section(const Evaluation& e) {
  if (!e.sections || e.sections->empty()) return "";
  std::vector<NarrowestSection> sections = *e.sections;
  std::ranges::stable_sort(
      sections, [](const auto& a, const auto& b) { return a.change_percent() < b.change_percent(); });
  Table table = {{"branch", "mesh mm²", "voxels mm²", "change", "at mm", "direction"}};
  for (const NarrowestSection& s : sections) {
    if (table.size() > kMaxRows) break;
    table.push_back({std::to_string(s.branch), five_digits(s.mesh_area_mm2), five_digits(s.voxel_area_mm2),
                     marked(!s.tightened() && !s.widened(), fmt::format("{:+.1f} %", s.change_percent())),
                     table_place(s.centre_mm), direction_text(s.direction)});
  }
  return section(
      "Narrowest section of each branch",
      table_html(table) +
          "<p class=\"note\">Where the mesh is narrowest on planes square to the vessel's axis, and the "
          "area of the voxels there, all labels together. Those that lose more than 3 % are marked.</p>");
}

std::string reference_section(const Evaluation& e) {
  if (!e.reference_voxel_mm) return "";
  Table table = {{"label", "", "mean", "95 %", "largest"}};
  for (const LabelEvaluation& l : e.labels) {
    if (!l.reference) continue;
    const LabelReference& r = *l.reference;
    const std::string name = std::to_string(l.label);
    const auto row = [&](const std::string& what, const DistanceSummary& s, double unit) {
      table.push_back({name, what, fmt::format("{:.3f}", s.mean / unit), fmt::format("{:.3f}", s.p95 / unit),
                       fmt::format("{:.3f}", s.max / unit)});
    };
    if (r.surface_distance_mm) row("mesh to truth, voxels", *r.surface_distance_mm, *e.reference_voxel_mm);
    if (r.truth_to_mesh_mm) row("truth to mesh, voxels", *r.truth_to_mesh_mm, *e.reference_voxel_mm);
    if (r.normal_angle_deg) row("angle between normals, degrees", *r.normal_angle_deg, 1);
    if (e.cut_planes == 0)
      table.push_back(
          {name, "volume error", fmt::format("{:+.3f} %", l.reference_volume_error_percent()), "", ""});
    const bool same = l.components == static_cast<std::uint64_t>(r.components) && l.euler == r.euler;
    table.push_back(
        {name, "components, Euler number",
         marked(same, fmt::format("{}, {} (truth {}, {})", l.components, l.euler, r.components, r.euler)), "",
         ""});
  }
  return section("Against the exact phantom", table_html(table));
}

std::string boundary_section(const Evaluation& e) {
  const SurfaceTopology& b = e.boundary;
  Table table = {
      {"patch", "kind", "triangles", "area mm²", "smallest angle", "centre mm", "normal", "flat within"}};
  for (const PatchSummary& p : e.patches) {
    if (table.size() > kMaxRows) break;
    const bool opening = is_plane(p.kind);
    table.push_back({escaped(p.name), std::string(kind_word(p.kind, p.flow)), grouped(p.faces),
                     five_digits(p.area_mm2), fmt::format("{:.1f}°", p.smallest_angle_deg),
                     opening ? table_place(p.centre_mm) : "", opening ? direction_text(p.normal) : "",
                     opening ? flatness_text(p.flatness_mm) : ""});
  }
  std::string note =
      fmt::format("{}, {}; {} of genus {}, {} triangles.", b.closed() ? "Closed" : "Open",
                  b.manifold() ? "manifold" : "not manifold", counted(b.components.size(), "component"),
                  b.genus() < 0 ? "–" : std::to_string(b.genus()), grouped(b.triangles));
  if (!b.manifold())
    note += fmt::format(" {} open edges, {} non-manifold edges, {} non-manifold vertices.", b.open_edges,
                        b.non_manifold_edges, b.non_manifold_vertices);
  return section("Boundary", table_html(table) + "<p class=\"note\">" + note + "</p>");
}

std::string problems_section(const Evaluation& e) {
  if (e.valid()) return "";
  std::string html = "<table>";
  for (const std::string& problem : e.problems)
    html += "<tr><td class=\"text\">" + escaped(problem) + "</td></tr>";
  return section(fmt::format("Problems ({})", grouped(e.problem_count)), html + "</table>");
}

}  // namespace lumesh::report
