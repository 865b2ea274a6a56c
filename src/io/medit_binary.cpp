// Medit .meshb as libMeshb defines it: sections keyword, position of the next section, count, rows.
// Versions: 1 float; 2 double; 3 and 64-bit positions; 4 and 64-bit numbers.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <string>

#include "cell_blocks.hpp"
#include "file_fault.hpp"
#include "mesh_builder.hpp"
#include "mesh_formats.hpp"
#include "output_file.hpp"
#include "text_scanner.hpp"

namespace lumesh::io {

namespace {

constexpr std::int32_t kDimension = 3;
constexpr std::int32_t kVertices = 4;
constexpr std::int32_t kEnd = 54;

struct BinarySection {
  std::int32_t keyword;
  CellShape shape;
  std::size_t corners;
};

constexpr std::array<BinarySection, 6> kBinarySections = {{{6, CellShape::kTriangle, 3},
                                                           {7, CellShape::kQuadrilateral, 4},
                                                           {8, CellShape::kTetrahedron, 4},
                                                           {49, CellShape::kPyramid, 5},
                                                           {9, CellShape::kPrism, 6},
                                                           {10, CellShape::kHexahedron, 8}}};

std::int32_t keyword_number_of(CellShape shape) {
  for (const BinarySection& section : kBinarySections)
    if (section.shape == shape) return section.keyword;
  return 0;
}

static_assert(std::endian::native == std::endian::little, "files are written in the machine's byte order");

class BinaryWriter {
 public:
  BinaryWriter(const std::filesystem::path& path, const MeshView& mesh) : file_(path), mesh_(mesh) {
    constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
    bool fits = mesh.points.size() <= kMost;
    std::size_t bytes = 1024 + mesh.points.size() * kVertexBytes;
    const auto add = [&](const CellBlock& block) {
      fits = fits && block.size() <= kMost;
      bytes += block.size() * (block.corners + 1) * sizeof(std::int32_t);
    };
    for (const CellBlock& block : face_blocks(mesh)) add(block);
    for (const CellBlock& block : volume_blocks(mesh)) add(block);
    if (!fits) fail(path, "too many points or cells for .meshb; choose .vtu");
    version_ = bytes > kMost ? 3 : 2;
  }

  void write() {
    put(std::int32_t{1});
    put(version_);
    begin_section(kDimension, sizeof(std::int32_t));
    put(std::int32_t{3});
    begin_section(kVertices, sizeof(std::int32_t) + mesh_.points.size() * kVertexBytes);
    put(static_cast<std::int32_t>(mesh_.points.size()));
    for (const Vec3& p : mesh_.points) {
      file_.write(p.data(), 3 * sizeof(double));
      put(std::int32_t{0});
    }
    for (const CellBlock& block : face_blocks(mesh_)) write_block(block, 1);
    for (const CellBlock& block : volume_blocks(mesh_)) write_block(block, 0);
    put(kEnd);
    put_position(0);
    file_.commit();
  }

 private:
  static constexpr std::size_t kVertexBytes = 3 * sizeof(double) + sizeof(std::int32_t);

  void put(std::int32_t value) { file_.write(&value, sizeof(value)); }
  void put_position(std::size_t position) {
    if (version_ == 2) return put(static_cast<std::int32_t>(position));
    const auto wide = static_cast<std::int64_t>(position);
    file_.write(&wide, sizeof(wide));
  }
  void begin_section(std::int32_t keyword, std::size_t bytes) {
    const std::size_t header =
        sizeof(std::int32_t) + (version_ == 2 ? sizeof(std::int32_t) : sizeof(std::int64_t));
    const std::size_t next = file_.position() + header + bytes;
    put(keyword);
    put_position(next);
  }
  void write_block(const CellBlock& block, std::int32_t tag_offset) {
    if (block.size() == 0) return;
    begin_section(keyword_number_of(block.shape),
                  (1 + block.size() * (block.corners + 1)) * sizeof(std::int32_t));
    put(static_cast<std::int32_t>(block.size()));
    std::array<std::int32_t, 9> row{};
    for (std::size_t i = 0; i < block.size(); ++i) {
      const auto cell = block.cell(i);
      for (std::size_t k = 0; k < cell.size(); ++k)
        row[k] = static_cast<std::int32_t>(cell[block.shape == CellShape::kPrism ? kPrismOrder[k] : k] + 1);
      row[cell.size()] = block.tags[i] + tag_offset;
      file_.write(row.data(), (cell.size() + 1) * sizeof(std::int32_t));
    }
  }

  OutputFile file_;
  const MeshView& mesh_;
  std::int32_t version_ = 2;
};

class BinaryReader {
 public:
  explicit BinaryReader(const std::filesystem::path& path) : bytes_(read_whole_file(path)), builder_(path) {}

  MixedMesh read() {
    const auto order = number<std::int32_t>();
    swapped_ = order == 1 << 24;
    if (order != 1 && !swapped_) builder_.fail("this is no binary Medit file");
    version_ = number<std::int32_t>();
    if (version_ < 1 || version_ > 4)
      builder_.fail(fmt::format("unknown version {} of the format", version_));
    while (read_section()) {
    }
    return builder_.finish();
  }

 private:
  /// False at the end of the file.
  bool read_section() {
    const auto keyword = number<std::int32_t>();
    if (keyword == kEnd) return false;
    const std::int64_t next = version_ >= 3 ? number<std::int64_t>() : number<std::int32_t>();
    if (next < static_cast<std::int64_t>(position_) || next > static_cast<std::int64_t>(bytes_.size()))
      builder_.fail(fmt::format("section {} ends outside of the file, which is damaged or cut off", keyword));
    end_ = static_cast<std::size_t>(next);
    if (keyword == kDimension) {
      if (number<std::int32_t>() != 3) builder_.fail("only meshes of dimension 3 can be read");
    } else if (keyword == kVertices) {
      read_vertices();
    } else {
      for (const BinarySection& section : kBinarySections)
        if (section.keyword == keyword) read_cells(section);
    }
    position_ = end_;
    end_ = bytes_.size();
    return true;
  }

  void read_vertices() {
    const std::size_t count =
        read_count(3 * (version_ == 1 ? sizeof(float) : sizeof(double)) + integer_bytes());
    for (std::size_t i = 0; i < count; ++i) {
      Vec3 point;
      for (double& x : point) x = version_ == 1 ? static_cast<double>(number<float>()) : number<double>();
      integer();
      builder_.add_point(point);
    }
  }

  void read_cells(const BinarySection& section) {
    const std::size_t count = read_count((section.corners + 1) * integer_bytes());
    std::array<std::int64_t, 8> corners{};
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < section.corners; ++k) {
        corners[k] = integer();
        if (corners[k] < 1) builder_.fail("a cell has a vertex number below 1");
        --corners[k];
      }
      builder_.add_cell(section.shape, {corners.data(), section.corners}, integer());
    }
  }

  std::size_t read_count(std::size_t row_bytes) {
    const std::int64_t count = integer();
    const std::size_t most = (end_ - position_) / row_bytes;
    if (count < 0 || static_cast<std::uint64_t>(count) > most)
      builder_.fail(fmt::format("a section says it has {} rows, more than the file holds", count));
    return static_cast<std::size_t>(count);
  }

  [[nodiscard]] std::size_t integer_bytes() const {
    return version_ == 4 ? sizeof(std::int64_t) : sizeof(std::int32_t);
  }
  std::int64_t integer() { return version_ == 4 ? number<std::int64_t>() : number<std::int32_t>(); }

  template <class T>
  T number() {
    if (position_ > end_ || end_ - position_ < sizeof(T)) builder_.fail("a section or the file is cut off");
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data() + position_, sizeof(T));
    if (swapped_) std::reverse(raw.begin(), raw.end());
    position_ += sizeof(T);
    return std::bit_cast<T>(raw);
  }

  std::string bytes_;
  MeshBuilder builder_;
  std::size_t position_ = 0;
  std::size_t end_ = bytes_.size();  ///< Of the section being read.
  bool swapped_ = false;
  std::int32_t version_ = 0;
};

}  // namespace

void write_medit_binary(const std::filesystem::path& path, const MeshView& mesh) {
  BinaryWriter(path, mesh).write();
}

MixedMesh read_medit_binary(const std::filesystem::path& path) {
  return BinaryReader(path).read();
}

}  // namespace lumesh::io
