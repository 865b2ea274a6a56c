#include "phantom_files.hpp"

#include <fstream>

#include "lumesh/core/error.hpp"

namespace lumesh::cli {

/// Written beside the target and renamed when complete.
void write_parameters(const std::filesystem::path& path, const PhantomSpec& spec) {
  std::filesystem::path partial = path;
  partial += ".part";
  std::error_code failed;
  {
    std::ofstream file(partial);
    file << to_json_text(spec);
    file.close();
    if (!file) failed = std::make_error_code(std::errc::io_error);
  }
  if (!failed) std::filesystem::rename(partial, path, failed);
  if (!failed) return;
  std::error_code ignored;
  std::filesystem::remove(partial, ignored);
  throw Error(ErrorKind::kBadInput,
              path.string() + ": cannot be written; does its folder exist and have room?");
}

}  // namespace lumesh::cli
