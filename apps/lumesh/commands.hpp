#pragma once
/// @file One function per subcommand; each adds itself to the program and runs when chosen.

#include <CLI/CLI.hpp>

namespace lumesh::cli {

void add_adapt_command(CLI::App& program);
void add_centerline_command(CLI::App& program);
void add_check_command(CLI::App& program);
void add_convert_command(CLI::App& program);
void add_delaunay_command(CLI::App& program);
void add_evaluate_command(CLI::App& program);
void add_improve_command(CLI::App& program);
void add_info_command(CLI::App& program);
void add_lattice_command(CLI::App& program);
void add_layers_command(CLI::App& program);
void add_merge_command(CLI::App& program);
void add_metric_command(CLI::App& program);
void add_phantom_command(CLI::App& program);
void add_rename_command(CLI::App& program);
void add_repair_command(CLI::App& program);
void add_run_command(CLI::App& program);
void add_options_command(CLI::App& program);
void add_completion_command(CLI::App& program);

}  // namespace lumesh::cli
