#include "lumesh/io/new_folder.hpp"

#include <fmt/core.h>

#include <system_error>
#include <utility>

#include "file_fault.hpp"

namespace lumesh::io {

NewFolder::NewFolder(std::filesystem::path path) : path_(std::move(path)) {
  std::error_code fault;
  std::vector<std::filesystem::path> missing;
  for (std::filesystem::path p = path_; !p.empty() && !std::filesystem::exists(p, fault); p = p.parent_path())
    missing.push_back(p);
  std::filesystem::create_directories(path_, fault);
  if (fault) fail(path_, fmt::format("cannot be made ({})", fault.message()));
  new_ = std::move(missing);
}

NewFolder::~NewFolder() {
  std::error_code is_in_use;
  for (const std::filesystem::path& folder : new_) std::filesystem::remove(folder, is_in_use);
}

}  // namespace lumesh::io
