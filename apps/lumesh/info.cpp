#include "commands.hpp"

namespace lumesh::cli {

void add_info_command(CLI::App& program) {
  program.add_subcommand("info", "(being built)");
}

}  // namespace lumesh::cli
