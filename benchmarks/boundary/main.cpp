/// How true the boundary is that lumesh derives from images of known shapes.

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <exception>

#include "commands.hpp"
#include "lumesh/parallel/loops.hpp"

namespace {

using lumesh::boundary::RunOptions;

void add_options(CLI::App& command, RunOptions& options, int& threads) {
  command.add_option("--only", options.only, "Regular expression: cases whose name it matches in part");
  command.add_option("--seeds", options.seeds, "Random images of each case")->capture_default_str();
  command.add_option("--first-seed", options.first_seed, "The others follow it")->capture_default_str();
  command.add_option("--json", options.json_path, "Writes one line of JSON per image");
  command.add_option("--threads", threads, "0: all cores")->capture_default_str();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("How true the boundary is that lumesh derives from images of known shapes");
  app.require_subcommand(1);
  RunOptions options;
  int threads = 0;
  CLI::App* field = app.add_subcommand("field", "The domain's boundary against the exact surfaces");
  add_options(*field, options, threads);
  CLI::App* mesh = app.add_subcommand("mesh", "The walls of meshes against the exact surfaces");
  add_options(*mesh, options, threads);
  CLI11_PARSE(app, argc, argv);
  try {
    const lumesh::parallel::ThreadLimit limit(threads);
    if (field->parsed()) lumesh::boundary::run_field(options);
    if (mesh->parsed()) lumesh::boundary::run_mesh(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "lumesh_boundary: error: {}\n", error.what());
    return 1;
  }
  return 0;
}
