#pragma once
/// @file One function per subcommand; each adds itself to the program and runs when chosen.

#include <CLI/CLI.hpp>

namespace lumesh::cli {

using AddCommand = void(CLI::App& program);
AddCommand add_adapt_command, add_centerline_command, add_check_command, add_convert_command,
    add_delaunay_command, add_evaluate_command, add_improve_command, add_info_command, add_lattice_command,
    add_layers_command, add_merge_command, add_metric_command, add_phantom_command, add_rename_command,
    add_repair_command, add_run_command, add_options_command, add_completion_command;

}  // namespace lumesh::cli
