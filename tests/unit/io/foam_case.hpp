#pragma once
/// @file An OpenFOAM case read back, and what its faces say about its cells.

#include <Eigen/Geometry>
#include <map>

#include "io_fixtures.hpp"

namespace lumesh::fixtures {

/// Words of an OpenFOAM file behind its header, one by one; brackets, braces and semicolons are words.
class FoamText {
 public:
  explicit FoamText(const std::filesystem::path& path) {
    std::string text = read_file(path);
    for (std::size_t at = text.find("//"); at != std::string::npos; at = text.find("//"))
      text.erase(at, text.find('\n', at) - at);
    std::string word;
    const auto finish = [&] {
      if (!word.empty()) words_.push_back(word);
      word.clear();
    };
    for (const char c : text) {
      const bool is_mark = std::string_view("(){};").find(c) != std::string_view::npos;
      if (is_mark || std::isspace(static_cast<unsigned char>(c)) != 0) {
        finish();
        if (is_mark) words_.emplace_back(1, c);
      } else {
        word += c;
      }
    }
    finish();
    EXPECT_EQ(next(), "FoamFile") << path;
    while (next() != "}") continue;
  }
  [[nodiscard]] bool is_at_end() const { return at_ == words_.size(); }
  [[nodiscard]] const std::string& peek() const { return words_.at(at_); }
  const std::string& next() { return words_.at(at_++); }
  void skip(std::string_view expected) { EXPECT_EQ(next(), expected); }
  double real() { return std::stod(next()); }
  std::size_t integer() { return std::stoul(next()); }

  /// A list: its length and, in brackets, what read() takes for each item.
  template <class Read>
  auto list(const Read& read) {
    std::vector<decltype(read())> items(integer());
    skip("(");
    for (auto& item : items) item = read();
    skip(")");
    return items;
  }
  std::vector<std::size_t> integers() {
    return list([this] { return integer(); });
  }

 private:
  std::vector<std::string> words_;
  std::size_t at_ = 0;
};

/// A name and what is in its braces: a text or a list for each key.
struct FoamEntry {
  std::string name;
  std::map<std::string, std::string> texts;
  std::map<std::string, std::vector<std::size_t>> lists;
};

inline std::vector<FoamEntry> foam_entries(const std::filesystem::path& path) {
  FoamText text(path);
  return text.list([&] {
    FoamEntry entry;
    entry.name = text.next();
    text.skip("{");
    while (text.peek() != "}") {
      const std::string key = text.next();
      if (text.peek() == "List<label>" || text.peek() == "List<bool>") {
        text.next();
        entry.lists[key] = text.integers();
        text.skip(";");
      } else {
        while (text.peek() != ";") entry.texts[key] += text.next();
        text.skip(";");
      }
    }
    text.skip("}");
    return entry;
  });
}

struct FoamCase {
  explicit FoamCase(const std::filesystem::path& folder) {
    const std::filesystem::path mesh = folder / "constant" / "polyMesh";
    FoamText points_text(mesh / "points"), faces_text(mesh / "faces"), owner_text(mesh / "owner"),
        neighbour_text(mesh / "neighbour");
    points = points_text.list([&] {
      points_text.skip("(");
      Vec3 p;
      for (int i = 0; i < 3; ++i) p[i] = points_text.real();
      points_text.skip(")");
      return p;
    });
    faces = faces_text.list([&] { return faces_text.integers(); });
    owner = owner_text.integers();
    neighbour = neighbour_text.integers();
    for (const FoamText* text : {&points_text, &faces_text, &owner_text, &neighbour_text})
      EXPECT_TRUE(text->is_at_end());
    patches = foam_entries(mesh / "boundary");
    cell_zones = foam_entries(mesh / "cellZones");
    face_zones = foam_entries(mesh / "faceZones");
  }

  /// Area of a plane face, along its normal.
  [[nodiscard]] Vec3 area(std::size_t face) const {
    Vec3 sum = Vec3::Zero();
    const auto& f = faces.at(face);
    for (std::size_t i = 0; i < f.size(); ++i)
      sum += points.at(f[i]).cross(points.at(f[(i + 1) % f.size()])) / 2;
    return sum;
  }

  std::vector<Vec3> points;
  std::vector<std::vector<std::size_t>> faces;
  std::vector<std::size_t> owner, neighbour;
  std::vector<FoamEntry> patches, cell_zones, face_zones;
};

/// Asserts OpenFOAM's order of faces, and that the faces of every cell enclose it.
/// @return The volume of every cell, by the divergence theorem.
inline std::vector<double> sound_volumes(const FoamCase& c) {
  EXPECT_EQ(c.owner.size(), c.faces.size());
  EXPECT_LE(c.neighbour.size(), c.faces.size());
  std::size_t cells = 1 + *std::max_element(c.owner.begin(), c.owner.end());
  for (const std::size_t cell : c.neighbour) cells = std::max(cells, cell + 1);  // The last one may own none.
  for (std::size_t f = 0; f < c.neighbour.size(); ++f) {
    EXPECT_LT(c.owner[f], c.neighbour[f]) << f;
    if (f == 0) continue;
    EXPECT_LT(std::pair(c.owner[f - 1], c.neighbour[f - 1]), std::pair(c.owner[f], c.neighbour[f]))
        << "not upper-triangular at face " << f;
  }
  std::size_t next = c.neighbour.size();
  for (const FoamEntry& patch : c.patches) {
    EXPECT_EQ(std::stoul(patch.texts.at("startFace")), next) << patch.name;
    next += std::stoul(patch.texts.at("nFaces"));
  }
  EXPECT_EQ(next, c.faces.size());
  std::vector<Vec3> sums(cells, Vec3::Zero());
  std::vector<double> volumes(cells, 0);
  for (std::size_t f = 0; f < c.faces.size(); ++f) {
    const Vec3 area = c.area(f);
    const double flux = area.dot(c.points.at(c.faces[f][0])) / 3;
    sums.at(c.owner[f]) += area;
    volumes.at(c.owner[f]) += flux;
    if (f >= c.neighbour.size()) continue;
    sums.at(c.neighbour[f]) -= area;
    volumes.at(c.neighbour[f]) -= flux;
  }
  for (std::size_t i = 0; i < cells; ++i) {
    EXPECT_GT(volumes[i], 0) << "cell " << i;
    EXPECT_LT(sums[i].norm(), 1e-9 * std::pow(volumes[i], 2.0 / 3)) << "cell " << i << " is not closed";
  }
  return volumes;
}

}  // namespace lumesh::fixtures
