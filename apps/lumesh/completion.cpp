/// Scripts that complete command lines, made from the options that the commands have.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <sstream>

#include "commands.hpp"
#include "common.hpp"

namespace lumesh::cli {
namespace {

/// An option as shells have it.
struct Completion {
  std::vector<std::string> flags;   ///< "-o", "--output"
  std::vector<std::string> values;  ///< Words that it takes; none: files, or what only the user knows.
  bool takes_value = false;
  std::string meaning;  ///< Its first clause.
};

/// "frozen|adapt=adapt" and "TEXT:{4.1,2.2}=4.1", as helps have them, are lists of words.
std::vector<std::string> words_in(std::string type) {
  char between = '|';
  if (const std::size_t brace = type.find('{'); brace != std::string::npos) {
    type = type.substr(brace + 1, type.find('}') - brace - 1);
    between = ',';
  }
  std::vector<std::string> words;
  std::istringstream in(type);
  for (std::string word; std::getline(in, word, between);) words.push_back(word);
  return words.size() > 1 || between == ',' ? words : std::vector<std::string>();
}

/// The first clause, without what the quotes of a shell would end at, or expand.
std::string plain(std::string text) {
  text.resize(std::min(text.size(), text.find_first_of(";\n")));
  std::erase_if(text, [](char c) { return std::string_view("'\"`$\\[]").find(c) != std::string_view::npos; });
  return text;
}

Completion completion_of(const CLI::Option& option) {
  Completion made;
  for (const std::string& name : option.get_snames()) made.flags.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) made.flags.push_back("--" + name);
  made.takes_value = option.get_items_expected_max() > 0;
  if (made.takes_value) made.values = words_in(option.get_type_name());
  made.meaning = plain(option.get_description());
  return made;
}

std::vector<Completion> completions_of(const CLI::App& command) {
  std::vector<Completion> all;
  for (const CLI::Option* option : command.get_options())
    if (!option->get_snames().empty() || !option->get_lnames().empty()) all.push_back(completion_of(*option));
  return all;
}

std::string all_flags(const std::vector<Completion>& options) {
  std::string text;
  for (const Completion& one : options)
    text += fmt::format("{}{}", text.empty() ? "" : " ", fmt::join(one.flags, " "));
  return text;
}

std::string all_names(const std::vector<CLI::App*>& commands) {
  std::string text;
  for (const CLI::App* one : commands) text += (text.empty() ? "" : " ") + one->get_name();
  return text;
}

std::string bash_script(const std::vector<CLI::App*>& commands) {
  std::string script =
      "_lumesh() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} options= values=\n"
      "  case ${COMP_WORDS[1]} in\n";
  for (const CLI::App* command : commands) {
    const std::vector<Completion> options = completions_of(*command);
    script += fmt::format("    {})\n      options='{}'\n      case $before in\n", command->get_name(),
                          all_flags(options));
    for (const Completion& one : options)
      if (!one.values.empty())
        script += fmt::format("        {}) values='{}' ;;\n", fmt::join(one.flags, " | "),
                              fmt::join(one.values, " "));
    script += "      esac ;;\n";
  }
  return script + fmt::format(
                      "  esac\n"
                      "  if ((COMP_CWORD == 1)); then values='{} --help --version'; fi\n"
                      "  if [[ -z $values && $word == -* ]]; then values=$options; fi\n"
                      "  if [[ -n $values ]]; then\n"
                      "    mapfile -t COMPREPLY < <(compgen -W \"$values\" -- \"$word\")\n"
                      "  else\n"
                      "    mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
                      "  fi\n"
                      "}}\n"
                      "complete -o filenames -F _lumesh lumesh\n",
                      all_names(commands));
}

std::string zsh_script(const std::vector<CLI::App*>& commands) {
  std::string script = "#compdef lumesh\n_lumesh() {\n  if ((CURRENT == 2)); then\n    compadd -- " +
                       all_names(commands) + "\n    return\n  fi\n  case $words[2] in\n";
  for (const CLI::App* command : commands) {
    script += fmt::format("    {})\n      _arguments -S", command->get_name());
    for (const Completion& one : completions_of(*command)) {
      const std::string action = !one.takes_value ? ""
                                 : one.values.empty()
                                     ? ":value:_files"
                                     : fmt::format(":value:({})", fmt::join(one.values, " "));
      for (const std::string& flag : one.flags)
        script += fmt::format(" \\\n        '*{}[{}]{}'", flag, one.meaning, action);
    }
    script += " \\\n        '*:file:_files' ;;\n";
  }
  return script + "  esac\n}\n(( $+functions[compdef] )) && compdef _lumesh lumesh\n";
}

std::string fish_script(const std::vector<CLI::App*>& commands) {
  std::string script;
  for (const CLI::App* command : commands) {
    script += fmt::format("complete -c lumesh -n __fish_use_subcommand -f -a {} -d '{}'\n",
                          command->get_name(), plain(command->get_description()));
    for (const Completion& one : completions_of(*command)) {
      script += fmt::format("complete -c lumesh -n '__fish_seen_subcommand_from {}'", command->get_name());
      for (const std::string& flag : one.flags)
        script += flag.starts_with("--") ? " -l " + flag.substr(2) : " -s " + flag.substr(1);
      if (!one.values.empty()) script += fmt::format(" -x -a '{}'", fmt::join(one.values, " "));
      if (one.values.empty() && one.takes_value) script += " -r";
      script += fmt::format(" -d '{}'\n", one.meaning);
    }
  }
  return script;
}

}  // namespace

void add_completion_command(CLI::App& program) {
  const auto shell = std::make_shared<std::string>();
  CLI::App* sub =
      program.add_subcommand("completion", "Print what makes a shell complete commands and options");
  sub->add_option("shell", *shell, "bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  sub->footer("Example: source <(lumesh completion bash)");
  sub->callback([shell, &program] {
    const std::vector<CLI::App*> commands = program.get_subcommands({});
    print_out("{}", *shell == "bash"  ? bash_script(commands)
                    : *shell == "zsh" ? zsh_script(commands)
                                      : fish_script(commands));
  });
}

}  // namespace lumesh::cli
