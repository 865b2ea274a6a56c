#include "commands.hpp"

namespace lumesh::cli {

void add_convert_command(CLI::App& program) {
  program.add_subcommand("convert", "(being built)");
}

}  // namespace lumesh::cli
