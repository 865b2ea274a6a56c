// Damaged files of every format are read or refused with an Error of one line: no crash, no other exception,
// no hang, no absurd allocation. The mutations are the same in every run; LUMESH_SEED=n tries others,
// LUMESH_FUZZ_CASES=n as many per file. After a crash the file that caused it lies in the folder
// lumesh-io-* of the temporary files, after a failure it is copied to lumesh_fuzz_*.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <zlib.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <random>

#include "lumesh/io/image_file.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/io/point_data_file.hpp"
#include "lumesh/io/points_file.hpp"
#include "lumesh/io/polylines_file.hpp"
#include "unit/io/image_bytes.hpp"
#include "unit/io/io_fixtures.hpp"

namespace lumesh {
namespace {

using fixtures::TemporaryFolder;

unsigned environment_number(const char* name, unsigned otherwise) {
  const char* const text = std::getenv(name);
  return text == nullptr ? otherwise : static_cast<unsigned>(std::strtoul(text, nullptr, 10));
}

class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  std::string operator()(std::string bytes) {
    const unsigned rounds = 1 + below(4);
    for (unsigned i = 0; i < rounds && !bytes.empty(); ++i) mutate(bytes);
    return bytes;
  }

 private:
  unsigned below(std::size_t limit) {
    return static_cast<unsigned>(std::uniform_int_distribution<std::size_t>(0, limit - 1)(random_));
  }
  /// Headers matter most: half of all places lie in the first 400 bytes.
  std::size_t place(const std::string& bytes) {
    return below(below(2) == 0 ? std::min<std::size_t>(400, bytes.size()) : bytes.size());
  }
  void mutate(std::string& bytes) {
    const std::size_t at = place(bytes);
    switch (below(7)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 1:
        bytes[at] = static_cast<char>(below(256));
        break;
      case 2:
        bytes.resize(at);
        break;
      case 3:
        bytes.erase(at, 1 + below(8));
        break;
      case 4:
        bytes.insert(at, bytes.substr(place(bytes), 1 + below(16)));
        break;
      case 5:
        change_number(bytes, at);
        break;
      default:
        change_word(bytes, at);
    }
  }
  /// A number in text becomes one that readers may trip over.
  void change_number(std::string& bytes, std::size_t at) {
    const char* const kNumbers[] = {
        "-1", "0", "4294967295", "2147483648", "99999999999999999999", "nan", "1e999", "-7", ""};
    const std::size_t begin = bytes.find_first_of("0123456789", at);
    if (begin == std::string::npos) return;
    const std::size_t end = std::min(bytes.find_first_not_of("0123456789", begin), bytes.size());
    bytes.replace(begin, end - begin, kNumbers[below(std::size(kNumbers))]);
  }
  /// Four bytes of a binary file become a large or negative number.
  void change_word(std::string& bytes, std::size_t at) {
    const std::uint32_t kWords[] = {0, 0xffffffffU, 0x7fffffffU, 0x80000000U, 0x00ffffffU, 54, 0x7ff80000U};
    const std::uint32_t word = kWords[below(std::size(kWords))];
    for (std::size_t i = 0; i < 4 && at + i < bytes.size(); ++i)
      bytes[at + i] = static_cast<char>(word >> (8 * i));
  }

  std::mt19937 random_;
};

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  // They need address space of their own.
#else
constexpr bool kSanitized = false;
#endif

/// What asks for more address space than this gets std::bad_alloc, which is no Error.
class MemoryLimit {
 public:
  MemoryLimit() {
    constexpr rlim_t kBytes = rlim_t{3} << 30;
    getrlimit(RLIMIT_AS, &before_);
    rlimit limit = before_;
    limit.rlim_cur = std::min(before_.rlim_max, kBytes);
    if (!kSanitized) setrlimit(RLIMIT_AS, &limit);
  }
  ~MemoryLimit() { setrlimit(RLIMIT_AS, &before_); }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  rlimit before_ = {};
};

void expect_consistent(const std::vector<SymTensor>& metric) {
  for (const SymTensor& t : metric)
    ASSERT_TRUE(std::isfinite(t.trace() + t.xy + t.xz + t.yz) && t.xx > 0 && t.yy > 0 && t.zz > 0);
}

/// What a reader promises about a mesh that it accepts.
void expect_consistent(const MixedMesh& mesh) {
  const auto check = [&](const auto& cells, const auto& tags) {
    ASSERT_EQ(cells.size(), tags.size());
    for (const auto& cell : cells)
      for (const std::uint32_t v : cell) ASSERT_LT(v, mesh.points.size());
  };
  check(mesh.tetrahedra, mesh.tetrahedron_labels);
  check(mesh.pyramids, mesh.pyramid_labels);
  check(mesh.prisms, mesh.prism_labels);
  check(mesh.hexahedra, mesh.hexahedron_labels);
  check(mesh.triangles, mesh.triangle_patches);
  check(mesh.quadrilaterals, mesh.quadrilateral_patches);
  for (const auto* patches : {&mesh.triangle_patches, &mesh.quadrilateral_patches})
    for (const std::int32_t p : *patches)
      ASSERT_TRUE(p >= 0 && static_cast<std::size_t>(p) < mesh.info.patches.size());
  for (const Vec3& p : mesh.points) ASSERT_TRUE(p.allFinite());
  ASSERT_TRUE(mesh.metric.empty() || mesh.metric.size() == mesh.points.size());
  expect_consistent(mesh.metric);
}

void expect_consistent(const LabelImage& image) {
  ASSERT_EQ(image.voxels().size(), image.frame().voxel_count());
  ASSERT_EQ(image.values().at(0), kBackground);
  for (const LabelImage::Index i : image.voxels()) ASSERT_LT(i, image.values().size());
  ASSERT_TRUE((image.frame().spacing_mm.array() > 0).all());
  ASSERT_TRUE(
      (image.frame().direction.transpose() * image.frame().direction).isApprox(Mat3::Identity(), 1e-9));
}

void expect_consistent(const NumberImage& image) {
  ASSERT_EQ(image.values.size(), image.frame.voxel_count());
  ASSERT_TRUE((image.frame.spacing_mm.array() > 0).all());
}

void expect_consistent(const std::vector<double>& solution) {
  EXPECT_EQ(solution.size(), 4u);
}

void expect_consistent(const PointData& data) {
  EXPECT_FALSE(data.points.empty());
  for (const Vec3& p : data.points) EXPECT_TRUE(p.allFinite());
  for (const auto& array : data.scalars) EXPECT_EQ(array.second.size(), data.points.size());
  for (const auto& array : data.vectors) EXPECT_EQ(array.second.size(), data.points.size());
}

void expect_consistent(const Polylines& lines) {
  for (const auto& line : lines.lines)
    for (const std::uint32_t v : line) ASSERT_LT(v, lines.points.size());
  for (const auto& [name, values] : lines.scalars) ASSERT_EQ(values.size(), lines.points.size());
  for (const auto& [name, values] : lines.vectors) ASSERT_EQ(values.size(), lines.points.size());
}

class IoFuzz : public testing::Test {
 protected:
  /// Reads damaged copies of a good file.
  template <class Read>
  void fuzz(const std::string& name, const std::string& good, const Read& read) {
    const unsigned seed = environment_number("LUMESH_SEED", 20);
    const unsigned cases = environment_number("LUMESH_FUZZ_CASES", 400);
    std::cout << name << ": LUMESH_SEED=" << seed << ", " << cases << " cases\n";
    expect_consistent(read(fixtures::write_file(folder_ / name, good)));
    const MemoryLimit limit;
    Mutator mutate(seed);
    unsigned refused = 0;
    for (unsigned i = 0; i < cases && !HasFailure(); ++i) {
      SCOPED_TRACE(testing::Message() << name << ", case " << i);
      const auto path = fixtures::write_file(folder_ / name, mutate(good));
      const auto start = std::chrono::steady_clock::now();
      refused += read_one(path, read) ? 0 : 1;
      EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(kSanitized ? 60 : 5));
      if (HasFailure())
        std::filesystem::copy_file(path, std::filesystem::temp_directory_path() / ("lumesh_fuzz_" + name),
                                   std::filesystem::copy_options::overwrite_existing);
    }
    EXPECT_GE(refused, cases / 20) << "the mutations are too mild to test anything";
  }
  /// False if the file was refused.
  template <class Read>
  static bool read_one(const std::filesystem::path& path, const Read& read) {
    try {
      expect_consistent(read(path));
      return true;
    } catch (const Error& error) {
      const std::string_view message = error.what();
      EXPECT_FALSE(message.empty());
      EXPECT_EQ(message.find_first_of("\n\r"), std::string_view::npos) << message;
      EXPECT_TRUE(error.kind() == ErrorKind::kBadInput || error.kind() == ErrorKind::kMemory) << message;
    } catch (const std::exception& error) {
      ADD_FAILURE() << "not an Error: " << error.what();
    }
    return false;
  }
  void fuzz_mesh(const std::string& name, const MeshWriteOptions& options = {}) {
    const auto path = folder_ / ("good_" + name);
    MixedMesh mesh = fixtures::every_cell_shape();
    mesh.metric = fixtures::different_tensors(mesh.points.size());
    write_mesh(path, mesh.view(), options);
    fuzz(name, fixtures::read_file(path), [](const auto& file) { return read_mesh(file); });
  }
  void fuzz_metric(const std::string& name) {
    constexpr std::size_t kVertices = 12;
    const auto path = folder_ / ("good_" + name);
    write_metric(path, fixtures::different_tensors(kVertices));
    fuzz(name, fixtures::read_file(path), [](const auto& file) { return read_metric(file, kVertices); });
  }
  void fuzz_image(const std::string& name, const std::string& good) {
    fuzz(name, good, [](const auto& file) {
      Context context;
      return read_image(file, {}, context);
    });
  }
  /// As gzip packs it.
  static std::string packed(const std::string& bytes) {
    const TemporaryFolder folder;
    const gzFile file = gzopen((folder / "a.gz").c_str(), "wb");
    gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size()));
    gzclose(file);
    return fixtures::read_file(folder / "a.gz");
  }
  TemporaryFolder folder_;
};

const std::string& voxels() {
  static const std::string kVoxels = fixtures::bytes_of(fixtures::sixty_voxels());
  return kVoxels;
}

TEST_F(IoFuzz, Vtu) {
  fuzz_mesh("m.vtu");
}
TEST_F(IoFuzz, LegacyVtk) {
  fuzz_mesh("m.vtk");
}
TEST_F(IoFuzz, MeditText) {
  fuzz_mesh("m.mesh");
}
TEST_F(IoFuzz, MeditBinary) {
  fuzz_mesh("m.meshb");
}
TEST_F(IoFuzz, Gmsh41) {
  fuzz_mesh("m.msh");
}
TEST_F(IoFuzz, Gmsh22) {
  fuzz_mesh("m.msh", {.msh_version = MshVersion::k22});
}
TEST_F(IoFuzz, Stl) {
  fuzz_mesh("m.stl");
}
TEST_F(IoFuzz, Off) {
  fuzz_mesh("m.off");
}
TEST_F(IoFuzz, Vtp) {
  fuzz_mesh("m.vtp");
}

TEST_F(IoFuzz, MetricText) {
  fuzz_metric("m.sol");
}
TEST_F(IoFuzz, MetricBinary) {
  fuzz_metric("m.solb");
}

TEST_F(IoFuzz, LegacyVtkInPlainText) {
  fuzz("m.vtk",
       "# vtk DataFile Version 5.1\ntetrahedron\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n"
       "0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 2 4\nOFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n0 1 2 3\n"
       "CELL_TYPES 1\n10\nCELL_DATA 1\nFIELD FieldData 1\nlabel 1 1 int\n5\nMETADATA\nINFORMATION 0\n\n",
       [](const auto& file) { return read_mesh(file); });
}
TEST_F(IoFuzz, CompressedLegacyVtk) {
  write_mesh(folder_ / "good.vtk", fixtures::every_cell_shape().view());
  fuzz("m.vtk.gz", packed(fixtures::read_file(folder_ / "good.vtk")),
       [](const auto& file) { return read_mesh(file); });
}
TEST_F(IoFuzz, MeditBinaryOfTheOtherByteOrder) {
  // Version 1: four vertices of floats, a tetrahedron with reference 5.
  std::string bytes;
  const auto put = [&](auto value) {
    char raw[sizeof(value)];
    std::memcpy(raw, &value, sizeof(value));
    bytes.append(std::reverse_iterator(std::end(raw)), std::reverse_iterator(std::begin(raw)));
  };
  for (const int word : {1, 1, 3, 20, 3, 4, 96, 4}) put(word);
  for (const int corner : {0, 1, 2, 3}) {
    for (const int axis : {1, 2, 3}) put(corner == axis ? 1.0F : 0.0F);
    put(0);
  }
  for (const int word : {8, 128, 1, 1, 2, 3, 4, 5, 54, 0}) put(word);
  fuzz("m.meshb", bytes, [](const auto& file) { return read_mesh(file); });
}

TEST_F(IoFuzz, VtuInPlainText) {
  fuzz("m.vtu", R"(<VTKFile type="UnstructuredGrid" version="0.1"><UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="1"><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">
0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points><Cells><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3
</DataArray><DataArray type="Int32" Name="offsets" format="ascii">4</DataArray><DataArray type="UInt8" Name="types"
format="ascii">10</DataArray></Cells><CellData><DataArray type="Int32" Name="label" format="ascii">5</DataArray>
</CellData></Piece></UnstructuredGrid></VTKFile>)",
       [](const auto& file) { return read_mesh(file); });
}

TEST_F(IoFuzz, Ply) {
  fuzz("m.ply",
       "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
       "element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
       "3 0 2 1\n4 0 1 2 3\n",
       [](const auto& file) { return read_mesh(file); });
}
TEST_F(IoFuzz, BinaryPly) {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
      "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const auto put = [&](auto value) {
    char raw[sizeof(value)];
    std::memcpy(raw, &value, sizeof(value));
    bytes.append(std::begin(raw), std::end(raw));
  };
  for (const float x : {0.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F}) put(x);
  put(std::uint8_t{3});
  for (const std::int32_t corner : {0, 1, 2}) put(corner);
  fuzz("m.ply", bytes, [](const auto& file) { return read_mesh(file); });
}
TEST_F(IoFuzz, PolyDataInLegacyVtk) {
  fuzz("m.vtk",
       "# vtk DataFile Version 5.1\ntetrahedron\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n"
       "0 0 0 1 0 0 0 1 0 0 0 1\nLINES 2 2\nOFFSETS vtktypeint64\n0 2\nCONNECTIVITY vtktypeint64\n0 1\n"
       "POLYGONS 3 6\nOFFSETS vtktypeint64\n0 3 6\nCONNECTIVITY vtktypeint64\n0 2 1 0 1 3\n"
       "TRIANGLE_STRIPS 2 4\nOFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n0 1 2 3\n"
       "CELL_DATA 4\nFIELD FieldData 1\nModelFaceID 1 4 int\n5 6 7 7\nMETADATA\nINFORMATION 0\n\n",
       [](const auto& file) { return read_mesh(file); });
}

TEST_F(IoFuzz, StlInPlainText) {
  fuzz("m.stl",
       "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
       "0\nendloop\nendfacet\nendsolid\n",
       [](const auto& file) { return read_mesh(file); });
}

/// A good file of one line with arrays.
std::string file_of_a_line(const std::filesystem::path& path) {
  Polylines lines;
  lines.points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 1}};
  lines.lines = {{0, 1, 2}};
  lines.scalars["radius"] = {1, 2, 3};
  lines.vectors["velocity"] = {{1, 0, 0}, {1, 0, 0}, {1, 0, 1}};
  write_polylines(path, lines);
  return fixtures::read_file(path);
}

TEST_F(IoFuzz, Polylines) {
  fuzz("l.vtp", file_of_a_line(folder_ / "good.vtp"), [](const auto& file) { return read_polylines(file); });
}

TEST_F(IoFuzz, PointsInText) {
  fuzz("p.csv", "# landmarks\nname,x,y,z\na,0.5,1,-2\nb,3e1,4,5\nc,7,8,9.25\nd,1,1,1\n",
       [](const auto& file) { return read_points(file); });
}
TEST_F(IoFuzz, SolutionInText) {
  fuzz("s.sol", "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n4\n1 1\n0.5\n-2\n1e3\n7\nEnd\n",
       [](const auto& file) { return read_solution(file, 4); });
}
TEST_F(IoFuzz, PointDataInText) {
  fuzz("d.csv", "x,y,z,u,v,w,p\n0,1,2,3,4,5,6\n7,8,9,1e1,11,12,13\n0.5,4,2,nan,1,1,inlet\n",
       [](const auto& file) { return read_point_data(file); });
}
TEST_F(IoFuzz, PointDataOfLinesAndMeshes) {
  fuzz("d.vtp", file_of_a_line(folder_ / "good.vtp"), [](const auto& file) { return read_point_data(file); });
  fuzz("d.vtk",
       "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 2 double\n1 2 3 4 5 6\nLINES 1 3\n2 0 "
       "1\n"
       "POINT_DATA 2\nVECTORS velocity double\n0.5 0 -1 7 8 9\nSCALARS p double 1\nLOOKUP_TABLE default\n3 "
       "nan\n",
       [](const auto& file) { return read_point_data(file); });
}
TEST_F(IoFuzz, PointsOfLinesAndMeshes) {
  Polylines lines;
  lines.points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 1}};
  lines.lines = {{0, 1, 2}};
  write_polylines(folder_ / "good.vtp", lines);
  fuzz("p.vtp", file_of_a_line(folder_ / "good.vtp"), [](const auto& file) { return read_points(file); });
  write_mesh(folder_ / "good.vtk", fixtures::every_cell_shape().view());
  fuzz("p.vtk", fixtures::read_file(folder_ / "good.vtk"),
       [](const auto& file) { return read_points(file); });
}

TEST_F(IoFuzz, Numbers) {
  fixtures::NrrdText header;
  header.type = "float";
  fuzz("s.nrrd", header.with(fixtures::bytes_of(std::vector<float>(60, 0.5F))), [](const auto& file) {
    Context context;
    return read_number_image(file, context);
  });
}

TEST_F(IoFuzz, Nrrd) {
  fuzz_image("a.nrrd", fixtures::NrrdText{}.with(voxels()));
}
TEST_F(IoFuzz, Nifti) {
  fuzz_image("a.nii", fixtures::NiftiBytes{}.with(voxels()));
  fixtures::NiftiBytes series;
  series.data_type = 16;
  series.dimensions = {4, 3, 4, 5, 2, 1, 1, 1};
  fuzz_image("p.nii", series.with(fixtures::bytes_of(std::vector<float>(120, 0.5F))));
}
TEST_F(IoFuzz, DetachedNrrd) {
  fixtures::write_file(folder_ / "voxels.raw", voxels());
  fuzz_image("a.nhdr",
             "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 4 5\nspacings: 0.5 0.5 2\nencoding: raw\n"
             "data file: voxels.raw\n");
}

const char kMetaHeader[] =
    "ObjectType = Image\nNDims = 3\nBinaryData = True\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n"
    "Offset = 1 2 3\nElementSpacing = 0.5 0.6 0.7\nDimSize = 3 4 5\nElementType = MET_UCHAR\n";

TEST_F(IoFuzz, MetaImage) {
  fuzz_image("a.mha", std::string(kMetaHeader) + "ElementDataFile = LOCAL\n" + voxels());
}
TEST_F(IoFuzz, DetachedMetaImage) {
  fixtures::write_file(folder_ / "voxels.raw", voxels());
  fuzz_image("a.mhd", std::string(kMetaHeader) + "HeaderSize = -1\nElementDataFile = voxels.raw\n");
}
TEST_F(IoFuzz, CompressedMetaImage) {
  fuzz_image("a.mha", std::string(kMetaHeader) + "CompressedData = True\nElementDataFile = LOCAL\n" +
                          packed(voxels()));
}

TEST_F(IoFuzz, Gipl) {
  // A header of 256 bytes, high byte first: sizes, type 8 (unsigned char), spacings, the magic number.
  std::string header(256, '\0');
  const auto put = [&](std::size_t at, auto value) {
    char raw[sizeof(value)];
    std::memcpy(raw, &value, sizeof(value));
    std::copy(std::reverse_iterator(std::end(raw)), std::reverse_iterator(std::begin(raw)),
              header.begin() + static_cast<std::ptrdiff_t>(at));
  };
  const std::array<std::uint16_t, 5> sizes_and_type = {3, 4, 5, 1, 8};
  for (std::size_t i = 0; i < 5; ++i) put(2 * i, sizes_and_type.at(i));
  for (std::size_t i = 0; i < 4; ++i) put(10 + 4 * i, 1.0F);
  put(252, std::uint32_t{719555000});
  fuzz_image("a.gipl", header + voxels());
}

TEST_F(IoFuzz, CompressedImages) {
  ImageFrame frame;
  frame.size = Index3(20, 20, 20);
  LabelImage image(frame, {0, 1, 2});
  for (std::size_t i = 0; i < image.voxels().size(); ++i)
    image.voxels()[i] = static_cast<LabelImage::Index>(i * i % 7 % 3);
  for (const char* name : {"b.nrrd", "b.nii.gz"}) {
    write_image(folder_ / name, image);
    fuzz_image(name, fixtures::read_file(folder_ / name));
  }
}

}  // namespace
}  // namespace lumesh
