#pragma once
/// @file A case: everything that one run of the pipeline is told, as a TOML file says it.

#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "lumesh/adapt/adapt.hpp"
#include "lumesh/adapt/improve.hpp"
#include "lumesh/delaunay/delaunay.hpp"
#include "lumesh/image/phantom.hpp"
#include "lumesh/lattice/lattice.hpp"
#include "lumesh/layers/layers.hpp"
#include "lumesh/pipeline/image_cuts.hpp"
#include "lumesh/pipeline/input.hpp"

namespace lumesh {

enum class Mesher : std::uint8_t { kLattice, kDelaunay };

/// What the boundary does while the mesh is adapted.
enum class BoundaryMode : std::uint8_t {
  kFrozen,  ///< It stays as it is.
  kAdapt,   ///< It is adapted along the boundary of the image, or of the input's smooth surface.
};

/// What is meshed: an image, a closed surface, or a phantom, of which one is named.
struct InputKeys {
  std::string image, surface;  ///< Paths.
  std::string phantom;         ///< "carotid", "bifurcation", …
  PhantomSpec phantom_spec;    ///< Size, spacing and noise of the phantom.
  ImageSelection selection;
  ImageCuts cuts;
  LabelFieldOptions field;  ///< How the image's voxels bind the boundary.
  double feature_angle_deg = 40;
};

struct CenterlineKeys {
  bool is_wanted = false;  ///< It is also made where another stage needs it.
  double spacing_mm = 0;   ///< 0: follows the radius.
};

/// Sizes for the Delaunay mesher besides its own.
struct SizeKeys {
  std::string points;  ///< A path, or "centerline".
  double factor = 1, floor_mm = 0, ceiling_mm = 0;
  std::string plugin;
};

struct MetricKeys {
  std::string points;  ///< A path, or "centerline"; empty: none.
  int neighbours = 40;
  std::string velocity;  ///< A path, or "phantom"; empty: none.
  std::string velocity_array;
  int velocity_neighbours = 20;
  bool curvature = false;
  double smallest_mm = 0, largest_mm = 0;  ///< 0: no bound.
  double largest_aspect = 0;               ///< 0: no bound.
  bool frozen_sizes = true;  ///< metric::MetricLimits::keeps_boundary, where the boundary is frozen.
  double gradation = 1.5;    ///< 0: none.
  double complexity = 0;     ///< 0: as the sources say.

  [[nodiscard]] bool is_wanted() const { return !points.empty() || !velocity.empty() || curvature; }
};

struct AdaptKeys {
  BoundaryMode boundary = BoundaryMode::kAdapt;
  double feature_angle_deg = 40;
  bool allows_pieces = false;
};

/// Boundary layers of the last mesh.
struct LayerKeys {
  LayerOptions options;  ///< Without the label.
  std::string label;     ///< "NAME=NUMBER", "NAME" or "NUMBER"; empty: LayerOptions' own.

  [[nodiscard]] bool is_wanted() const { return options.first_height > 0; }
};

struct OpeningKeys {
  std::vector<std::string> names;  ///< Texts for renaming_from().
};

struct OutputKeys {
  std::string folder;  ///< Empty: the case's name, in the working directory.
  std::vector<std::string> meshes = {
      "mesh.vtu"};  ///< Files of the last mesh, each in the format of its name.
  std::string surface;
  std::string report = "report.html", json = "report.json";
  bool stages = false;  ///< Also files of the first mesh and the centerline.
};

struct RunKeys {
  int threads = 0;          ///< 0: all cores.
  double time_limit_s = 0;  ///< 0: none.
  bool checkpoints = false;
};

/// Lengths are millimetres. Options of the stages are those of the stages themselves.
struct Case {
  std::string name;  ///< The file's name without its extension.
  std::string file;  ///< Empty if it was not read.
  InputKeys input;
  Mesher mesher = Mesher::kDelaunay;
  double edge_length_mm =
      0;  ///< On surfaces, where the mesher's own options say nothing of it; 0: 2.5 voxels.
  double cells_per_diameter =
      0;  ///< Edges along the diameter of vessels; 0: as many as edge_length_mm makes.
  LatticeOptions lattice;
  DelaunayOptions delaunay;
  SizeKeys sizes;
  ImproveOptions improvement;
  bool improves = true;
  CenterlineKeys centerline;
  MetricKeys metric;
  AdaptKeys boundary;
  AdaptOptions adapt;
  LayerKeys layers;
  OpeningKeys openings;
  OutputKeys output;
  RunKeys run;

  /// Those of the meshers, with the edge length.
  [[nodiscard]] LatticeOptions lattice_options() const {
    LatticeOptions options = lattice;
    if (!(options.spacing_mm > 0)) options.spacing_mm = edge_length_mm;
    if (cells_per_diameter > 0) options.fidelity = LatticeOptions::fidelity_of_cells(cells_per_diameter);
    return options;
  }
  [[nodiscard]] DelaunayOptions delaunay_options() const {
    DelaunayOptions options = delaunay;
    options.edge_length_mm = edge_length_mm;
    return options;
  }
  /// Whether the mesher takes sizes from it.
  [[nodiscard]] bool sizes_by_centerline() const {
    return sizes.points == "centerline" || (mesher == Mesher::kDelaunay && cells_per_diameter > 0);
  }
  [[nodiscard]] bool needs_centerline() const {
    return centerline.is_wanted || metric.points == "centerline" || sizes_by_centerline();
  }
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

}  // namespace lumesh
