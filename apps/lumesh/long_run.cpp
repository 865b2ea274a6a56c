#include "long_run.hpp"

#include <filesystem>

#include "lumesh/core/error.hpp"
#include "program.hpp"

namespace lumesh::cli {

namespace {

/// The path, or one beside another result that is there already.
std::string partial_path(const std::string& path) {
  namespace fs = std::filesystem;
  const fs::path target(path);
  const bool is_case = target.extension() == ".foam";  // Its mesh is the folder constant/polyMesh beside it.
  const fs::path result = is_case ? target.parent_path() / "constant" / "polyMesh" : target;
  const bool is_folder = fs::is_directory(result);
  if (!is_folder && !fs::is_regular_file(result)) return path;
  for (int number = 1;; ++number) {
    const std::string word = number == 1 ? "partial" : fmt::format("partial-{}", number);
    const std::string beside =
        is_folder ? word : fmt::format("{}.{}{}", target.stem().string(), word, target.extension().string());
    const fs::path free = target.parent_path() / beside;
    if (fs::exists(free)) continue;
    if (!is_folder) return free.string();
    fs::create_directories(free);
    return (free / target.filename()).string();
  }
}

}  // namespace

LongRun::LongRun(const RunOptions& options) : program_(program_of(*options.command)) {}

void LongRun::begin_writing(std::initializer_list<std::string*> paths, bool complete) {
  program_.cancellation().keep_results();
  if (complete) return;
  for (std::string* path : paths) *path = partial_path(*path);
}

std::string LongRun::reason(bool complete) const {
  return complete ? "" : program_.reason_of_stop();
}

void LongRun::check_complete(bool complete, const std::string& path) const {
  if (!complete) throw Error(ErrorKind::kTimeLimit, reason(complete) + path + " holds the best mesh so far");
}

void LongRun::require_sound(const std::string& path, const MeshView& mesh, Context& context, bool complete,
                            const MeshView* made_from) const {
  lumesh::require_sound(path, mesh, context, reason(complete), made_from);
  check_complete(complete, path);
}

}  // namespace lumesh::cli
