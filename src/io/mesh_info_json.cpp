#include "mesh_info_json.hpp"

#include <array>
#include <nlohmann/json.hpp>

#include "lumesh/mesh/patch_list.hpp"

namespace lumesh::io {

namespace {

using nlohmann::json;

void set_kind(Patch& patch, const std::string& word) {
  for (const PatchKindWord& known : kPatchKindWords)
    if (word == known.word) {
      patch.kind = known.kind;
      patch.flow = known.flow;
    }
}

json patches_to_json(const std::vector<Patch>& patches) {
  json all = json::array();
  for (const Patch& patch : patches)
    all.push_back(
        {{"name", patch.name}, {"kind", kind_word(patch.kind, patch.flow)}, {"labels", patch.labels}});
  return all;
}

}  // namespace

std::string info_to_json(const MeshInfo& info) {
  json names = json::object();
  for (const auto& [label, name] : info.label_names) names[std::to_string(label)] = name;
  const json all = {{"lumesh_info", 1},     {"unit", info.unit},
                    {"frame", info.frame},  {"patches", patches_to_json(info.patches)},
                    {"label_names", names}, {"provenance", info.provenance}};
  // Bytes that are not UTF-8 (a file name of another encoding) must not make writing fail.
  return all.dump(-1, ' ', true, json::error_handler_t::replace);
}

MeshInfo info_from_json(std::string_view text) {
  try {
    const json all = json::parse(text);
    if (!all.is_object() || !all.contains("lumesh_info")) return {};
    MeshInfo info;
    info.unit = all.value("unit", info.unit);
    info.frame = all.value("frame", info.frame);
    for (const json& patch : all.value("patches", json::array())) {
      info.patches.push_back({patch.value("name", std::string()), PatchKind::kWall,
                              patch.value("labels", std::array<Label, 2>{})});
      set_kind(info.patches.back(), patch.value("kind", std::string()));
    }
    for (const auto& [label, name] : all.value("label_names", std::map<std::string, std::string>()))
      info.label_names[std::stoi(label)] = name;
    info.provenance = all.value("provenance", info.provenance);
    return info;
  } catch (const std::exception&) {
    return {};  // A comment of another program.
  }
}

}  // namespace lumesh::io
