// Wavefront OBJ: vertices, polygons and the groups that they belong to.
#include <fmt/format.h>

#include <charconv>
#include <map>
#include <sstream>

#include "file_fault.hpp"
#include "lumesh/core/trimmed.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "mesh_formats.hpp"
#include "part_names.hpp"
#include "unpacked_file.hpp"

namespace lumesh::io {

namespace {

class ObjReader {
 public:
  explicit ObjReader(const std::filesystem::path& path) : path_(path), in_(unpacked_file(path)) {}

  MixedMesh read() {
    for (std::string line; next_line(line);) {
      std::istringstream words(line);
      std::string word;
      if (!(words >> word)) continue;
      if (word == "v") read_point(words);
      if (word == "f") read_polygon(words);
      if (word == "g" || word == "o") begin_group(line.substr(line.find(word) + 1));
    }
    if (mesh_.triangles.empty()) fail_here("holds no polygon");
    for (const Cell<3>& triangle : mesh_.triangles)
      for (const std::uint32_t v : triangle)
        if (v >= mesh_.points.size()) fail_here("a polygon refers to a vertex that is not there");
    number_patches();
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail_here(std::string_view what) const { fail_at_line(path_, line_number_, what); }

  /// Reads a line, joined with its continuations; a line that goes on ends in a backslash.
  bool next_line(std::string& line) {
    line.clear();
    for (std::string part; std::getline(in_, part);) {
      ++line_number_;
      line += trimmed(part, kSpaces);
      if (!line.ends_with('\\') || line.starts_with('#')) return true;
      line.back() = ' ';
    }
    return !line.empty();
  }

  void read_point(std::istringstream& words) {
    Vec3 p;
    if (!(words >> p.x() >> p.y() >> p.z()) || !p.allFinite()) fail_here("a vertex is damaged");
    mesh_.points.push_back(p);
  }

  /// Vertices count from 1, negative ones from the last one back; texture and normal follow behind a slash.
  std::uint32_t vertex(const std::string& word) const {
    long number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    const bool is_whole = end == word.data() + word.size() || *end == '/';
    if (number < 0) number += static_cast<long>(mesh_.points.size()) + 1;
    if (error != std::errc() || !is_whole || number < 1 || number > 0xffffffffL)
      fail_here("a polygon is damaged");
    return static_cast<std::uint32_t>(number - 1);
  }

  /// As a fan of triangles.
  void read_polygon(std::istringstream& words) {
    if (mesh_.info.patches.empty()) begin_group("");
    std::vector<std::uint32_t> corners;
    for (std::string word; words >> word && word[0] != '#';) corners.push_back(vertex(word));
    if (corners.size() < 3) fail_here(kFewCorners);
    for (std::size_t i = 2; i < corners.size(); ++i) {
      mesh_.triangles.push_back({corners[0], corners[i - 1], corners[i]});
      mesh_.triangle_patches.push_back(group_);
    }
  }

  /// What follows belongs to it; groups of one name, as it stands in the file, are one.
  void begin_group(const std::string& text) {
    std::string name(trimmed(text, kSpaces));
    if (name.empty()) name = kWallName;
    const auto [at, is_new] =
        numbers_.try_emplace(name, static_cast<std::int32_t>(mesh_.info.patches.size()));
    if (is_new) mesh_.info.patches.push_back({name, PatchKind::kWall, {}});
    group_ = at->second;
  }

  /// Without groups that have no polygon; one alone is the wall.
  void number_patches() {
    std::vector<std::int32_t> number(mesh_.info.patches.size(), -1);
    std::vector<Patch> used;
    for (std::int32_t& patch : mesh_.triangle_patches) {
      std::int32_t& mine = number[static_cast<std::size_t>(patch)];
      if (mine < 0) {
        mine = static_cast<std::int32_t>(used.size());
        used.push_back(mesh_.info.patches[static_cast<std::size_t>(patch)]);
      }
      patch = mine;
    }
    mesh_.info.patches = std::move(used);
    if (mesh_.info.patches.size() == 1) mesh_.info.patches[0] = {kWallName, PatchKind::kWall, {}};
  }

  const std::filesystem::path& path_;
  std::istringstream in_;
  std::size_t line_number_ = 0;
  MixedMesh mesh_;
  std::map<std::string, std::int32_t> numbers_;
  std::int32_t group_ = 0;
};

}  // namespace

MixedMesh read_obj(const std::filesystem::path& path) {
  return ObjReader(path).read();
}

}  // namespace lumesh::io
