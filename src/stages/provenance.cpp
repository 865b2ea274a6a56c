#include "lumesh/stages/provenance.hpp"

#include <fmt/ranges.h>

#include <algorithm>

#include "lumesh/core/option_words.hpp"
#include "lumesh/core/version.hpp"
#include "lumesh/io/sha256.hpp"
#include "lumesh/mesh/face_numbers.hpp"

namespace lumesh {
namespace {

constexpr const char* kCutsKey = "cuts";

/// Cuts of the image that a mesh was made from: as its provenance lists them, else as its options say them.
InputCuts cuts_in(const std::map<std::string, std::string>& provenance) {
  InputCuts cuts;
  auto words = provenance.find(kCutsKey);
  if (words == provenance.end()) words = provenance.find("options");
  if (words != provenance.end()) take_option_words(words->second, options_of(cuts));
  return cuts;
}

/// Words of each cut: "--cut-at 1,2,3", "--cut-plane 1 2 3 0 0 1".
std::vector<std::string> words_of(InputCuts cuts) {
  return option_words(options_of(cuts));
}

}  // namespace

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
  put_cuts(cuts_in(known ? before : result), result);
  for (const auto& [key, note] : before)
    if (key.starts_with(kFaceNote)) result.emplace(key, note);
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

void put_cuts(const InputCuts& cuts, std::map<std::string, std::string>& provenance) {
  if (!cuts.none()) provenance[kCutsKey] = fmt::format("{}", fmt::join(words_of(cuts), " "));
}

bool was_extended(const MeshInfo& info) {
  return cuts_in(info.provenance).extension.is_wanted();
}

std::vector<std::string> doubts_about_cuts(const InputCuts& given, const std::string& mesh_path,
                                           const MeshInfo& info) {
  const std::vector<std::string> made_with = words_of(cuts_in(info.provenance));
  if (words_of(given).size() >= made_with.size()) return {};
  return {fmt::format(
      "{}: was made of an image that was cut or extended, and sizes are those of that image only if the same "
      "cuts are given: {}",
      mesh_path, fmt::join(made_with, " "))};
}

void note_cuts(std::span<const CutPlane> planes, std::map<std::string, std::string>& provenance) {
  InputCuts cuts = cuts_in(provenance);
  for (const CutPlane& plane : planes) {
    const auto is_same = [&](const CutPlane& other) {
      return other.point_mm == plane.point_mm && other.normal == plane.normal;
    };
    if (std::ranges::none_of(cuts.planes, is_same)) cuts.planes.push_back(plane);
  }
  put_cuts(cuts, provenance);
}

}  // namespace lumesh
