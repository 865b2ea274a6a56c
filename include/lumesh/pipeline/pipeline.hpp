#pragma once
/// @file A case, everything that one run is told, as a TOML file says it; and the whole way from an image to
/// the adapted mesh, in memory (the paper's figure 1).

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/field/field_options.hpp"
#include "lumesh/image/phantom.hpp"
#include "lumesh/lattice/lattice.hpp"
#include "lumesh/metric/sources.hpp"
#include "lumesh/stages/adapt_stage.hpp"
#include "lumesh/stages/delaunay_stage.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/layers_stage.hpp"

namespace lumesh {

namespace report {
struct CaseReport;
}

enum class Mesher : std::uint8_t { kLattice, kDelaunay };

/// Input to mesh: an image, a closed surface, or a phantom, of which one is named.
struct InputKeys {
  std::string image, surface;  ///< Paths.
  std::string phantom;         ///< "carotid", "bifurcation", …
  PhantomSpec phantom_spec;    ///< Size, spacing and noise of the phantom.
  ImageSelection selection;
  InputCuts cuts;
  LabelFieldOptions field;  ///< How the image's voxels bind the boundary.
  SurfaceInputOptions of_surface;

  void describe(OptionList& list);
};

struct CenterlineKeys {
  bool is_wanted = false;  ///< It is also made where another stage needs it.
  CenterlineOptions options;

  void describe(OptionList& list);
};

struct OpeningKeys {
  std::vector<std::string> names;  ///< Texts for renaming_from().

  void describe(OptionList& list);
};

struct OutputKeys {
  std::string folder;  ///< Empty: the case's name, in the working directory.
  std::vector<std::string> meshes = {
      "mesh.vtu"};  ///< Files of the last mesh, each in the format of its name.
  std::string surface;
  std::string unit = "mm";  ///< Unit of lengths in meshes.
  std::string report = "report.html", json = "report.json";
  bool stages = false;  ///< Files, too, of the first mesh and the centerline.

  void describe(OptionList& list);
};

struct RunKeys {
  int threads = 0;                                                ///< 0: all cores.
  double time_limit_s = std::numeric_limits<double>::infinity();  ///< Infinite: none.
  bool checkpoints = false;
  /// Whether stages whose checkpoint has their key are read instead of made; no key of case files.
  bool resumes = false;

  void describe(OptionList& list);
};

/// Lengths are millimetres. Options of the stages are those of the stages themselves.
struct Case {
  std::string name;  ///< The file's name without its extension.
  std::string file;  ///< Empty if it was not read.
  InputKeys input;
  Mesher mesher = Mesher::kDelaunay;
  double edge_length_mm = 0;  ///< On surfaces, where the mesher's own options say nothing of it.
  double cells_per_diameter = 0;
  LatticeOptions lattice;
  DelaunayRequest delaunay;  ///< Its execution and team are those of adapt.
  CenterlineKeys centerline;
  metric::MetricRequest metric;
  AdaptRequest adapt;
  LayerRequest layers;
  OpeningKeys openings;
  OutputKeys output;
  RunKeys run;

  /// Whether the mesh has hexahedra, pyramids and tetrahedra: the lattice's.
  [[nodiscard]] bool makes_mixed_mesh() const { return mesher == Mesher::kLattice && lattice.mixed; }
  /// The lattice's options with the edge length and the cells of the case.
  [[nodiscard]] LatticeOptions lattice_options() const;
  /// The request for the Delaunay mesher, with the execution of adapt.
  [[nodiscard]] DelaunayRequest delaunay_request() const;
  [[nodiscard]] bool needs_centerline() const;
  /// A message that names options neutrally, with the names of the case's keys.
  [[nodiscard]] std::string with_keys(const std::string& message) const;
};

/// Reads a case file (TOML 1.0). Relative paths in it are relative to its folder; in the result all are
/// absolute.
/// @param settings  "section.key=value" each, taken before what the file says.
/// @throws Error{kBadInput}, one line with file and line number, for a fault of the syntax, an unknown key
/// (with the nearest known one), a value of the wrong type or out of its range, or keys that contradict each
/// other.
[[nodiscard]] Case read_case(const std::filesystem::path& path, std::span<const std::string> settings = {});

/// The case as a TOML file with every key and what it means: read_case() of it gives the same case.
[[nodiscard]] std::string case_text(const Case& wanted);

/// One section of case files: its name, empty for the keys before the first one, what it is about, and its
/// keys.
struct CaseSection {
  std::string name, meaning;
  OptionList options;
};

/// The sections of a case, in the order in which they are written. @param c  Lives longer: the options point
/// into it.
[[nodiscard]] std::vector<CaseSection> sections_of(Case& c);

struct CaseResult {
  /// Content of the report's page, never null; for lumesh itself, others read json().
  std::shared_ptr<const report::CaseReport> report;
  std::string folder;                     ///< Folder of the files.
  std::vector<std::string> faults;        ///< Faults of the mesh that was written (quality::find_faults()).
  std::vector<std::string> without_name;  ///< A line for each name of the case whose patch the mesh lacks.
  bool complete = true;  ///< False if the context was cancelled: files hold the best mesh so far.

  /// A line on time and memory.
  [[nodiscard]] std::string text() const;
  /// The numbers of the report; docs/stages/evaluate.md describes the fields.
  [[nodiscard]] std::string json() const;
  /// @param besides  What else has to be said then.
  /// @throws Error{kNotReached} if the mesh is invalid, layers are hardly there, or a patch with a name by
  /// the case is missing.
  void require_good(const std::string& besides) const;
};

/// Runs the stages that the case asks for, one after the other: input, centerline, first mesh, metric,
/// adapted mesh, its measures; then writes the files: meshes, report, numbers, and the case with every
/// setting that was in force. Each stage says one line to context.info() when it is done.
///
/// With checkpoints, what each stage leaves is kept in the folder `checkpoints`, with a key made of all that
/// it depends on: contents of files, settings, the version. A run that resumes has a bitwise identical
/// result.
/// @throws Error as the stages do; files are written beside their targets and renamed when complete.
[[nodiscard]] CaseResult run_case(const Case& c, Context& context);

/// The case itself, or, where all frames of its image are wanted, a case for each, with a folder of its own
/// in that of the case. @throws Error{kBadInput} as count_frames().
[[nodiscard]] std::vector<Case> cases_of_frames(const Case& c);

/// Predicted steps of a case, and about what they will take.
struct CasePrediction {
  struct Step {
    std::string what;       ///< One line.
    double seconds = 0;     ///< Wall time, 0 where next to none.
    double tetrahedra = 0;  ///< Number in the mesh it leaves; 0: none, or not known.
  };
  std::vector<Step> steps;
  double peak_memory_bytes = 0;
  std::uint64_t free_memory_bytes = 0;

  [[nodiscard]] double seconds() const;
  /// A line for each step, and one on the whole.
  [[nodiscard]] std::string text() const;
};

/// Reads the input and samples the metric's sources at voxels; makes no mesh and writes nothing. How far
/// numbers of tetrahedra and times are to be trusted: docs/stages/run.md, "What a dry run knows".
/// @throws Error as run_case() does for its input.
[[nodiscard]] CasePrediction predict_case(const Case& c, Context& context);

}  // namespace lumesh
