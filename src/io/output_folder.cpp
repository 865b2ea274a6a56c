#include "output_folder.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <system_error>

#include "file_fault.hpp"
#include "lumesh/io/link_target.hpp"

namespace lumesh::io {

namespace fs = std::filesystem;

namespace {

/// A name beside the target that is not taken yet.
fs::path free_name(const fs::path& target, const char* purpose) {
  std::error_code ignored;
  for (int attempt = 0;; ++attempt) {
    const fs::path name = fmt::format("{}.{}-{}-{}", target.string(), purpose, ::getpid(), attempt);
    if (!fs::exists(fs::symlink_status(name, ignored))) return name;
  }
}

}  // namespace

OutputFolder::OutputFolder(const fs::path& target) : target_(link_target(target)) {
  std::error_code failed;
  if (target_.has_parent_path() && !fs::is_directory(target_.parent_path(), failed)) fail(target_, kNoFolder);
  temporary_ = free_name(target_, "part");
  if (!fs::create_directory(temporary_, failed))
    fail(target_, fmt::format("cannot be made ({})", failed.message()));
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove_all(temporary_, ignored);
}

void OutputFolder::commit() {
  std::error_code failed;
  fs::path old;
  if (fs::exists(target_, failed)) {
    old = free_name(target_, "old");
    fs::rename(target_, old, failed);
    if (failed) fail(target_, fmt::format("cannot be replaced ({})", failed.message()));
  }
  fs::rename(temporary_, target_, failed);
  if (failed) {
    std::error_code ignored;
    if (!old.empty()) fs::rename(old, target_, ignored);
    fail(target_, fmt::format("cannot be written ({})", failed.message()));
  }
  temporary_.clear();
  if (!old.empty()) fs::remove_all(old, failed);
}

}  // namespace lumesh::io
