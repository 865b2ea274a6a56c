// Files of other programs, byte by byte from the formats' documentation: Medit's .meshb of every version and
// byte order, legacy VTK of both kinds, VTU with its data inside and appended.
#include <gtest/gtest.h>

#include <bit>

#include "io_fixtures.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh {
namespace {

using fixtures::write_file;

enum class ByteOrder { kLittle, kBig };

/// Numbers behind each other.
class Bytes {
 public:
  explicit Bytes(ByteOrder order) : order_(order) {}
  template <class Value>
  requires std::is_arithmetic_v<Value> Bytes& put(Value value) {
    std::array<char, sizeof(Value)> raw;
    std::memcpy(raw.data(), &value, sizeof(Value));
    if ((std::endian::native == std::endian::little) != (order_ == ByteOrder::kLittle))
      std::reverse(raw.begin(), raw.end());
    text_.append(raw.data(), raw.size());
    return *this;
  }
  Bytes& put(std::string_view text) {
    text_ += text;
    return *this;
  }
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] std::size_t size() const { return text_.size(); }

 private:
  ByteOrder order_;
  std::string text_;
};

struct MeshbKind {
  int version;
  ByteOrder order;
};

void PrintTo(const MeshbKind& kind, std::ostream* out) {
  *out << "version " << kind.version << (kind.order == ByteOrder::kBig ? ", high byte first" : "");
}

/// A tetrahedron with reference 5, one of its faces with reference 8, and a section (Ridges) that is skipped.
/// By version: 1 has floats, 3 has positions of 64 bits, 4 has all other numbers of 64 bits too, except
/// keywords and the dimension.
class MeshbWriter {
 public:
  explicit MeshbWriter(const MeshbKind& kind) : kind_(kind), out_(kind.order) {
    out_.put(std::int32_t{1}).put(std::int32_t{kind.version});
  }

  std::string write() {
    const std::size_t integer = kind_.version == 4 ? 8 : 4;
    const std::size_t real = kind_.version == 1 ? 4 : 8;
    begin(3, 4);
    out_.put(std::int32_t{3});
    begin(4, integer + 4 * (3 * real + integer));
    put_integers({4});
    for (int corner = 0; corner < 4; ++corner) {
      for (int axis = 1; axis <= 3; ++axis) put_real(corner == axis ? 0.5 * axis : 0.0);
      put_integers({0});
    }
    begin(14, 2 * integer);
    put_integers({1, 1});
    begin(8, 6 * integer);
    put_integers({1, 1, 2, 3, 4, 5});
    begin(6, 5 * integer);
    put_integers({1, 1, 3, 2, 8});
    out_.put(std::int32_t{54});
    put_position(0);
    return out_.text();
  }

 private:
  void put_position(std::size_t position) {
    if (kind_.version >= 3)
      out_.put(static_cast<std::int64_t>(position));
    else
      out_.put(static_cast<std::int32_t>(position));
  }
  void begin(std::int32_t keyword, std::size_t bytes) {
    out_.put(keyword);
    put_position(out_.size() + (kind_.version >= 3 ? 8 : 4) + bytes);
  }
  void put_integers(std::initializer_list<int> values) {
    for (const int value : values) {
      if (kind_.version == 4)
        out_.put(std::int64_t{value});
      else
        out_.put(std::int32_t{value});
    }
  }
  void put_real(double value) {
    if (kind_.version == 1)
      out_.put(static_cast<float>(value));
    else
      out_.put(value);
  }

  MeshbKind kind_;
  Bytes out_;
};

class MeditBinary : public testing::TestWithParam<MeshbKind> {
 protected:
  fixtures::TemporaryFolder folder_;
};

TEST_P(MeditBinary, IsRead) {
  const MixedMesh mesh = read_mesh(write_file(folder_ / "a.meshb", MeshbWriter(GetParam()).write()));
  EXPECT_EQ(mesh.points, (std::vector<Vec3>{{0, 0, 0}, {0.5, 0, 0}, {0, 1, 0}, {0, 0, 1.5}}));
  EXPECT_EQ(mesh.tetrahedra, (std::vector<Cell<4>>{{0, 1, 2, 3}}));
  EXPECT_EQ(mesh.tetrahedron_labels, std::vector<Label>{5});
  EXPECT_EQ(mesh.triangles, (std::vector<Cell<3>>{{0, 2, 1}}));
  ASSERT_EQ(mesh.info.patches.size(), 1U);
  EXPECT_EQ(mesh.info.patches[0].name, "patch_8");
}

TEST_P(MeditBinary, CutOffAnywhereIsRefused) {
  const std::string whole = MeshbWriter(GetParam()).write();
  // The last position is not needed: it says that nothing follows.
  const std::size_t needed = whole.size() - (GetParam().version >= 3 ? 8 : 4);
  for (std::size_t size = 0; size < needed; ++size) {
    SCOPED_TRACE(size);
    write_file(folder_ / "a.meshb", whole.substr(0, size));
    fixtures::error_of([&] { (void)read_mesh(folder_ / "a.meshb"); });
  }
}

INSTANTIATE_TEST_SUITE_P(Versions, MeditBinary,
                         testing::Values(MeshbKind{1, ByteOrder::kLittle}, MeshbKind{2, ByteOrder::kLittle},
                                         MeshbKind{3, ByteOrder::kLittle}, MeshbKind{4, ByteOrder::kLittle},
                                         MeshbKind{1, ByteOrder::kBig}, MeshbKind{2, ByteOrder::kBig},
                                         MeshbKind{3, ByteOrder::kBig}, MeshbKind{4, ByteOrder::kBig}));

class ForeignVtk : public testing::Test {
 protected:
  MixedMesh read(const std::string& name, const std::string& content) {
    return read_mesh(write_file(folder_ / name, content));
  }
  static void expect_tetrahedron_and_wedge(const MixedMesh& mesh) {
    ASSERT_EQ(mesh.points.size(), 7U);
    EXPECT_EQ(mesh.points[5], Vec3(0, 1, 1));
    EXPECT_EQ(mesh.points[6], Vec3(0.25, 0.25, -0.5));
    EXPECT_EQ(mesh.tetrahedra, (std::vector<Cell<4>>{{0, 2, 1, 6}}));
    EXPECT_EQ(mesh.prisms, (std::vector<Cell<6>>{{0, 2, 1, 3, 5, 4}}));
    EXPECT_EQ(mesh.tetrahedron_labels, std::vector<Label>{4});
    EXPECT_EQ(mesh.prism_labels, std::vector<Label>{2});
    EXPECT_EQ(count_inverted_cells(mesh.view()), 0U);
  }
  fixtures::TemporaryFolder folder_;
};

const std::vector<float> kCoordinates = {0, 0, 0, 1, 0, 0, 0, 1,    0,    0,   0,
                                         1, 1, 0, 1, 0, 1, 1, 0.25, 0.25, -0.5};

// As the format's description, https://vtk.org/wp-content/uploads/2015/04/file-formats.pdf, has it.
TEST_F(ForeignVtk, LegacyFileOfVersion2InText) {
  expect_tetrahedron_and_wedge(
      read("a.vtk",
           "# vtk DataFile Version 2.0\nby hand\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 7 float\n0 0 0  1 "
           "0 0  0 1 0\n0 0 1  1 0 1  0 1 1\n"
           ".25 .25 -5.0e-1\nCELLS 3 16\n4 0 2 1 6\n6 0 2 1 3 5 4\n3 0 1 2\nCELL_TYPES "
           "3\n10\n13\n5\nPOINT_DATA 7\nSCALARS t float\n"
           "LOOKUP_TABLE default\n0 1 2 3 4 5 6\nVECTORS u float\n0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 "
           "0\nCELL_DATA 3\n"
           "NORMALS n float\n0 0 1 0 0 1 0 0 1\nSCALARS Material int 1\nLOOKUP_TABLE default\n4 2 9\n"));
}

TEST_F(ForeignVtk, LegacyFileOfVersion3InBinary) {
  Bytes out(ByteOrder::kBig);
  out.put("# vtk DataFile Version 3.0\nvtk output\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 7 float\n");
  for (const float x : kCoordinates) out.put(x);
  out.put("\nCELLS 2 12\n");
  for (const std::int32_t word : {4, 0, 2, 1, 6, 6, 0, 2, 1, 3, 5, 4}) out.put(word);
  out.put("\nCELL_TYPES 2\n").put(std::int32_t{10}).put(std::int32_t{13});
  out.put("\nCELL_DATA 2\nFIELD FieldData 2\nid 1 2 vtkIdType\n").put(std::int32_t{0}).put(std::int32_t{1});
  out.put("\nlabels 1 2 unsigned_char\n").put(std::uint8_t{4}).put(std::uint8_t{2}).put("\n");
  expect_tetrahedron_and_wedge(read("a.vtk", out.text()));
}

// As VTK 9 writes it: offsets of 64 bits and notes on the arrays.
TEST_F(ForeignVtk, LegacyFileOfVersion51InBinary) {
  Bytes out(ByteOrder::kBig);
  out.put("# vtk DataFile Version 5.1\nvtk output\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 7 double\n");
  for (const float x : kCoordinates) out.put(static_cast<double>(x));
  out.put(
      "\nMETADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 1.5\n\nCELLS 3 "
      "10\nOFFSETS vtktypeint64\n");
  for (const std::int64_t offset : {0, 4, 10}) out.put(offset);
  out.put("\nCONNECTIVITY vtktypeint64\n");
  for (const std::int64_t corner : {0, 2, 1, 6, 0, 2, 1, 3, 5, 4}) out.put(corner);
  out.put("\nCELL_TYPES 2\n").put(std::int32_t{10}).put(std::int32_t{13});
  out.put("\nCELL_DATA 2\nFIELD FieldData 2\nvolume 1 2 double\n").put(0.1).put(0.5);
  out.put("\nMETADATA\nINFORMATION 0\n\nlabel 1 2 long\n").put(std::int64_t{4}).put(std::int64_t{2});
  out.put("\nMETADATA\nINFORMATION 0\n\n");
  expect_tetrahedron_and_wedge(read("a.vtk", out.text()));
}

TEST_F(ForeignVtk, LegacyFileThatIsDamaged) {
  const std::string start =
      "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 "
      "0 1\n";
  const auto expect_refused = [&](const std::string& content, const std::string& word) {
    const std::string text = fixtures::error_of([&] { (void)read("a.vtk", content); });
    EXPECT_NE(text.find(word), std::string::npos) << text;
  };
  expect_refused(start + "CELLS 1 5\n4 0 1 2 4\nCELL_TYPES 1\n10\n", "point that is not there");
  expect_refused(start + "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n24\n", "type 24");
  expect_refused(start + "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 2\n10\n10\n", "as many cell types");
  expect_refused(start + "CELLS 1 5\n4 0 1 2 inf\nCELL_TYPES 1\n10\n", "");
  expect_refused(start + "CELLS 1 5\ninf 0 1 2 3\nCELL_TYPES 1\n10\n", "whole number");
  expect_refused(start + "CELLS 1 5\n9 0 1 2 3\nCELL_TYPES 1\n10\n", "damaged");
  expect_refused("# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\n", "no polygon");
  expect_refused("# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_GRID\n", "nor PolyData");
}

/// Base64 of a text, by the table of RFC 4648.
std::string base64(const std::string& bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bits, out;
  for (const char c : bytes)
    for (int bit = 7; bit >= 0; --bit) bits += (static_cast<unsigned char>(c) >> bit & 1) != 0 ? '1' : '0';
  while (bits.size() % 6 != 0) bits += '0';
  for (std::size_t i = 0; i < bits.size(); i += 6) out += kDigits[std::stoul(bits.substr(i, 6), nullptr, 2)];
  while (out.size() % 4 != 0) out += '=';
  return out;
}

/// An array's bytes behind their number, 32 bits wide.
template <class Value>
std::string counted(const std::vector<Value>& values) {
  Bytes out(ByteOrder::kLittle);
  out.put(static_cast<std::uint32_t>(values.size() * sizeof(Value)));
  for (const Value value : values) out.put(value);
  return out.text();
}

/// The XML around the arrays points, connectivity, offsets, types and label.
std::string vtu(const std::array<std::string, 5>& attributes, const std::array<std::string, 5>& texts,
                const std::string& end) {
  const auto array = [&](std::size_t i, const std::string& description) {
    return "<DataArray " + description + " " + attributes.at(i) + ">" + texts.at(i) + "</DataArray>\n";
  };
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" "
         "byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n"
         "<Piece NumberOfPoints=\"7\" NumberOfCells=\"2\">\n<PointData/>\n<CellData>\n" +
         array(4, "type=\"Int16\" Name=\"cell_tags\"") + "</CellData>\n<Points>\n" +
         array(0, "type=\"Float32\" NumberOfComponents=\"3\"") + "</Points>\n<Cells>\n" +
         array(1, "type=\"Int64\" Name=\"connectivity\"") + array(2, "type=\"Int32\" Name=\"offsets\"") +
         array(3, "type=\"UInt8\" Name=\"types\"") + "</Cells>\n</Piece>\n</UnstructuredGrid>\n" + end +
         "</VTKFile>\n";
}

std::array<std::string, 5> counted_arrays() {
  return {counted(kCoordinates), counted(std::vector<std::int64_t>{0, 2, 1, 6, 0, 2, 1, 3, 5, 4}),
          counted(std::vector<std::int32_t>{4, 10}), counted(std::vector<std::uint8_t>{10, 13}),
          counted(std::vector<std::int16_t>{4, 2})};
}

TEST_F(ForeignVtk, VtuWithoutCompression) {
  std::array<std::string, 5> attributes, texts;
  for (std::size_t i = 0; i < 5; ++i) {
    attributes.at(i) = "format=\"binary\"";
    texts.at(i) = "\n   " + base64(counted_arrays().at(i)) + "\n";
  }
  expect_tetrahedron_and_wedge(read("a.vtu", vtu(attributes, texts, "")));
}

TEST_F(ForeignVtk, VtuWithAppendedData) {
  for (const char* encoding : {"raw", "base64"}) {
    SCOPED_TRACE(encoding);
    std::array<std::string, 5> attributes;
    std::string appended;
    for (std::size_t i = 0; i < 5; ++i) {
      attributes.at(i) = "format=\"appended\" offset=\"" + std::to_string(appended.size()) + "\"";
      appended +=
          std::string_view(encoding) == "raw" ? counted_arrays().at(i) : base64(counted_arrays().at(i));
    }
    const std::string end =
        std::string("<AppendedData encoding=\"") + encoding + "\">\n_" + appended + "\n</AppendedData>\n";
    expect_tetrahedron_and_wedge(read("a.vtu", vtu(attributes, {}, end)));
  }
}

}  // namespace
}  // namespace lumesh
