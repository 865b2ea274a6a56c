// STL: binary out; binary and text in, also gzipped, equal points merged.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cstring>
#include <map>
#include <sstream>

#include "file_fault.hpp"
#include "lumesh/core/trimmed.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "mesh_formats.hpp"
#include "output_file.hpp"
#include "part_names.hpp"
#include "unit_and_frame.hpp"
#include "unpacked_file.hpp"

namespace lumesh::io {

namespace {

constexpr std::size_t kHeaderBytes = 80;
constexpr std::size_t kFacetBytes = 50;

[[noreturn]] void fail_damaged(const std::filesystem::path& path, std::string_view what) {
  fail(path, fmt::format("{}; write the file again", what));
}

void write_facet(OutputFile& file, const MeshView& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const std::array<Vec3, 3> p = {mesh.points[a], mesh.points[b], mesh.points[c]};
  const Vec3 n = (p[1] - p[0]).cross(p[2] - p[0]).stableNormalized();
  std::array<float, 12> numbers{};
  for (int i = 0; i < 3; ++i) {
    numbers[static_cast<std::size_t>(i)] = static_cast<float>(n[i]);
    for (std::size_t k = 0; k < 3; ++k)
      numbers[3 * (k + 1) + static_cast<std::size_t>(i)] = static_cast<float>(p[k][i]);
  }
  std::array<char, kFacetBytes> bytes{};
  std::memcpy(bytes.data(), numbers.data(), sizeof(numbers));
  file.write(bytes.data(), bytes.size());
}

/// Gathers facets; points with the same coordinates become one.
class SurfaceBuilder {
 public:
  /// @param comment  The file's header or first line.
  SurfaceBuilder(const std::filesystem::path& path, std::string_view comment) : path_(path) {
    read_unit_and_frame(comment, mesh_.info);
  }

  void add(const std::array<Vec3, 3>& corners) {
    if (solids_.empty()) begin_solid("");  // Of a damaged file.
    Cell<3> triangle;
    for (std::size_t i = 0; i < 3; ++i) triangle[i] = number(corners[i]);
    mesh_.triangles.push_back(triangle);
    mesh_.triangle_patches.push_back(static_cast<std::int32_t>(solids_.size()) - 1);
  }
  /// What follows belongs to it; solids of one name, as it stands in the file, are one.
  void begin_solid(const std::string& name) {
    solids_.push_back(name.empty() ? "solid_" + std::to_string(solids_.size() + 1) : name);
  }
  /// One patch "wall", or one for each name of solids that have triangles where there are several.
  MixedMesh finish() {
    if (mesh_.triangles.empty()) fail_damaged(path_, "holds no triangle");
    std::vector<Patch>& patches = mesh_.info.patches;
    std::map<std::string, std::int32_t> numbers;
    for (std::int32_t& patch : mesh_.triangle_patches) {
      const std::string& name = solids_[static_cast<std::size_t>(patch)];
      const auto [at, is_new] = numbers.try_emplace(name, static_cast<std::int32_t>(patches.size()));
      if (is_new) patches.push_back({name, PatchKind::kWall, {}});
      patch = at->second;
    }
    if (patches.size() == 1) patches[0].name = kWallName;
    return std::move(mesh_);
  }

 private:
  std::uint32_t number(const Vec3& p) {
    if (!p.allFinite()) fail_damaged(path_, "a corner is not finite");
    const auto [at, added] =
        numbers_.try_emplace({p.x(), p.y(), p.z()}, static_cast<std::uint32_t>(mesh_.points.size()));
    if (added) mesh_.points.push_back(p);
    return at->second;
  }

  const std::filesystem::path& path_;
  MixedMesh mesh_;
  std::vector<std::string> solids_;
  std::map<std::array<double, 3>, std::uint32_t> numbers_;
};

/// Number of facets in the head of a binary file.
std::size_t facets_said(const std::string& bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeaderBytes, sizeof(count));
  return count;
}

MixedMesh parse_binary(const std::filesystem::path& path, const std::string& bytes, std::size_t facets) {
  SurfaceBuilder surface(path, std::string_view(bytes).substr(0, kHeaderBytes));
  surface.begin_solid("");
  for (std::size_t f = 0; f < facets; ++f) {
    std::array<float, 9> numbers;
    std::memcpy(numbers.data(), bytes.data() + kHeaderBytes + 4 + f * kFacetBytes + 12, sizeof(numbers));
    std::array<Vec3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners[k] = Vec3(numbers[3 * k], numbers[3 * k + 1], numbers[3 * k + 2]);
    surface.add(corners);
  }
  return surface.finish();
}

MixedMesh parse_text(const std::filesystem::path& path, const std::string& text) {
  SurfaceBuilder surface(path, std::string_view(text).substr(0, text.find('\n')));
  std::istringstream in(text);
  std::array<Vec3, 3> corners;
  std::size_t corner = 3;
  bool is_complete = false;
  for (std::string word; in >> word;) {
    word = lower_case(std::move(word));
    if (word == "solid" || word == "endsolid") {
      std::string rest;  // It may hold any words.
      std::getline(in, rest);
      const std::string name(trimmed(rest, kSpaces));
      if (word == "solid") surface.begin_solid(name.empty() ? kWallName : name);
    }
    is_complete = word == "endsolid" || (is_complete && word != "facet");
    if ((word == "outer" || word == "endsolid") && corner != 3) fail_damaged(path, "a facet is damaged");
    if (word == "outer") corner = 0;
    if (word != "vertex") continue;
    Vec3 p;
    if (!(in >> p.x() >> p.y() >> p.z()) || corner == 3) fail_damaged(path, "a facet is damaged");
    corners[corner++] = p;
    if (corner == 3) surface.add(corners);
  }
  if (!is_complete) fail_damaged(path, "\"endsolid\" is missing, the file is cut off");
  return surface.finish();
}

}  // namespace

void write_stl(const std::filesystem::path& path, const MeshView& mesh) {
  const std::size_t facets = mesh.triangles.size() + 2 * mesh.quadrilaterals.size();
  if (facets == 0) fail(path, kNoFaces);
  OutputFile file(path);
  std::array<char, kHeaderBytes> header{};
  std::strncpy(header.data(), unit_and_frame(*mesh.info).c_str(), header.size() - 1);
  file.write(header.data(), header.size());
  const auto count = static_cast<std::uint32_t>(facets);
  file.write(&count, sizeof(count));
  for (const Cell<3>& t : mesh.triangles) write_facet(file, mesh, t[0], t[1], t[2]);
  for (const Cell<4>& q : mesh.quadrilaterals) {
    write_facet(file, mesh, q[0], q[1], q[2]);
    write_facet(file, mesh, q[0], q[2], q[3]);
  }
  file.commit();
}

MixedMesh read_stl(const std::filesystem::path& path) {
  const std::string bytes = unpacked_file(path);
  if (bytes.size() >= kHeaderBytes + 4 && kHeaderBytes + 4 + facets_said(bytes) * kFacetBytes == bytes.size())
    return parse_binary(path, bytes, facets_said(bytes));
  // Headers of binary files begin with "solid", too, but no text holds zeros, except behind its end.
  const std::size_t end = bytes.find_last_not_of('\0');
  const bool is_binary = bytes.find('\0') < end;
  if (!is_binary && (bytes.starts_with("solid") || bytes.starts_with("SOLID")))
    return parse_text(path, bytes);
  if (!is_binary || bytes.size() < kHeaderBytes + 4) fail_damaged(path, "not a complete STL file");
  constexpr std::size_t kPlausible = 1000;  // Times as many as there are: else it is no count.
  const std::size_t facets = facets_said(bytes), there = (bytes.size() - kHeaderBytes - 4) / kFacetBytes;
  if (facets > kPlausible * (there + 1)) fail_damaged(path, "not a complete STL file");
  if (facets > there)
    fail_damaged(path, fmt::format("holds {} of {} facets, the file is cut off", there, facets));
  return parse_binary(path, bytes, facets);  // What follows is padding.
}

}  // namespace lumesh::io
