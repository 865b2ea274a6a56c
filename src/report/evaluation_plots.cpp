#include "evaluation_plots.hpp"

#include <fmt/core.h>

#include <numbers>
#include <vector>

#include "html_parts.hpp"
#include "numbers.hpp"
#include "plots.hpp"

namespace lumesh::report {

namespace {

using namespace lumesh::quality;

constexpr double kGoodAnglesFrom = 10, kGoodAnglesTo = 160;  // Outside these, solvers begin to suffer.
constexpr double kSmallAnglesTo = 40, kLargeAnglesFrom = 140;
constexpr double kWide =
    1084;  // So that letters of a plot of full width are as large as those of half of it.

HistogramPlot angle_plot(double tick_step, double width) {
  return {.unit = "°",
          .tick_step = tick_step,
          .good_low = kGoodAnglesFrom,
          .good_high = kGoodAnglesTo,
          .width = width};
}

HistogramPlot ratio_plot(CountAxis counts) {
  return {.tick_step = 0.2, .tick_decimals = 1, .good_low = 0.2, .good_high = 1, .counts = counts};
}

HistogramPlot length_plot(CountAxis counts) {
  return {.tick_step = 0.5,
          .tick_decimals = 1,
          .good_low = std::numbers::sqrt2 / 2,
          .good_high = std::numbers::sqrt2,
          .counts = counts};
}

/// One histogram, or several, with counts as they are and in powers of ten.
template <class Draw>
std::string both_axes(const Draw& draw) {
  return pair(plot_html("upright: even steps", draw(CountAxis::kLinear)),
              plot_html("upright: powers of ten", draw(CountAxis::kLogarithmic)));
}

/// Draws all angles, and those near the ends, of what zoom(low, high) gives to draw(plot).
template <class Draw>
std::string angle_plots(const Draw& draw) {
  return plot_html("all angles", draw(0, 180, angle_plot(30, kWide))) +
         pair(plot_html("small angles, 0° to 40°", draw(0, kSmallAnglesTo, angle_plot(10, 500))),
              plot_html("large angles, 140° to 180°", draw(kLargeAnglesFrom, 180, angle_plot(10, 500))));
}

std::string angles_section(const TetrahedronStatistics& t) {
  return section(
      "Dihedral angles",
      angle_plots([&](double low, double high, const HistogramPlot& plot) {
        return histogram_svg(zoomed(t.dihedral_deg, low, high), plot);
      }) +
          fmt::format(
              "<p class=\"note\">Angles between the faces of each tetrahedron: from {:.2f}° to "
              "{:.2f}°; the smallest of a tetrahedron is {:.1f}° on average. Tetrahedra below 5 / 10 / "
              "15°: {} / {} / {}; above 150 / 160 / 165°: {} / {} / {}.</p>",
              t.smallest_dihedral_deg.value, t.largest_dihedral_deg.value, t.mean_smallest_dihedral_deg,
              grouped(t.below_5_deg), grouped(t.below_10_deg), grouped(t.below_15_deg),
              grouped(t.above_150_deg), grouped(t.above_160_deg), grouped(t.above_165_deg)));
}

std::string ratios_section(const TetrahedronStatistics& t) {
  return section(
      "Mean ratio",
      both_axes([&](CountAxis counts) { return histogram_svg(t.mean_ratio, ratio_plot(counts)); }) +
          fmt::format("<p class=\"note\">Smallest {:.3f}, average {:.3f}; 1 is the regular tetrahedron. "
                      "Aspect ratio {:.2f} on average, {:.2f} at most.</p>",
                      t.smallest_mean_ratio.value, t.mean_mean_ratio, t.mean_aspect, t.largest_aspect.value));
}

std::string metric_lengths_section(const MetricStatistics& m) {
  std::string note = fmt::format(
      "{} edges: {:.2f} % between 1/√2 and √2, {:.2f} % shorter, {:.2f} % longer; from {:.3f} to {:.3f}, "
      "{:.3f} on average.",
      grouped(m.edges), 100 * m.fraction_in_band(), 100 * m.fraction_short(), 100 * m.fraction_long(),
      m.shortest_edge, m.longest_edge, m.mean_edge);
  if (m.free_edges && m.free_edges->edges > 0)
    note += fmt::format(
        " Of the {} edges with an end inside, not on the boundary: {:.2f} % between, {:.2f} % shorter, "
        "{:.2f} % longer.",
        grouped(m.free_edges->edges), 100 * m.free_edges->fraction_in_band(),
        100 * m.free_edges->fraction_short(), 100 * m.free_edges->fraction_long());
  return section("Edge lengths in the metric", both_axes([&](CountAxis counts) {
                                                 return histogram_svg(m.edge_length, length_plot(counts));
                                               }) + "<p class=\"note\">" +
                                                   note + "</p>");
}

std::string metric_ratios_section(const MetricStatistics& m) {
  return section(
      "Mean ratio in the metric",
      both_axes([&](CountAxis counts) { return histogram_svg(m.mean_ratio, ratio_plot(counts)); }) +
          fmt::format("<p class=\"note\">Smallest {:.3f}, average {:.3f}; 1 is regular in the metric. "
                      "Tetrahedra below 0.1: {}. Complexity {}; per unit {:.2f} vertices and {:.2f} "
                      "tetrahedra.</p>",
                      m.smallest_mean_ratio.value, m.mean_mean_ratio, grouped(m.poor_tetrahedra),
                      five_digits(m.complexity), m.vertices_per_complexity(), m.tetrahedra_per_complexity()));
}

std::string series_legend(std::span<const NamedEvaluation> meshes) {
  std::string html = "<ul class=\"legend\">";
  for (std::size_t i = 0; i < meshes.size(); ++i)
    html += "<li><i style=\"background:" + series_colour(i) + "\"></i>" + escaped(meshes[i].name) + "</li>";
  return html + "</ul>";
}

/// The lines of one histogram of each mesh, or of what part(histogram) leaves of it; of(evaluation) gives it.
template <class Of, class Part>
std::string overlaid(std::span<const NamedEvaluation> meshes, const HistogramPlot& plot, const Of& of,
                     const Part& part) {
  std::vector<NamedHistogram> named;
  for (const NamedEvaluation& mesh : meshes) {
    const Histogram& whole = of(*mesh.evaluation);
    named.push_back({mesh.name, part(whole), whole.total()});
  }
  return overlay_svg(named, plot);
}

/// The whole histograms of(evaluation). @param plot_of  plot_of(axis).
template <class Of>
std::string comparison(const std::string& title, std::span<const NamedEvaluation> meshes,
                       HistogramPlot (*plot_of)(CountAxis), const Of& of) {
  return section(title, both_axes([&](CountAxis counts) {
                          return overlaid(meshes, plot_of(counts), of,
                                          [](const Histogram& whole) { return whole; });
                        }) + series_legend(meshes));
}

std::string metric_comparison(std::span<const NamedEvaluation> meshes) {
  return comparison("Edge lengths in the metric, compared", meshes, length_plot,
                    [](const Evaluation& e) -> const Histogram& { return e.metric->edge_length; }) +
         comparison("Mean ratio in the metric, compared", meshes, ratio_plot,
                    [](const Evaluation& e) -> const Histogram& { return e.metric->mean_ratio; });
}

}  // namespace

std::string plots_html(const Evaluation& e) {
  std::string html;
  if (e.statistics.tetrahedra.count > 0)
    html += angles_section(e.statistics.tetrahedra) + ratios_section(e.statistics.tetrahedra);
  if (e.metric) html += metric_lengths_section(*e.metric) + metric_ratios_section(*e.metric);
  return html;
}

std::string comparison_plots_html(std::span<const NamedEvaluation> meshes) {
  std::vector<NamedEvaluation> with_tetrahedra, with_metric;
  for (const NamedEvaluation& mesh : meshes) {
    if (mesh.evaluation->statistics.tetrahedra.count > 0) with_tetrahedra.push_back(mesh);
    if (mesh.evaluation->metric) with_metric.push_back(mesh);
  }
  if (with_tetrahedra.size() < 2) return "";
  std::string html = section(
      "Dihedral angles, compared",
      angle_plots([&](double low, double high, const HistogramPlot& plot) {
        return overlaid(
            with_tetrahedra, plot,
            [](const Evaluation& e) -> const Histogram& { return e.statistics.tetrahedra.dihedral_deg; },
            [&](const Histogram& whole) { return zoomed(whole, low, high); });
      }) + series_legend(with_tetrahedra) +
          "<p class=\"note\">In per cent of all angles of each mesh.</p>");
  html +=
      comparison("Mean ratio, compared", with_tetrahedra, ratio_plot,
                 [](const Evaluation& e) -> const Histogram& { return e.statistics.tetrahedra.mean_ratio; });
  if (with_metric.size() >= 2) html += metric_comparison(with_metric);
  return html;
}

}  // namespace lumesh::report
