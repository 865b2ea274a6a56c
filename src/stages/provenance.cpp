#include "lumesh/stages/provenance.hpp"

#include <fmt/ranges.h>

#include <algorithm>

#include "lumesh/core/version.hpp"
#include "lumesh/io/sha256.hpp"
#include "lumesh/stages/input_cuts.hpp"

namespace lumesh {

std::map<std::string, std::string> provenance_of(const Making& making, const std::string& input_path,
                                                 const std::map<std::string, std::string>& before) {
  const auto input = before.find("input"), hash = before.find("input_sha256");
  const bool known = input != before.end() && hash != before.end();
  std::map<std::string, std::string> result = {
      {"program", std::string("lumesh ") + kVersion},
      {"command", making.command},
      {"options", making.options},
      {"input", known ? input->second : input_path},
      {"input_sha256", known ? hash->second : file_sha256(input_path)}};
  const std::vector<std::string> cuts = cut_options(known ? before : result);
  if (!cuts.empty()) result[kCutsKey] = fmt::format("{}", fmt::join(cuts, " "));
  return result;
}

std::vector<std::string> doubts_about_image(const std::string& image_path, const std::string& mesh_path,
                                            const MeshInfo& info, std::string_view consequence) {
  const auto made_from = info.provenance.find("input_sha256");
  if (made_from == info.provenance.end() || made_from->second.empty()) return {};
  const std::string found = file_sha256(image_path);
  if (found.empty() || found == made_from->second) return {};
  const auto input = info.provenance.find("input");
  return {fmt::format("{}: is not the file that {} was made from{} (SHA-256 {:.8}, not {:.8}); {}",
                      image_path, mesh_path, input == info.provenance.end() ? "" : ", " + input->second,
                      found, made_from->second, consequence)};
}

bool was_extended(const MeshInfo& info) {
  const std::vector<std::string> made_with = cut_options(info.provenance);
  return std::ranges::any_of(made_with,
                             [](const std::string& option) { return option.starts_with("--extend"); });
}

std::vector<std::string> doubts_about_cuts(const InputCuts& given, const std::string& mesh_path,
                                           const MeshInfo& info) {
  const std::vector<std::string> made_with = cut_options(info.provenance);
  if (cut_options(given).size() >= made_with.size()) return {};
  return {fmt::format(
      "{}: was made of an image that was cut or extended, and sizes are those of that image only if the same "
      "cuts are given: {}",
      mesh_path, fmt::join(made_with, " "))};
}

void note_cuts(std::span<const CutPlane> planes, std::map<std::string, std::string>& provenance) {
  InputCuts cuts;
  cuts.planes.assign(planes.begin(), planes.end());
  std::vector<std::string> all = cut_options(provenance);
  for (std::string& option : cut_options(cuts))
    if (std::ranges::find(all, option) == all.end()) all.push_back(std::move(option));
  if (!all.empty()) provenance[kCutsKey] = fmt::format("{}", fmt::join(all, " "));
}

}  // namespace lumesh
