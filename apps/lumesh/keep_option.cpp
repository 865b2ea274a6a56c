#include "keep_option.hpp"

namespace lumesh::cli {

CLI::Option* add_keep_option(CLI::App& command, std::vector<std::string>& labels) {
  return command
      .add_option("--keep", labels,
                  "Cells of these labels (names or numbers) stay exactly as they are, whatever their shape: "
                  "layers or a wall")
      ->delimiter(',')
      ->allow_extra_args(false);
}

}  // namespace lumesh::cli
