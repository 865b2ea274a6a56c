/// How true the boundary is that lumesh derives from images of known shapes.

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <string>

#include "commands.hpp"
#include "lumesh/parallel/loops.hpp"

namespace {

using lumesh::boundary::RunOptions;

/// A part of the benchmark and its options, with its own number of seeds.
struct Part {
  void (*run)(const RunOptions&) = nullptr;
  RunOptions options;
  int threads = 0;
  const CLI::App* command = nullptr;

  /// @param only  What --only picks; empty: the part has no choice of cases.
  void add_to(CLI::App& app, const std::string& name, const std::string& about, const std::string& only) {
    CLI::App* added = app.add_subcommand(name, about);
    if (!only.empty()) {
      added->add_option("--only", options.only, only);
      added->add_option("--seeds", options.seeds, "Random images of each case")->capture_default_str();
      added->add_option("--first-seed", options.first_seed, "The others follow it")->capture_default_str();
    }
    added->add_option("--json", options.json_path, "Writes one line of JSON per image");
    added->add_option("--threads", threads, "0: all cores")->capture_default_str();
    command = added;
  }
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("How true the boundary is that lumesh derives from images of known shapes");
  app.require_subcommand(1);
  Part field{lumesh::boundary::run_field, {.seeds = 5}};
  Part mesh{lumesh::boundary::run_mesh, {.seeds = 2}};
  Part openings{lumesh::boundary::run_openings, {.seeds = 60}};
  Part topology{lumesh::boundary::run_topology, {.seeds = 500}};
  Part cost{lumesh::boundary::run_cost, {}};
  field.add_to(app, "field", "The domain's boundary against the exact surfaces",
               "Regular expression: cases whose name it matches in part");
  mesh.add_to(app, "mesh", "The walls of meshes against the exact surfaces",
              "Regular expression: cases whose name it matches in part");
  openings.add_to(app, "openings", "Sections of vessels that others face, at the border and inside",
                  "Regular expression: cases whose name it matches in part");
  topology.add_to(app, "topology", "Pieces, volumes and distances of random label images",
                  "Regular expression: meshers whose name it matches in part; `none': the domain alone");
  cost.add_to(app, "cost", "Time and memory of the label field, from 0.1 to 10 million voxels in the band",
              "");
  CLI11_PARSE(app, argc, argv);
  try {
    for (const Part& part : {field, mesh, openings, topology, cost}) {
      if (!part.command->parsed()) continue;
      const lumesh::parallel::ThreadLimit limit(part.threads);
      part.run(part.options);
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "lumesh_boundary: error: {}\n", error.what());
    return 1;
  }
  return 0;
}
