#pragma once
/// @file A case: everything that one run of the pipeline is told, as a TOML file says it.

#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "lumesh/centerline/centerline.hpp"
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

}  // namespace lumesh
