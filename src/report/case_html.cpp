#include <fmt/core.h>

#include <algorithm>
#include <array>

#include "evaluation_plots.hpp"
#include "evaluation_tables.hpp"
#include "html_parts.hpp"
#include "layers_html.hpp"
#include "lumesh/core/counted.hpp"
#include "lumesh/report/case_report.hpp"
#include "numbers.hpp"

namespace lumesh::report {

namespace {

using namespace lumesh::quality;

enum class Layers { kAny, kNone };

/// The last mesh that was looked at. @param layers  kNone: the last one without boundary layers; what the
/// metric asked for, and the image, can be compared with that.
const StageReport* last_evaluated(const CaseReport& report, Layers layers = Layers::kAny) {
  const auto is_wanted = [&](const StageReport& stage) {
    return stage.evaluation.has_value() && (layers == Layers::kAny || !stage.layers);
  };
  const auto found = std::find_if(report.stages.rbegin(), report.stages.rend(), is_wanted);
  return found == report.stages.rend() ? nullptr : &*found;
}

/// The core of a mesh with layers as a mesh among others.
Evaluation evaluation_of_core(const StageReport& stage) {
  Evaluation core;
  core.statistics = stage.layers->core;
  core.problem_count = stage.evaluation->problem_count;
  return core;
}

std::string duration(double seconds) {
  if (seconds < 100) return fmt::format("{:.{}f} s", seconds, seconds < 10 ? 2 : 1);
  const auto whole = static_cast<std::uint64_t>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

std::string memory(std::uint64_t bytes) {
  const double megabytes = static_cast<double>(bytes) / 1e6;
  return megabytes < 1000 ? fmt::format("{:.0f} MB", megabytes) : fmt::format("{:.1f} GB", megabytes / 1e3);
}

std::string with_unit(const std::string& number, const std::string& unit) {
  if (unit.empty()) return number;
  return number + (unit == "°" ? "" : " ") + escaped(unit);
}

/// Such as the path of a file, which may be long.
bool is_words(const Figure& figure) {
  return std::holds_alternative<std::string>(figure.value);
}

std::string figure_value(const Figure& figure) {
  if (const auto* count = std::get_if<std::uint64_t>(&figure.value))
    return with_unit(grouped(*count), figure.unit);
  if (const auto* number = std::get_if<double>(&figure.value))
    return with_unit(five_digits(*number), figure.unit);
  return with_unit(escaped(std::get<std::string>(figure.value)), figure.unit);
}

std::string stage_link(std::size_t index) {
  return fmt::format("stage-{}", index + 1);
}

std::string case_header(const CaseReport& report) {
  std::string html = "<header><h1>" + escaped(report.title) + "</h1>";
  const StageReport* last = last_evaluated(report);
  if (!report.complete)
    html += "<span class=\"badge bad\">stopped early: the mesh is what was there after " +
            escaped(report.stages.empty() ? "" : report.stages.back().name) + "</span>";
  else if (last != nullptr && !last->evaluation->valid())
    html += "<span class=\"badge bad\">the last mesh is invalid</span>";
  else if (last != nullptr && last->layers && !last->layers->flat_cells_beside().empty())
    html += "<span class=\"badge bad\">complete, with flat cells beside the layers</span>";
  else
    html += "<span class=\"badge\">complete</span>";
  // What measures say of earlier meshes is over with these.
  std::size_t warnings = last != nullptr ? last->evaluation->warnings.size() : 0;
  for (const StageReport& stage : report.stages) warnings += stage.warnings.size();
  html += fmt::format("<p>From the image to the mesh in {}, {}", counted(report.stages.size(), "step"),
                      duration(report.seconds));
  if (warnings > 0) html += "; " + counted(warnings, "warning");
  return html + ".</p></header>\n";
}

std::string angles_tile(double smallest_deg, double largest_deg, const std::string& of) {
  return tile(fmt::format("{:.1f}° – {:.1f}°", smallest_deg, largest_deg), "dihedral angles" + of);
}

/// How good a mesh with layers is: its two parts.
std::string parts_tiles(const LayersOfMesh& layers) {
  const TetrahedronStatistics& core = layers.core.tetrahedra;
  return angles_tile(core.smallest_dihedral_deg.value, core.largest_dihedral_deg.value,
                     " besides the layers; good between 10° and 165°") +
         angles_tile(
             layers.shapes.smallest_dihedral_deg, layers.shapes.largest_dihedral_deg,
             fmt::format(" of the layers, which are flat by design (longest edge to height {:.3g} at most)",
                         layers.shapes.largest_aspect));
}

/// How good a mesh is. @param aside  Which one, where it is not the last.
std::string quality_tiles(const Evaluation& e, const std::string& aside) {
  const TetrahedronStatistics& t = e.statistics.tetrahedra;
  std::string html;
  if (e.metric) {
    html += tile(fmt::format("{:.1f} %", 100 * e.metric->fraction_in_band()),
                 "edges of the length asked for" + aside + "; good from 90 %");
    html += tile(fmt::format("{:.2f}", e.metric->mean_mean_ratio),
                 fmt::format("quality on average{}, 1 is best (worst {:.2f}; good from 0.1)", aside,
                             e.metric->smallest_mean_ratio.value));
  } else if (aside.empty()) {
    html += tile(fmt::format("{:.2f}", t.mean_mean_ratio),
                 fmt::format("quality on average, 1 is best (worst {:.2f}; good from 0.1)",
                             t.smallest_mean_ratio.value));
    html += angles_tile(t.smallest_dihedral_deg.value, t.largest_dihedral_deg.value,
                        "; good between 10° and 165°");
  }
  if (e.image && e.image->distances)
    html += tile(fmt::format("{:.2f}", e.image->distances->mesh_to_image_mm.mean / e.image->voxel_size_mm),
                 fmt::format("voxels ({:.2g} mm) from the image on average{}; good below 0.5",
                             e.image->distances->mesh_to_image_mm.mean, aside));
  return html;
}

std::string size_tiles(const StageReport& last) {
  const MeshStatistics& m = last.evaluation->statistics;
  if (!last.layers)
    return tile(grouped(m.tetrahedra.count), "tetrahedra") + tile(grouped(m.vertices), "vertices");
  const LayerReport& layers = last.layers->report;
  return tile(grouped(last.layers->core.tetrahedra.count), "tetrahedra besides the layers") +
         tile(grouped(layers.cells), "cells of " + counted(layers.layers, "boundary layer")) +
         tile(fmt::format("{:.1f} %", 100 * layers.complete()), "of the area with all of their thickness") +
         tile(grouped(m.vertices), "vertices");
}

/// Tiles of the last mesh, and of the run.
std::string case_tiles(const CaseReport& report) {
  std::string html = "<div class=\"tiles\">";
  if (const StageReport* last = last_evaluated(report)) {
    html += size_tiles(*last);
    if (last->layers) html += parts_tiles(*last->layers);
    if (const StageReport* plain = last_evaluated(report, Layers::kNone))
      html += quality_tiles(*plain->evaluation, last->layers ? ", before the layers" : "");
  }
  html += tile(duration(report.seconds), "in all");
  if (report.peak_memory_bytes > 0) html += tile(memory(report.peak_memory_bytes), "memory at most");
  return html + "</div>\n";
}

std::string picture_html(const NamedPicture& named) {
  if (named.picture.width == 0) return "<p class=\"note\">" + escaped(named.caption) + "</p>";
  std::string html = "<figure>" + image_tag(named.picture, named.names, named.caption) + "<figcaption>" +
                     escaped(named.caption) + "</figcaption>" + legend_html(named.legend);
  if (named.scale) html += scale_html(*named.scale);
  return html + "</figure>\n";
}

std::string stage_times(const CaseReport& report) {
  double longest = 1e-9, sum = 0;
  for (const StageReport& stage : report.stages) {
    longest = std::max(longest, stage.seconds);
    sum += stage.seconds;
  }
  std::string html = "<table class=\"flow\">";
  for (std::size_t i = 0; i < report.stages.size(); ++i) {
    const StageReport& stage = report.stages[i];
    html += fmt::format(
        "<tr><td class=\"number\">{}</td><td class=\"text\"><a href=\"#{}\">{}</a><p>{}</p></td>"
        "<td class=\"share\"><i style=\"width:{:.1f}%\"></i></td><td>{}</td></tr>\n",
        i + 1, stage_link(i), escaped(stage.name), escaped(stage.what), 100 * stage.seconds / longest,
        duration(stage.seconds));
  }
  html += "</table>";
  if (report.seconds > sum + 0.005)
    html += fmt::format(
        "<p class=\"note\">{} went into reading, writing, measuring and drawing between the steps.</p>",
        duration(report.seconds - sum));
  return section("Step by step", html);
}

/// One row for each number, one column for each mesh.
class Comparison {
 public:
  explicit Comparison(std::span<const NamedEvaluation> meshes) : meshes_(meshes) {
    table_ = {{"mesh"}};
    for (const NamedEvaluation& mesh : meshes) table_[0].push_back(escaped(mesh.name));
  }

  /// A row of what cell(evaluation) says; left out where it says nothing of any mesh.
  template <class Cell>
  void add(const std::string& name, const Cell& cell) {
    std::vector<std::string> row = {name};
    bool any = false;
    for (const NamedEvaluation& mesh : meshes_) {
      const std::string text = cell(*mesh.evaluation);
      any |= !text.empty();
      row.push_back(text.empty() ? "–" : text);
    }
    if (any) table_.push_back(std::move(row));
  }
  template <class Cell>
  void add_metric(const std::string& name, const Cell& cell) {
    add(name, [&](const Evaluation& e) { return e.metric ? cell(*e.metric) : std::string(); });
  }
  /// Adds a row of the distances to the image, in voxels.
  template <class Cell>
  void add_distance(const std::string& name, const Cell& cell) {
    add(name, [&](const Evaluation& e) {
      return e.image && e.image->distances
                 ? fmt::format("{:.2f}", cell(*e.image->distances) / e.image->voxel_size_mm)
                 : std::string();
    });
  }
  [[nodiscard]] std::string html() const { return table_html(table_); }

 private:
  std::span<const NamedEvaluation> meshes_;
  Table table_;
};

std::string comparison_table(std::span<const NamedEvaluation> meshes) {
  Comparison rows(meshes);
  const auto tetrahedra = [](const Evaluation& e) -> const TetrahedronStatistics& {
    return e.statistics.tetrahedra;
  };
  rows.add("valid", [](const Evaluation& e) { return e.valid() ? "yes" : "!no"; });
  rows.add("tetrahedra", [&](const Evaluation& e) { return grouped(tetrahedra(e).count); });
  rows.add("vertices", [](const Evaluation& e) { return grouped(e.statistics.vertices); });
  rows.add("dihedral angles", [&](const Evaluation& e) {
    return fmt::format("{:.1f}° to {:.1f}°", tetrahedra(e).smallest_dihedral_deg.value,
                       tetrahedra(e).largest_dihedral_deg.value);
  });
  rows.add(kMeanRatioRow, [&](const Evaluation& e) {
    return fmt::format("{:.3f}, {:.3f}", tetrahedra(e).mean_mean_ratio,
                       tetrahedra(e).smallest_mean_ratio.value);
  });
  rows.add_metric("mean ratio in the metric, average and worst", [](const MetricStatistics& m) {
    return fmt::format("{:.3f}, {:.3f}", m.mean_mean_ratio, m.smallest_mean_ratio.value);
  });
  rows.add_metric("tetrahedra below 0.1 in the metric",
                  [](const MetricStatistics& m) { return grouped(m.poor_tetrahedra); });
  rows.add_metric("edges of the length asked for", [](const MetricStatistics& m) {
    return fmt::format("{:.1f} %", 100 * m.fraction_in_band());
  });
  rows.add_metric("the same of edges with an end inside", [](const MetricStatistics& m) {
    return m.free_edges && m.free_edges->edges > 0
               ? fmt::format("{:.1f} %", 100 * m.free_edges->fraction_in_band())
               : std::string();
  });
  rows.add_distance("from the image on average, voxels",
                    [](const SurfaceDistances& d) { return d.mesh_to_image_mm.mean; });
  rows.add_distance("from the image at most, voxels", [](const SurfaceDistances& d) {
    return std::max(d.mesh_to_image_mm.max, d.image_to_mesh_mm.max);
  });
  return section("The meshes compared", rows.html());
}

std::string comparison_html(const CaseReport& report) {
  std::vector<NamedEvaluation> meshes;
  std::vector<Evaluation> cores;
  cores.reserve(report.stages.size());  // The list of meshes points into it.
  for (const StageReport& stage : report.stages) {
    if (!stage.evaluation) continue;
    const std::string name = stage.mesh_name.empty() ? stage.name : stage.mesh_name;
    if (stage.layers)
      meshes.push_back({name + " without layers", &cores.emplace_back(evaluation_of_core(stage))});
    else
      meshes.push_back({name, &*stage.evaluation});
  }
  if (meshes.size() < 2) return "";
  return comparison_table(meshes) + comparison_plots_html(meshes);
}

/// Pictures in pairs; of an odd number the first has the whole width.
std::string pictures_html(const std::vector<NamedPicture>& pictures) {
  const auto card = [&](std::size_t i) { return "<section>" + picture_html(pictures[i]) + "</section>\n"; };
  std::string html;
  std::size_t next = 0;
  if (pictures.size() % 2 == 1) html += card(next++);
  for (; next + 1 < pictures.size(); next += 2) html += pair(card(next), card(next + 1));
  return html;
}

std::string figures_html(const StageReport& stage) {
  if (stage.figures.empty() && stage.steps.empty()) return "";
  std::string numbers = "<table class=\"numbers\">";
  for (const Figure& figure : stage.figures)
    numbers += "<tr><td>" + escaped(figure.name) +
               (figure.note.empty() ? "" : " <span class=\"aside\">" + escaped(figure.note) + "</span>") +
               "</td><td class=\"" + (is_words(figure) ? "words" : "value") + "\">" + figure_value(figure) +
               "</td></tr>\n";
  std::string steps = "<table>";
  for (const PhaseTime& step : stage.steps)
    steps += "<tr><td>" + escaped(step.name) + "</td><td>" + duration(step.seconds) + "</td></tr>\n";
  const std::string left = stage.figures.empty() ? "" : section("Numbers", numbers + "</table>");
  const std::string right = stage.steps.empty() ? "" : section("Times", steps + "</table>");
  return left.empty() || right.empty() ? left + right : pair(left, right);
}

/// Plots of a mesh with layers: cells that are flat by design apart from the others.
std::string plots_of_parts(const StageReport& stage) {
  const Evaluation core = evaluation_of_core(stage);
  Evaluation layers;
  layers.statistics = stage.layers->layers;
  if (layers.statistics.prisms + layers.statistics.pyramids > 0) return plots_html(core);
  const std::array<NamedEvaluation, 2> parts = {{{"core", &core}, {"layers", &layers}}};
  return comparison_plots_html(parts);
}

std::string layers_of_stage(const StageReport& stage) {
  return coverage_section(stage.layers->report) + shares_section(stage.layers->report.surface) +
         parts_section(*stage.layers);
}

std::string stage_html(const StageReport& stage, std::size_t index, const StageReport* last) {
  std::string html = fmt::format(
      "<h2 class=\"stage\" id=\"{}\"><b>{}</b> {} <span>{}</span></h2>\n<p class=\"lead\">{}</p>\n",
      stage_link(index), index + 1, escaped(stage.name), duration(stage.seconds), escaped(stage.what));
  html += warnings_html(stage.warnings);
  if (stage.evaluation) html += problems_section(*stage.evaluation);
  html += pictures_html(stage.pictures) + figures_html(stage);
  if (stage.layers) html += layers_of_stage(stage);
  if (!stage.evaluation) return html;
  const Evaluation& e = *stage.evaluation;
  html += warnings_html(e.warnings) + (stage.layers ? plots_of_parts(stage) : plots_html(e));
  html += distances_section(e) + kept_section(e) + openings_section(e) + narrowest_section(e) +
          reference_section(e);
  if (&stage == last) html += labels_section(e) + boundary_section(e);
  return html;
}

std::string files_html(const std::vector<OutputFile>& files) {
  if (files.empty()) return "";
  std::string html = "<table>";
  for (const OutputFile& file : files)
    html += "<tr><td class=\"key\"><code>" + escaped(file.path) + "</code></td><td class=\"text\">" +
            escaped(file.what) + "</td></tr>\n";
  return section("Files", html + "</table>");
}

std::string configuration_html(const std::string& configuration) {
  if (configuration.empty()) return "";
  return section("Settings in force", "<pre>" + escaped(configuration) + "</pre>");
}

/// Meanings of the words of the page.
std::string words_html(const CaseReport& report) {
  const auto has_metric = [](const StageReport& s) { return s.evaluation && s.evaluation->metric; };
  std::string html = "<dl>";
  const auto add = [&](const std::string& word, const std::string& meaning) {
    html += "<dt>" + word + "</dt><dd>" + meaning + "</dd>\n";
  };
  add("Tetrahedron",
      "A small pyramid of four triangles. Thousands to millions of them fill the vessel; the "
      "flow is computed at their corners, the vertices.");
  add("Dihedral angle",
      "The angle between two faces of a tetrahedron; 70.5° in a regular one. Angles close to "
      "0° or 180° belong to flat elements, which spoil a computation.");
  add("Mean ratio", "Quality of a tetrahedron: 1 if it is regular, 0 if it is flat.");
  if (std::ranges::any_of(report.stages, has_metric)) {
    add("Metric",
        "The size and shape wanted of the elements at every place. They may be long along the vessel "
        "and thin across its wall, where the flow changes fast; seen through the metric, such an "
        "element is regular and its edges have length 1.");
    add("Edges of the length asked for",
        "Edges with a length from 0.71 to 1.41 in the metric. Splitting a longer "
        "or joining a shorter one would not bring it closer to 1.");
  }
  if (std::ranges::any_of(report.stages, [](const StageReport& s) { return s.layers.has_value(); }))
    add("Boundary layers",
        "Layers of thin cells along the wall, for the wall itself or for the flow next to it, which changes "
        "fastest across. The core is the rest of the mesh.");
  add("Voxel",
      "The smallest box of the image. Distances in voxels tell how far the mesh is from what the image "
      "can resolve.");
  return section("<a id=\"words\"></a>Words", html + "</dl>");
}

}  // namespace

std::string case_report_html(const CaseReport& report) {
  std::string html = page_begin(report.title, "report");
  html += case_header(report) + case_tiles(report);
  html += "<p class=\"note\"><a href=\"#words\">What the words of this page mean</a></p>\n";
  html += pictures_html(report.pictures);
  html += stage_times(report) + comparison_html(report);
  const StageReport* last = last_evaluated(report);
  for (std::size_t i = 0; i < report.stages.size(); ++i) html += stage_html(report.stages[i], i, last);
  html += "<h2 class=\"stage\">About this run</h2>\n";
  html += words_html(report) + files_html(report.files) + configuration_html(report.configuration) +
          provenance_html(report.provenance);
  return html + page_end();
}

}  // namespace lumesh::report
