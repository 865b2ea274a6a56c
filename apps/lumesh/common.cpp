#include "common.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "lumesh/io/output_checks.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/mesh/patch_renaming.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/run_options.hpp"
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

/// Outputs that are wanted, and in files.
std::vector<std::string> files_among(std::vector<std::string> outputs) {
  std::erase_if(outputs, [](const std::string& name) { return name.empty() || name == kStandardOutput; });
  return outputs;
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

Making RunOptions::making() const {
  return {command->get_name(), given_options(*command)};
}

void finish_options(CLI::App& app, RunOptions& options, const std::string& footer, bool has_threads) {
  OptionList list;
  if (has_threads) describe_threads(list, options.threads).alias("nthreads");
  describe_time_limit(list, options.time_limit_s);
  add_options(app, list);
  CLI::Option* const verbose =
      app.add_flag("-v,--verbose", options.verbose, "Say on stderr when each step ends, and its time");
  app.add_flag("-q,--quiet", options.quiet, "Print warnings and errors only")->excludes(verbose);
  options.command = &app;
  app.footer(footer);
}

CLI::Option* add_json_option(CLI::App& command, std::string& path, RunOptions& options,
                             const std::string& holds) {
  return command
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

JsonArray::~JsonArray() {
  if (elements_ > 0) print_out("\n]\n");
}

void JsonArray::print(std::string_view document) {
  print_out("{}{}", elements_++ == 0 ? "[\n" : ",\n", document);
}

void write_json(const RunOptions& options, const std::string& path, std::string text) {
  if (path.empty()) return;
  if (text.ends_with('\n')) text.pop_back();
  if (path == kStandardOutput && options.json_array != nullptr) return options.json_array->print(text);
  text += '\n';
  if (path != kStandardOutput) return write_text_file(path, text);
  print_out("{}", text);
}

CommandRun::CommandRun(const RunOptions& options)
    : limit_(options.threads),
      context([options](std::string_view line) { say(options, "{}\n", line); },
              [this, options](std::string_view text) {
                std::string warning =
                    with_flags(options.with_keys ? options.with_keys(std::string(text)) : std::string(text),
                               *options.command);
                // The first mesh of a case and its last one may deserve the same.
                if (std::ranges::find(warnings_, warning) != warnings_.end()) return;
                warnings_.push_back(std::move(warning));
                print_warning(warnings_.back());
              }) {
  Program& program = program_of(*options.command);
  program.cancellation().begin(options.time_limit_s);
  context.stop_by(program.cancellation().token());
  context.report_results_to([&program] { program.cancellation().keep_results(); });
  program.progress().begin(options.command->get_name(), options.verbose == 0 && options.quiet == 0, context);
  if (options.verbose > 0)
    context.report_phases_to(
        [](const PhaseTime& phase) { print_error("lumesh: {} took {:.2f} s\n", phase.name, phase.seconds); });
}

double CommandRun::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

report::CommandNotes CommandRun::notes(std::vector<report::OutputFile> files) const {
  return {std::move(files), warnings_, seconds(), context.phases()};
}

std::vector<report::OutputFile> files_of(const MeshOutput& output) {
  return {{output.mesh, kMeshWords}, {output.surface, "its boundary"}};
}

void put(std::FILE* stream, std::string text) {
  constexpr const char* kClearLine = "\x1b[K";
  const auto is_control = [](char c) {
    return (static_cast<unsigned char>(c) < ' ' || c == '\x7f') && c != '\n' && c != '\t' && c != '\r';
  };
  std::replace_if(text.begin(), text.end(), is_control, '?');
  // In one piece, for two threads may print.
  std::fputs(::isatty(::fileno(stream)) != 0 ? (kClearLine + text).c_str() : text.c_str(), stream);
}

void print_warning(std::string_view text) {
  print_error("lumesh: warning: {}\n", text);
}

std::string with_formats(const std::string& text, FileUse use) {
  return text + " (" + formats_for(use) + ")";
}

void add_mesh_argument(CLI::App& command, std::string& path, const std::string& name, FileUse use) {
  command.add_option(name, path, with_formats("Mesh to read", use))->required();
}

CLI::Option* add_image_option(CLI::App& command, std::string& path, const std::string& role) {
  return command.add_option(
      "--image", path, with_formats("Label image that the mesh was made of", FileUse::kReadImage) + role);
}

void add_mesh_output(CLI::App& command, std::string& path) {
  command.add_option("-o,--output", path, with_formats(kMeshToWrite, FileUse::kWriteVolume))->required();
}

void add_surface_output(CLI::App& command, std::string& path) {
  OptionList list;
  describe_surface_output(list, path);
  add_options(command, list);
}

void add_report_option(CLI::App& command, std::string& path) {
  OptionList list;
  describe_report(list, path);
  add_options(command, list);
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
  OptionList list;
  describe_names(list, names);
  command.add_option("--name", names, list.all().front().meaning + "; may be repeated")
      ->allow_extra_args(false)
      ->check([](const std::string& text) {
        try {
          return renaming_from(text).name.empty() ? std::string("no name") : std::string();
        } catch (const Error& error) {
          return std::string(error.what());
        }
      });
}

void check_format(const std::string& path, FileUse use) {
  if (!path.empty()) require_format(path, use, ErrorKind::kUsage);
}

void check_output_folders(std::initializer_list<std::string> paths) {
  io::check_output_folders(files_among(paths), ErrorKind::kUsage);
}

void check_inputs_stay(std::initializer_list<std::string> outputs, const std::vector<std::string>& inputs) {
  io::check_inputs_stay(files_among(outputs), inputs, ErrorKind::kUsage);
}

void check_files(std::initializer_list<std::string> outputs, const std::vector<std::string>& inputs,
                 const ImageSelection& selection) {
  check_output_folders(outputs);
  check_inputs_stay(outputs, inputs);
  check_inputs_stay(outputs, selection.other_files());
}

}  // namespace lumesh::cli
