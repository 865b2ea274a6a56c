#include "checkpoints.hpp"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <span>

#include "case_sections.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/version.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/polylines_file.hpp"
#include "lumesh/io/sha256.hpp"
#include "lumesh/io/text_file.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/report/stage_parts.hpp"

namespace lumesh::pipeline {
namespace {

/// Hash of a file that a key of the case names; empty for words and for none.
std::string hash_of(const std::string& path) {
  if (path.empty() || path == "centerline" || path == "phantom") return path;
  return file_sha256(path);
}

std::filesystem::path notes_of(std::filesystem::path file) {
  return file += ".json";
}

/// A key beside a file and its notes. They themselves count, too: what is cut short is not taken.
std::string key_line(const std::string& key, const std::filesystem::path& file) {
  return key + " " + file_sha256(file) + " " + file_sha256(notes_of(file)) + "\n";
}

/// A hash of the voxels and their frame, which tells other contents of images of several files: of each
/// slice, and of those.
std::string content_of(const LabelImage& image) {
  const ImageFrame& frame = image.frame();
  const auto slice = static_cast<std::size_t>(frame.size.x()) * static_cast<std::size_t>(frame.size.y());
  std::vector<std::string> parts(static_cast<std::size_t>(frame.size.z()));
  parallel::for_each_block(
      image.voxels().size(), slice, [&](std::size_t k, std::size_t begin, std::size_t end) {
        const auto bytes = std::as_bytes(std::span(image.voxels()).subspan(begin, end - begin));
        parts[k] = text_sha256({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
      });
  std::string crossings;
  for (const FaceCrossing& crossing : image.crossings())
    fmt::format_to(std::back_inserter(crossings), "{} {} {:a}\n", crossing.voxel, crossing.axis,
                   crossing.fraction);
  parts.push_back(text_sha256(crossings));
  parts.push_back(fmt::format("{} {} {:a} {:a} {:a}", fmt::join(image.values(), " "),
                              fmt::join(frame.size, " "), fmt::join(frame.direction.reshaped(), " "),
                              fmt::join(frame.spacing_mm, " "), fmt::join(frame.origin_mm, " ")));
  return text_sha256(fmt::format("{}", fmt::join(parts, " ")));
}

}  // namespace

std::filesystem::path Checkpoints::file_of(CaseStage stage) const {
  return folder_ / (std::string(names_of(stage).word) + (stage == CaseStage::kCenterline ? ".vtp" : ".vtu"));
}

bool Checkpoints::has(CaseStage stage, const std::string& key) const {
  const std::filesystem::path file = file_of(stage);
  if (!resumes_ || !std::filesystem::is_regular_file(file) ||
      !std::filesystem::is_regular_file(notes_of(file)))
    return false;
  std::ifstream in(std::filesystem::path(file) += ".key");
  std::string line;
  return std::getline(in, line) && line + "\n" == key_line(key, file);
}

void Checkpoints::keep(CaseStage stage, const CaseState& state, const report::StageReport& report,
                       const std::string& key) const {
  if (folder_.empty()) return;
  std::error_code told_by_the_writer;
  std::filesystem::create_directories(folder_, told_by_the_writer);
  const std::filesystem::path file = file_of(stage);
  if (stage == CaseStage::kCenterline) {
    write_polylines(file, state.centerline, state.info());
  } else {
    const BoundaryFaces faces = state.boundary_faces();
    write_mesh(file, state.view(faces));
  }
  write_text_file(notes_of(file), report::stage_notes_json(report));
  write_text_file(std::filesystem::path(file) += ".key", key_line(key, file));
}

void Checkpoints::load(CaseStage stage, CaseState& state, report::StageReport& report) const {
  const std::filesystem::path file = file_of(stage), notes = notes_of(file);
  if (stage == CaseStage::kCenterline) {
    state.centerline = read_polylines(file);
  } else if (stage == CaseStage::kLayers || state.c.makes_mixed_mesh()) {
    state.mixed = read_mesh(file);
  } else {
    const MixedMesh mesh = read_mesh(file);
    state.mesh = TetMesh::build(mesh.view());
    state.has_metric = !mesh.metric.empty();
    if (state.has_metric) metric::shape_metric(state.mesh, mesh.metric);
  }
  std::ifstream in(notes, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  naming(notes.string(), [&] { report::take_stage_notes(text, report); });
}

/// Openings of the frames before, which give those of this one their names.
std::string names_of_frames(const Case& c) {
  std::string names;
  if (c.input.selection.openings_of_frames)
    for (const Opening& opening : *c.input.selection.openings_of_frames)
      names += fmt::format("{} {} {} {} ", opening.name, opening.centre_mm.x(), opening.centre_mm.y(),
                           opening.centre_mm.z());
  return names;
}

/// The program itself counts as its version: two builds of one version may differ.
std::map<CaseStage, std::string> stage_keys(const CaseState& state) {
  using enum CaseStage;
  const Case& c = state.c;
  const auto key = [](const std::string& text) { return text_sha256(text); };
  std::map<CaseStage, std::string> keys;
  const std::string input = key(kVersion + file_sha256("/proc/self/exe") + state.input_sha256 +
                                (state.given.image ? content_of(*state.given.image) : "") +
                                section_text(c, "input") + names_of_frames(c));
  keys[kCenterline] = key(input + section_text(c, "centerline"));
  const bool lattice = c.mesher == Mesher::kLattice;
  const std::string mesher = section_of(c.mesher);
  const auto files_of = [&](const std::string& section) {
    std::string hashes;
    for (const CaseFileRead& file : files_read_by(c))
      if (file.key.starts_with("[" + section + "]")) hashes += hash_of(file.path);
    return hashes;
  };
  const bool sized_by_line = !lattice && c.delaunay_request().sizes.needs_axes();
  const bool metric_by_line = c.metric.source<metric::PointSource>().points == "centerline";
  // Speculative improvement of angles depends on chance.
  const bool by_chance = !lattice && c.adapt.adapt.execution == ExecutionKind::kSpeculative;
  keys[kMesh] =
      key(input + section_text(c, "") + section_text(c, mesher) + (sized_by_line ? keys[kCenterline] : "") +
          files_of(mesher) + (by_chance ? "speculative" : ""));
  const bool frozen = c.metric.limits_for(c.adapt.boundary.is_frozen).keeps_boundary;  // It imposes sizes.
  keys[kMetric] = key(keys[kMesh] + section_text(c, "metric") + (metric_by_line ? keys[kCenterline] : "") +
                      files_of("metric") + (frozen ? "frozen" : ""));
  keys[kAdapted] = key(keys[kMetric] + section_text(c, "adapt"));
  keys[kLayers] = key(keys[c.metric.has_source() ? kAdapted : kMesh] + section_text(c, "layers"));
  return keys;
}

}  // namespace lumesh::pipeline
