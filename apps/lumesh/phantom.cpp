#include "commands.hpp"

namespace lumesh::cli {

void add_phantom_command(CLI::App& program) {
  program.add_subcommand("phantom", "(being built)");
}

}  // namespace lumesh::cli
