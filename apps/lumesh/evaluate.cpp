#include "commands.hpp"

namespace lumesh::cli {

void add_evaluate_command(CLI::App& program) {
  program.add_subcommand("evaluate", "(being built)");
}

}  // namespace lumesh::cli
