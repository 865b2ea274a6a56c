#pragma once
/// @file A report on a whole run, from the image to the last mesh: one HTML page for people, one JSON file
/// for programs.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/layers/layers.hpp"
#include "lumesh/quality/evaluation.hpp"
#include "lumesh/quality/measures.hpp"
#include "lumesh/report/picture.hpp"

namespace lumesh::report {

/// One number of a stage, or one word: {"Tetrahedra", mesh.tetrahedra.size()}, {"Longest edge", 1.25, "mm"},
/// {"Method", "lattice"}. Pages group thousands and show five significant digits; JSON has the number itself.
struct Figure {
  std::string name;
  std::variant<std::uint64_t, double, std::string> value;
  std::string unit = {};  ///< Such as "mm", "°" or "%"; empty for counts and words.
  std::string note = {};  ///< A few words beside it, such as "asked for: 1.5".
};

/// A picture, what is to be seen on it, and what its colours mean.
struct NamedPicture {
  std::string caption;  ///< One sentence.
  Picture picture;
  std::vector<LegendItem> legend;
  std::optional<ColourScale> scale = {};
  PictureLabels names = {};
  std::optional<CutWindow> window = {};  ///< Window of a cut: which part of which plane it shows.
};

/// A mesh with layers: what they achieved, and measures of its two parts apart.
struct LayersOfMesh {
  LayerReport report = {};
  quality::MeshStatistics core =
      {};  ///< Statistics of the tetrahedra that the layers stand on or lie around.
  quality::MeshStatistics layers = {};  ///< Statistics of the layers' own cells.
  quality::FlatCellShapes shapes = {};  ///< Shapes of the layers' own cells.
  double min_before_deg = 180;          ///< Dihedral angle of the mesh without layers.

  /// A line with the place if the tetrahedra beside the layers have dihedral angles below 5 degrees that the
  /// mesh had not before, else none: flat cells of the input stay flat.
  [[nodiscard]] std::string flat_cells_beside() const;
};

/// One step of the run, in the order of the run.
struct StageReport {
  std::string name;       ///< "Background mesh (lattice)".
  std::string what;       ///< One sentence for a newcomer: what the stage did, and why.
  std::string mesh_name;  ///< Short name of the mesh that it left, for comparisons: "background".
  double seconds = 0;     ///< Wall time.
  std::vector<Figure> figures;
  std::vector<std::string> warnings;
  std::vector<NamedPicture> pictures;
  /// Measures of the mesh that the stage left: gives the plots of its elements, and of its metric where it
  /// has one.
  std::optional<quality::Evaluation> evaluation;
  /// Layers of the mesh; its evaluation is then one of the whole mesh, and plots are of the core.
  std::optional<LayersOfMesh> layers;
  std::vector<PhaseTime> steps;  ///< Within the stage.
};

/// A file that the run wrote.
struct OutputFile {
  std::string path;  ///< Path by which a reader of the report finds it, best relative to the report.
  std::string what;  ///< "The adapted mesh with its metric".
};

struct CaseReport {
  std::string title;
  std::vector<StageReport> stages;
  std::string configuration;                      ///< The settings that were in force, as TOML.
  std::map<std::string, std::string> provenance;  ///< version, input, input_sha256, threads, date, …
  std::vector<OutputFile> files;
  std::vector<NamedPicture> pictures;  ///< Shown at the top: best one or two of the last mesh.
  double seconds = 0;                  ///< Wall time of the run.
  std::uint64_t peak_memory_bytes = 0;
  bool complete = true;  ///< False if the run stopped before its last stage; the page says so at the top.
};

/// The page: key figures of the last mesh, its picture, times and a comparison of the meshes first, then a
/// section for each stage. Self-contained as report_html() is, and looks like it. Cost: that of packing the
/// pictures, about 0.1 s each.
[[nodiscard]] std::string case_report_html(const CaseReport& report);

/// The report without pictures as JSON; docs/stages/evaluate.md describes the fields. Numbers that are
/// infinite become null.
[[nodiscard]] std::string case_report_json(const CaseReport& report);

}  // namespace lumesh::report
