#include <fmt/core.h>
#include <fmt/ranges.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <limits>
#include <new>
#include <span>

#include "commands.hpp"
#include "common.hpp"
#include "exit_codes.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/nearest_word.hpp"
#include "lumesh/core/version.hpp"
#include "lumesh/parallel/cancellation.hpp"
#include "lumesh/parallel/cancellation_source.hpp"
#include "option_adapter.hpp"
#include "program.hpp"

namespace {

using lumesh::cli::exit_code_of;

int report_error(const char* message, int code) {
  std::fflush(stdout);  // What was said before stands before it where both go to one place.
  lumesh::cli::print_error("lumesh: error: {}\n", message);
  return code;
}

/// One stage's large arrays serve the next one. By default the C library returns each to the system, which
/// clears its pages again: some 5 % of a run.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, std::numeric_limits<int>::max());
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
#endif
}

std::string unknown_text(const char* what, const std::string& word, const std::vector<std::string>& known) {
  const std::string nearest = lumesh::nearest_word(word, known);
  return fmt::format("unknown {} \"{}\"", what, word) +
         (nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest));
}

/// The parser speaks of arguments that it did not expect; this says which word is wrong.
void check_command(const CLI::App& program, const std::string& word) {
  std::vector<std::string> known;
  for (const CLI::App* command : program.get_subcommands({})) known.push_back(command->get_name());
  if (word.starts_with('-') || std::ranges::find(known, word) != known.end()) return;
  throw lumesh::Error(
      lumesh::ErrorKind::kUsage,
      fmt::format("{} (commands: {})", unknown_text("command", word, known), fmt::join(known, ", ")));
}

/// Options among the words that a command does not have, each once. Numbers below 0 are values.
std::vector<std::string> unknown_options(const CLI::App& command, std::span<const char* const> words) {
  std::vector<std::string> unknown;
  for (const std::string word : words) {
    if (word == "--") break;
    if (word.size() < 2 || word[0] != '-' ||
        std::string_view("0123456789.").find(word[1]) != std::string::npos)
      continue;
    const std::string name = word.substr(0, word.starts_with("--") ? word.find('=') : 2);
    if (command.get_option_no_throw(name) == nullptr && std::ranges::find(unknown, name) == unknown.end())
      unknown.push_back(name);
  }
  return unknown;
}

/// Long options, of which one may have been meant; every letter is like another one.
std::vector<std::string> names_like(const CLI::App& command, const std::string& name) {
  std::vector<std::string> known;
  if (name.size() <= 2) return known;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& long_name : option->get_lnames()) known.push_back("--" + long_name);
  return known;
}

/// Message on words that the parser refuses. Whatever else it misses, unknown options go first, all of them:
/// a required one may be missing for being misspelt.
std::string message_of(const CLI::ParseError& error, const CLI::App& program,
                       std::span<const char* const> words) {
  const std::vector<CLI::App*> commands = program.get_subcommands();
  const CLI::App& command = commands.empty() ? program : *commands.front();
  const std::string help = fmt::format(" (lumesh {}--help lists those there are)",
                                       commands.empty() ? "" : command.get_name() + " ");
  const std::vector<std::string> unknown = unknown_options(command, words);
  if (unknown.size() == 1)
    return unknown_text("option", unknown.front(), names_like(command, unknown.front())) + help;
  if (!unknown.empty()) {
    std::vector<std::string> texts;
    for (const std::string& name : unknown) {
      const std::string nearest = lumesh::nearest_word(name, names_like(command, name));
      texts.push_back(nearest.empty() ? fmt::format("\"{}\"", name)
                                      : fmt::format("\"{}\" (did you mean \"{}\"?)", name, nearest));
    }
    return fmt::format("unknown options {}", fmt::join(texts, ", ")) + help;
  }
  const std::vector<std::string> extra = program.remaining(true);
  if (dynamic_cast<const CLI::ExtrasError*>(&error) == nullptr || extra.empty()) return error.what();
  return fmt::format("unexpected argument \"{}\"{}", extra.front(), help);
}

/// With options as the command that runs has them.
std::string message_of(const lumesh::Error& error, CLI::App& program) {
  const std::vector<CLI::App*> commands = program.get_subcommands();
  return commands.empty() ? error.what() : lumesh::cli::with_flags(error.what(), *commands.front());
}

/// Parses the command line, and runs its command. @return The exit code; what goes wrong is a line on stderr.
int run(lumesh::cli::Program& program, int argc, char** argv) {
  try {
    if (argc > 1) check_command(program, argv[1]);
    lumesh::parallel::run_cancellable(program.cancellation().abandon_token(),
                                      [&] { program.parse(argc, argv); });
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);  // --help, --version
    return report_error(message_of(error, program, {argv + 1, static_cast<std::size_t>(argc - 1)}).c_str(),
                        exit_code_of(lumesh::ErrorKind::kUsage));
  } catch (const lumesh::Error& error) {
    return report_error(message_of(error, program).c_str(), exit_code_of(error.kind()));
  } catch (const lumesh::parallel::Cancelled&) {
    return report_error(program.line_of_end().c_str(), exit_code_of(lumesh::ErrorKind::kTimeLimit));
  } catch (const std::bad_alloc&) {
    return report_error("out of memory; ask for a coarser mesh or crop the image",
                        exit_code_of(lumesh::ErrorKind::kMemory));
  } catch (const std::exception& error) {
    return report_error(error.what(), lumesh::cli::kInternalError);
  }
  program.progress().end();
  return 0;
}

/// As after `lumesh … | head -1`: whoever read has what they wanted.
bool reader_has_gone() {
  pollfd out = {STDOUT_FILENO, POLLOUT, 0};
  return poll(&out, 1, 0) > 0 && (out.revents & POLLERR) != 0;
}

#ifdef __ELF__
/// Before the libraries are initialised, which takes 20 ms and longer on a busy machine: a stop that comes
/// then waits for the Program to answer it.
// NOLINTBEGIN(cppcoreguidelines-avoid-non-const-global-variables): the pointer is const; functions have no
// const.
[[gnu::section(".preinit_array"),
  gnu::used]] void (*const kHoldSignals)() = lumesh::parallel::hold_watched_signals;
// NOLINTEND(cppcoreguidelines-avoid-non-const-global-variables)
#endif

/// In the order of the help.
void add_commands(CLI::App& program) {
  using namespace lumesh::cli;
  for (const auto add :
       {add_phantom_command, add_info_command, add_check_command, add_repair_command, add_lattice_command,
        add_delaunay_command, add_metric_command, add_adapt_command, add_improve_command, add_layers_command,
        add_merge_command, add_evaluate_command, add_centerline_command, add_convert_command,
        add_rename_command, add_run_command, add_options_command, add_completion_command})
    add(program);
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  std::signal(SIGPIPE, SIG_IGN);  // Results are written though nobody reads what is said of them.
  lumesh::cli::Program program("lumesh: from segmented images of blood vessels to meshes for simulation",
                               "lumesh");
  program.set_version_flag("--version", std::string("lumesh ") + lumesh::kVersion);
  program.require_subcommand(1);
  program.footer(lumesh::cli::exit_codes_text());
  add_commands(program);
  for (CLI::App* const command : program.get_subcommands({}))
    command->footer(command->get_footer() + "\n" + lumesh::cli::exit_codes_text());
  if (const int code = run(program, argc, argv); code != 0) return code;
  if ((std::fflush(stdout) != 0 || std::ferror(stdout) != 0) && !reader_has_gone())
    return report_error("cannot write to the standard output", exit_code_of(lumesh::ErrorKind::kBadInput));
  return 0;
}
