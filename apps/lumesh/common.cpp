#include "common.hpp"

#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>

#include "lumesh/core/error.hpp"
#include "lumesh/core/version.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/sha256.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/quality/faults.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "option_adapter.hpp"
#include "program.hpp"

namespace lumesh::cli {

namespace {

/// The options of the command line as they were given, but for those that do not change the mesh.
std::string given_options(const CLI::App& command) {
  std::string all;
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    constexpr std::string_view kElsewhere[] = {"--threads", "--verbose",  "--quiet",  "--output",
                                               "--surface", "--json",     "--report", "--metric-output",
                                               "--balance", "--topology", "--pin",    "--time-limit"};
    if (std::find(std::begin(kElsewhere), std::end(kElsewhere), name) != std::end(kElsewhere)) continue;
    if (option->count() == 0 || option->get_positional()) continue;
    all += (all.empty() ? "" : " ") + name;
    if (option->get_items_expected_max() == 0) continue;
    char between = ' ';
    for (const std::string& value : option->results()) {
      all += between + value;
      if (option->get_delimiter() != '\0') between = option->get_delimiter();  // Lists are one word.
    }
  }
  return all;
}

/// Where an output goes: links are followed.
std::filesystem::path target_of(const std::filesystem::path& path) {
  std::error_code failed;
  const std::filesystem::path target = std::filesystem::weakly_canonical(path, failed);
  if (failed) throw Error(ErrorKind::kBadInput, path.string() + ": cannot be written: " + failed.message());
  if (std::filesystem::is_regular_file(target, failed) && std::filesystem::is_symlink(path, failed) &&
      target.extension() != path.extension())
    throw Error(ErrorKind::kBadInput,
                path.string() + ": is a link to " + target.string() +
                    ", a file of another kind, which would be replaced; remove the link");
  return target;
}

/// Whether an output is wanted, and in a file.
bool is_file(const std::filesystem::path& output) {
  return !output.empty() && output != kStandardOutput;
}

/// @throws Error{kUsage} for a file that holds something else.
void require_json_or_new(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return;
  const int first = std::ifstream(path).get();
  if (first == EOF || first == '{' || first == '[') return;
  throw Error(ErrorKind::kUsage,
              path + ": holds no JSON and would be replaced; name another file for --json");
}

}  // namespace

void finish_options(CLI::App& app, RunOptions& options, const std::string& footer, bool has_threads) {
  if (has_threads)
    app.add_option("--threads,--nthreads", options.threads, "Threads; 0 = all cores")
        ->check(CLI::Range(0, 4096))
        ->capture_default_str();
  OptionList list;
  list.number("time_limit", options.time_limit_s, above(0),
              "Stop then, with exit code 4; adapt, delaunay, improve and run write the best mesh so far")
      .in("s")
      .zero("none", std::numeric_limits<double>::infinity());
  add_options(app, list);
  CLI::Option* const verbose =
      app.add_flag("-v,--verbose", options.verbose, "Say on stderr when each step ends, and its time");
  app.add_flag("-q,--quiet", options.quiet, "Print warnings and errors only")->excludes(verbose);
  options.command = &app;
  app.footer(footer);
}

void add_json_option(CLI::App& command, std::string& path, RunOptions& options, const std::string& holds) {
  command
      .add_option_function<std::vector<std::string>>(
          "--json",
          [&path, &options](const std::vector<std::string>& values) {
            path = values.empty() || values.front().empty() ? kStandardOutput : values.front();
            if (path == kStandardOutput)
              options.quiet = 1;
            else
              require_json_or_new(path);
          },
          "Write " + holds + " as JSON; - or nothing: to the standard output, in place of the text")
      ->type_name("[FILE]")
      ->expected(0, 1);
}

void write_json(const std::string& path, const std::string& text) {
  const std::string whole = text.ends_with('\n') ? text : text + "\n";
  if (path == kStandardOutput)
    print_out("{}", whole);
  else
    write_text_file(path, whole);
}

Context make_context(const RunOptions& options) {
  Context context(
      {}, [command = options.command](std::string_view text) { print_warning(with_flags(text, *command)); });
  Program& program = program_of(*options.command);
  program.cancellation().begin(options.time_limit_s);
  context.stop_by(program.cancellation().token());
  context.report_results_to([&program] { program.cancellation().keep_results(); });
  program.progress().begin(options.command->get_name(), options.verbose == 0 && options.quiet == 0, context);
  if (options.verbose > 0)
    context.report_phases_to(
        [](const PhaseTime& phase) { print_error("lumesh: {} took {:.2f} s\n", phase.name, phase.seconds); });
  return context;
}

void put(std::FILE* stream, const std::string& text) {
  constexpr const char* kClearLine = "\x1b[K";
  // In one piece, for two threads may print.
  std::fputs(::isatty(::fileno(stream)) != 0 ? (kClearLine + text).c_str() : text.c_str(), stream);
}

void print_warning(std::string_view text) {
  print_error("lumesh: warning: {}\n", text);
}

void add_mesh_argument(CLI::App& command, std::string& path, const std::string& name) {
  command.add_option(name, path, "Mesh to read (" + formats_for(MeshUse::kReadVolume) + ")")->required();
}

void add_mesh_output(CLI::App& command, std::string& path) {
  command.add_option("-o,--output", path, "Mesh to write (" + formats_for(MeshUse::kWriteVolume) + ")")
      ->required();
}

void add_surface_output(CLI::App& command, std::string& path) {
  command.add_option("--surface", path,
                     "Also write the boundary (" + formats_for(MeshUse::kWriteSurface) + ")");
}

void add_unit_option(CLI::App& command, std::string& unit) {
  OptionList list;
  describe_unit(list, unit);
  add_options(command, list);
}

void add_out_unit_option(CLI::App& command, std::string& unit) {
  OptionList list;
  describe_out_unit(list, unit);
  add_options(command, list);
}

void add_name_option(CLI::App& command, std::vector<std::string>& names) {
  command
      .add_option(
          "--name", names,
          "PATCH=NAME, such as outlet_2=left_ica, X,Y,Z=NAME for the opening near a place in mm, "
          "AREAmm2=NAME for "
          "the one of about that area; NAME:KIND says what it is: inlet, outlet, wall or symmetry; may be "
          "repeated; lumesh info lists the openings of an image")
      ->allow_extra_args(false)
      ->check([](const std::string& text) {
        try {
          return renaming_from(text).name.empty() ? std::string("no name") : std::string();
        } catch (const Error& error) {
          return std::string(error.what());
        }
      });
}

void check_volume_output(const std::string& path) {
  if (is_volume_file(path)) return;
  throw Error(ErrorKind::kUsage,
              path + ": unknown mesh format; use " + formats_for(MeshUse::kWriteVolume, " or "));
}

void check_surface_output(const std::string& path) {
  if (path.empty() || is_surface_file(path)) return;
  throw Error(ErrorKind::kUsage,
              path + ": unknown surface format; use " + formats_for(MeshUse::kWriteSurface, " or "));
}

void check_inputs_stay(std::initializer_list<std::string> outputs, const std::vector<std::string>& inputs) {
  std::error_code ignored;  // Of files that do not exist, which is told when they are read.
  // All files of a folder are read, as of a DICOM series.
  const auto is_read = [&](const std::filesystem::path& output, const std::string& input) {
    if (std::filesystem::is_regular_file(input, ignored))
      return std::filesystem::equivalent(output, input, ignored);
    return std::filesystem::is_directory(input, ignored) && std::filesystem::exists(output, ignored) &&
           std::filesystem::equivalent(std::filesystem::absolute(output).parent_path(), input, ignored);
  };
  for (const std::string& output : outputs)
    for (const std::string& input : inputs)
      if (is_file(output) && !input.empty() && is_read(output, input))
        throw Error(ErrorKind::kUsage,
                    output + ": is read as input and would be replaced; name another output");
}

void check_output_folders(std::initializer_list<std::string> paths) {
  std::set<std::filesystem::path> named;
  for (const std::string& path : paths)
    if (is_file(path) && !named.insert(target_of(std::filesystem::absolute(path).lexically_normal())).second)
      throw Error(ErrorKind::kUsage, path + ": is named for two outputs; give each its own file");
  for (std::filesystem::path path : paths) {
    if (!is_file(path)) continue;
    check_mesh_folder(path);
    if (is_mesh_folder(path) && !path.has_filename()) path = path.parent_path();  // A slash at the end.
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    std::error_code ignored;
    if (!std::filesystem::is_directory(folder, ignored))
      throw Error(ErrorKind::kBadInput, path.string() + ": its folder does not exist; create it first");
    const std::filesystem::file_status status = std::filesystem::status(path, ignored);
    if (std::filesystem::is_directory(status) && !is_mesh_folder(path))
      throw Error(ErrorKind::kBadInput, path.string() + ": is a folder; give the name of a file");
    const bool device = std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
    if (!device && ::access(folder.c_str(), W_OK | X_OK) != 0)
      throw Error(ErrorKind::kBadInput, path.string() + ": cannot be written; its folder is read-only");
  }
}

void check_files(std::initializer_list<std::string> outputs, const std::vector<std::string>& inputs,
                 const ImageSelection& selection) {
  check_output_folders(outputs);
  check_inputs_stay(outputs, inputs);
  check_inputs_stay(outputs, selection.other_files());
}

std::map<std::string, std::string> provenance_of(const CLI::App& command, const std::string& input_path,
                                                 const std::map<std::string, std::string>& before) {
  const auto input = before.find("input"), hash = before.find("input_sha256");
  const bool known = input != before.end() && hash != before.end();
  std::map<std::string, std::string> result = {
      {"program", std::string("lumesh ") + kVersion},
      {"command", command.get_name()},
      {"options", given_options(command)},
      {"input", known ? input->second : input_path},
      {"input_sha256", known ? hash->second : file_sha256(input_path)}};
  const std::vector<std::string> cuts = cut_options(known ? before : result);
  if (!cuts.empty()) result[kCutsKey] = fmt::format("{}", fmt::join(cuts, " "));
  return result;
}

void require_sound(const std::string& path, const MeshView& mesh, Context& context,
                   const std::string& besides, const MeshView* made_from) {
  const std::vector<std::string> faults =
      context.phase("validity", [&] { return quality::find_faults(mesh); });
  if (faults.empty()) return;
  const bool was_before = made_from != nullptr && !quality::find_faults(*made_from).empty();
  throw Error(
      ErrorKind::kNotReached,
      fmt::format("{}{}: the mesh is invalid{}: {}; do not use it. `lumesh evaluate` lists all problems",
                  besides, path, was_before ? ", as the one that it was made from" : "",
                  fmt::join(faults, "; ")));
}

void warn_of_faults(const std::string& path, const MeshView& mesh) {
  for (const std::string& fault : quality::find_faults(mesh))
    print_warning(fmt::format("{}: the mesh is invalid: {}; it is kept as it is", path, fault));
}

}  // namespace lumesh::cli
