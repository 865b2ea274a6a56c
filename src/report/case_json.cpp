#include <limits>
#include <nlohmann/json.hpp>

#include "layers_json.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/report/case_report.hpp"
#include "lumesh/report/stage_parts.hpp"
#include "lumesh/report/summary.hpp"

namespace lumesh::report {

namespace {

using CaseJson = nlohmann::ordered_json;

CaseJson figures_json(const std::vector<Figure>& figures) {
  CaseJson json = CaseJson::array();
  for (const Figure& figure : figures) {
    CaseJson one = {{"name", figure.name}};
    std::visit([&](const auto& value) { one["value"] = value; }, figure.value);
    one["unit"] = figure.unit;
    if (!figure.note.empty()) one["note"] = figure.note;
    json.push_back(std::move(one));
  }
  return json;
}

CaseJson stage_json(const StageReport& stage) {
  CaseJson steps = CaseJson::array(), captions = CaseJson::array();
  for (const PhaseTime& step : stage.steps) steps.push_back({{"name", step.name}, {"seconds", step.seconds}});
  for (const NamedPicture& picture : stage.pictures) captions.push_back(picture.caption);
  CaseJson json = {{"name", stage.name},
                   {"what", stage.what},
                   {"mesh_name", stage.mesh_name},
                   {"seconds", stage.seconds},
                   {"figures", figures_json(stage.figures)},
                   {"warnings", stage.warnings},
                   {"steps", steps},
                   {"pictures", captions},
                   {"evaluation", stage.evaluation ? CaseJson::parse(evaluation_json(*stage.evaluation))
                                                   : CaseJson(nullptr)}};
  if (stage.layers) json["layers"] = layers_of_mesh_json(*stage.layers);
  return json;
}

Figure figure_of(const CaseJson& json) {
  Figure figure{json.at("name"), std::uint64_t{0}, json.at("unit"), json.value("note", "")};
  const CaseJson& value = json.at("value");
  if (value.is_string())
    figure.value = value.get<std::string>();
  else if (value.is_number_unsigned())
    figure.value = value.get<std::uint64_t>();
  else  // What is no finite number is written as null.
    figure.value = value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
  return figure;
}

}  // namespace

std::string stage_notes_json(const StageReport& stage) {
  CaseJson json = {
      {"what", stage.what}, {"figures", figures_json(stage.figures)}, {"warnings", stage.warnings}};
  if (stage.layers) json["layers"] = whole_report_json(stage.layers->report);
  return json.dump(1, ' ', false, CaseJson::error_handler_t::replace) + "\n";
}

void take_stage_notes(const std::string& json, StageReport& stage) {
  try {
    const CaseJson notes = CaseJson::parse(json);
    StageReport read;
    read.what = notes.at("what");
    read.warnings = notes.at("warnings").get<std::vector<std::string>>();
    for (const CaseJson& figure : notes.at("figures")) read.figures.push_back(figure_of(figure));
    if (notes.contains("layers")) read.layers = {.report = layer_report_of(notes.at("layers"))};
    stage.what = std::move(read.what);
    stage.warnings = std::move(read.warnings);
    stage.figures = std::move(read.figures);
    stage.layers = std::move(read.layers);
  } catch (const CaseJson::exception& error) {
    throw Error(ErrorKind::kBadInput, std::string("is no note on a stage: ") + error.what());
  }
}

std::string case_report_json(const CaseReport& report) {
  CaseJson files = CaseJson::array(), stages = CaseJson::array();
  for (const OutputFile& file : report.files) files.push_back({{"path", file.path}, {"what", file.what}});
  for (const StageReport& stage : report.stages) stages.push_back(stage_json(stage));
  const CaseJson json = {{"title", report.title},
                         {"complete", report.complete},
                         {"seconds", report.seconds},
                         {"peak_memory_bytes", report.peak_memory_bytes},
                         {"stages", stages},
                         {"files", files},
                         {"configuration", report.configuration},
                         {"provenance", report.provenance}};
  return json.dump(1, ' ', false, CaseJson::error_handler_t::replace) + "\n";
}

}  // namespace lumesh::report
