
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "lumesh/io/file_formats.hpp"
#include "lumesh/mesh/merge.hpp"
#include "lumesh/pipeline/pipeline.hpp"
#include "lumesh/stages/conversion.hpp"
#include "lumesh/stages/repair_stage.hpp"
#include "option_adapter.hpp"

namespace lumesh::cli {
namespace {

nlohmann::ordered_json option_json(const Option& option) {
  nlohmann::ordered_json json = {{"name", option.name}, {"aliases", option.aliases}};
  if (!option.unit.empty()) json["unit"] = option.unit;
  if (const std::string range = option.range.text(); !range.empty()) json["range"] = range;
  if (const auto* const word = std::get_if<OptionWord>(&option.target)) json["words"] = word->words;
  json["default"] = option.value_text();
  if (option.zero_text) json["zero"] = *option.zero_text;
  json["meaning"] = meaning_of(option);
  json["flags"] = flags_of(option);
  return json;
}

nlohmann::ordered_json sections_json() {
  Case c;
  nlohmann::ordered_json json;
  for (const CaseSection& section : sections_of(c)) {
    nlohmann::ordered_json& options = json[section.name.empty() ? "case" : section.name];
    for (const Option& option : section.options.all()) options.push_back(option_json(option));
  }
  // Stages that cases have as a part of others only, or not at all.
  const auto add = [&](const char* command, auto described) {
    const OptionList options = options_of(described);
    for (const Option& option : options.all()) json[command].push_back(option_json(option));
  };
  add("improve", ImproveOptions());
  add("repair", RepairRequest());
  add("convert", ConversionRequest());
  add("merge", MergeOptions());
  add("phantom", PhantomSpec());
  for (const auto& [use, words] : file_uses()) json["formats"][words] = format_names(use);
  return json;
}

void print_sections() {
  Case c;
  for (const CaseSection& section : sections_of(c)) {
    if (!section.name.empty()) print_out("\n[{}]  {}\n", section.name, section.meaning);
    for (const Option& option : section.options.all()) {
      const std::string values = option.domain_text();
      print_out("  {:<20} {}{}; default {}\n", option.name, meaning_of(option),
                values.empty() ? "" : "; " + values, option.value_text());
    }
  }
}

}  // namespace

void add_options_command(CLI::App& program) {
  const auto json_path = std::make_shared<std::string>();
  const auto ran = std::make_shared<RunOptions>();
  CLI::App* sub =
      program.add_subcommand("options", "List all options of all stages, as case files name them");
  add_json_option(*sub, *json_path, *ran,
                  "name, aliases, unit, range, words, default and meaning of each, and all formats of files");
  sub->footer("Example: lumesh options");
  sub->callback([json_path, ran] {
    if (!json_path->empty()) write_json(*ran, *json_path, sections_json().dump(2));
    if (ran->quiet == 0) print_sections();
  });
}

}  // namespace lumesh::cli
