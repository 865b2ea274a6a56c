#include "commands.hpp"

namespace lumesh::cli {

void add_lattice_command(CLI::App& program) {
  program.add_subcommand("lattice", "(being built)");
}

}  // namespace lumesh::cli
