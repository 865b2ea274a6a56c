#pragma once
/// @file What several subcommands share: options, the context they run in, checks of paths.

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/io/file_formats.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/report/command_notes.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/mesh_output.hpp"
#include "lumesh/stages/provenance.hpp"

namespace lumesh::cli {

class Program;

/// Text of help with the formats of its files: "Mesh to read (.vtu, .vtk)".
[[nodiscard]] std::string with_formats(const std::string& text, FileUse use);

/// Why an option of surfaces is refused.
[[nodiscard]] inline std::string only_for_surfaces(const std::string& image) {
  return fmt::format("is for surfaces, and {} is an image", image);
}

/// Help of a mesh that is written.
inline constexpr const char* kMeshToWrite = "Mesh to write";
/// Help of an option with flags of its own that does what the option of this name does.
template <class Described>
[[nodiscard]] std::string meaning_of(Described described, std::string_view name) {
  const OptionList list = options_of(described);
  return std::ranges::find(list.all(), name, &Option::name)->meaning;
}

/// Help of --report where it shows what was done.
inline constexpr const char* kReportHelp = "Write it as a page with pictures (.html)";

/// In the place of a file: what is written goes to the standard output.
inline constexpr const char* kStandardOutput = "-";

/// Several documents on the standard output as one array, which ends with it.
class JsonArray {
 public:
  JsonArray() = default;
  ~JsonArray();
  JsonArray(const JsonArray&) = delete;
  JsonArray& operator=(const JsonArray&) = delete;

  /// @param document  Without a line break at its end.
  void print(std::string_view document);

 private:
  std::size_t elements_ = 0;
};

/// How a command runs and how much it says.
struct RunOptions {
  int threads = 0;
  std::size_t verbose = 0;
  std::size_t quiet = 0;
  double time_limit_s = std::numeric_limits<double>::infinity();
  CLI::App* command = nullptr;  ///< Whose names of options warnings use; finish_options() sets it.
  std::function<std::string(const std::string&)> with_keys = {};  ///< Names that come before these, if any.
  JsonArray* json_array = nullptr;  ///< Array that takes JSON for the standard output; null: it stands alone.

  /// How the command makes a mesh: with the options given, but for those that do not change it.
  [[nodiscard]] Making making() const;
};
/// --time-limit, -v and -q, behind --threads where it has any, and the example in the help.
void finish_options(CLI::App& app, RunOptions& options, const std::string& footer, bool has_threads);
/// The same, and what the command does when it is chosen: perform(*command).
template <class Command, class Perform>
void finish_command(CLI::App& app, const std::shared_ptr<Command>& command, const Perform& perform,
                    const std::string& footer, bool has_threads = true) {
  finish_options(app, command->run, footer, has_threads);
  app.callback([command, perform] { perform(*command); });
}
/// Calls run() of the command's own file.
template <class Command>
void finish_command(CLI::App& app, const std::shared_ptr<Command>& command, const std::string& footer,
                    bool has_threads = true) {
  finish_command(
      app, command, [](auto& chosen) { run(chosen); }, footer, has_threads);
}
/// --json [FILE], of all commands that have it: "-", as without a FILE, is the standard output, which says
/// nothing else then. A file that is there and is no JSON is refused: an option that may go without a value
/// is easily given that of its neighbour. @param holds  What is written, for the help.
CLI::Option* add_json_option(CLI::App& command, std::string& path, RunOptions& options,
                             const std::string& holds);
/// Writes what that asks for; nothing where it was not given.
void write_json(const RunOptions& options, const std::string& path, std::string text);

/// What a command runs in, made before anything else. Stops and the time limit end it (Program), warnings go
/// to stderr; with -v so does each phase as it ends, with its time, else how far the command is.
class CommandRun {
 public:
  explicit CommandRun(const RunOptions& options);
  CommandRun(const CommandRun&) = delete;
  CommandRun& operator=(const CommandRun&) = delete;

  [[nodiscard]] double seconds() const;
  /// Notes on the command so far. @param files  What it wrote; see CommandNotes.
  [[nodiscard]] report::CommandNotes notes(std::vector<report::OutputFile> files) const;

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  parallel::ThreadLimit limit_;
  std::vector<std::string> warnings_;

 public:
  Context context;
};
using report::kCenterlineWords;
using report::kMeshWords;
[[nodiscard]] std::vector<report::OutputFile> files_of(const MeshOutput& output);
/// Writes to a stream, on a terminal in the place of the line that tells the progress. Control characters,
/// which names in files may have and a terminal would obey, become question marks. What cannot be written is
/// lost: results matter more; the end of the program looks whether stdout took all.
void put(std::FILE* stream, std::string text);
/// Prints to stdout, or to stderr.
template <class... Args>
void print_out(fmt::format_string<Args...> format, Args&&... args) {
  put(stdout, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void print_error(fmt::format_string<Args...> format, Args&&... args) {
  put(stderr, fmt::format(format, std::forward<Args>(args)...));
}

/// Prints to stdout unless -q was given.
template <class... Args>
void say(const RunOptions& options, fmt::format_string<Args...> format, Args&&... args) {
  if (options.quiet == 0) print_out(format, std::forward<Args>(args)...);
}
/// A line that pipes see at once, too.
inline void say_line(const RunOptions& options, std::string_view line) {
  say(options, "{}\n", line);
  std::fflush(stdout);
}

/// One warning line on stderr.
void print_warning(std::string_view text);

/// The positional argument of a command that reads a mesh, -o of one that writes a volume mesh, and --surface
/// of one that can write its boundary, too.
void add_mesh_argument(CLI::App& command, std::string& path, const std::string& name = "mesh",
                       FileUse use = FileUse::kReadVolume);
/// --image, of commands for meshes. @param role  What it is for, at the end of the help.
CLI::Option* add_image_option(CLI::App& command, std::string& path, const std::string& role);
void add_mesh_output(CLI::App& command, std::string& path);
void add_surface_output(CLI::App& command, std::string& path);
/// --report, of commands that measure a whole mesh, --unit and --out-unit.
void add_report_option(CLI::App& command, std::string& path);
void add_unit_option(CLI::App& command, std::string& unit);
void add_out_unit_option(CLI::App& command, std::string& unit);

/// --name, of commands that make meshes; texts for renaming_from().
void add_name_option(CLI::App& command, std::vector<std::string>& names);

/// @throws Error{kUsage} unless a file of this name can be used so; an empty name is not a wanted one.
void check_format(const std::string& path, FileUse use);

/// Refuses outputs that could not be written, before time is spent on them; empty names are not wanted ones.
/// @throws Error{kBadInput} if a folder does not exist or the name is that of a folder, Error{kUsage} if two
/// outputs are the same file.
void check_output_folders(std::initializer_list<std::string> paths);

/// @throws Error{kUsage} if an output would replace an input; empty names are not wanted ones.
void check_inputs_stay(std::initializer_list<std::string> outputs, const std::vector<std::string>& inputs);

/// Both of these checks of all outputs, and that they do not replace other images that a selection reads.
void check_files(std::initializer_list<std::string> outputs, const std::vector<std::string>& inputs,
                 const ImageSelection& selection = {});

}  // namespace lumesh::cli
