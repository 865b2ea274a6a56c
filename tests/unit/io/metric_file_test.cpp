// Metrics in Medit's .sol and .solb: the order of the six numbers, every encoding, and what is refused.
#include "lumesh/io/metric_file.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "io_fixtures.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh {
namespace {

using fixtures::different_tensors;
using fixtures::write_file;

class MetricFile : public testing::Test {
 protected:
  std::vector<SymTensor> read(const std::string& name, const std::string& content, std::size_t vertices) {
    return read_metric(write_file(folder_ / name, content), vertices);
  }
  void expect_refused(const std::string& name, const std::string& content, std::size_t vertices,
                      const std::string& words) {
    SCOPED_TRACE(words);
    const std::string text = fixtures::error_of([&] { (void)read(name, content, vertices); });
    EXPECT_NE(text.find(words), std::string::npos) << text;
    EXPECT_NE(text.find(name), std::string::npos) << text;
    // Another writing of the file helps only where it is damaged.
    if (words.starts_with("has ") || words.starts_with("dimension")) {
      EXPECT_EQ(text.find("write the file again"), std::string::npos) << text;
    }
  }
  fixtures::TemporaryFolder folder_;
};

/// As "has 2 tensors, …" wants it: a head and rows.
std::string sol(const std::string& rows, const std::string& head = "2\n1 3") {
  return "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n" + head + "\n" + rows + "End\n";
}

const char kFirstRow[] = "4 0.5 9.1 -0.25 1.5 16\n";

TEST_F(MetricFile, ComesBackToTheLastBit) {
  std::vector<SymTensor> metric = different_tensors(1000);
  metric[7] = SymTensor{.xx = 1.0 / 3, .xy = 0.1, .xz = 1e-17, .yy = 2e300, .yz = -0.2, .zz = 1e18};
  for (const char* name : {"m.sol", "m.solb", "M.SOL"}) {
    SCOPED_TRACE(name);
    write_metric(folder_ / name, metric);
    EXPECT_EQ(read_metric(folder_ / name, metric.size()), metric);
    EXPECT_EQ(folder_.file_count(), 1U) << "the temporary file stays";
    std::filesystem::remove(folder_ / name);
  }
}

TEST_F(MetricFile, HasTheLowerTriangleByRowsInText) {
  write_metric(folder_ / "m.sol", different_tensors(1));
  EXPECT_EQ(fixtures::read_file(folder_ / "m.sol"), sol(kFirstRow, "1\n1 3"));
}

TEST_F(MetricFile, IsReadFromTextWrittenByHand) {
  const auto metric = read("m.sol",
                           "# by hand\nMeshVersionFormatted\n1\nDimension\n3\n\nTime\n0.25\n"
                           "SolAtVertices   2\n1 3\n  +4 .5e0 9.1 -0.25 1.5 16   8 1 18.2 -0.5 3\n32\nEnd",
                           2);
  EXPECT_EQ(metric, (std::vector<SymTensor>{{4, 0.5, -0.25, 9.1, 1.5, 16}, {8, 1, -0.5, 18.2, 3, 32}}));
}

TEST_F(MetricFile, MayLackItsEndBehindAWholeLine) {
  const std::string text = sol(kFirstRow, "1\n1 3");
  const std::string without_end = text.substr(0, text.size() - 4);
  EXPECT_EQ(read("m.sol", without_end, 1), different_tensors(1));
  expect_refused("m.sol", without_end.substr(0, without_end.size() - 1), 1, "may be cut off");
}

TEST_F(MetricFile, TurnsASizeIntoATensor) {
  const auto metric = read("m.sol", sol("0.5\n2\n", "2\n1 1"), 2);
  EXPECT_EQ(metric,
            (std::vector<SymTensor>{SymTensor::diagonal(4, 4, 4), SymTensor::diagonal(0.25, 0.25, 0.25)}));
}

TEST_F(MetricFile, OfAMeshWithoutVerticesIsEmpty) {
  for (const char* name : {"m.sol", "m.solb"}) {
    write_metric(folder_ / name, {});
    EXPECT_TRUE(read_metric(folder_ / name, 0).empty());
  }
}

TEST_F(MetricFile, WithAnotherNumberOfVerticesIsRefused) {
  write_metric(folder_ / "m.solb", different_tensors(12));
  const std::string bytes = fixtures::read_file(folder_ / "m.solb");
  expect_refused("m.solb", bytes, 64, "has 12 tensors, the mesh has 64 vertices");
  expect_refused("m.sol", sol(kFirstRow), 1, "has 2 tensors, the mesh has 1 vertices");
  expect_refused("m.sol", sol("1\n", "1\n1 1"), 3, "has 1 sizes, the mesh has 3 vertices");
  expect_refused("m.sol", sol("", "-1\n1 3"), 3, "has -1 tensors");
  expect_refused("m.sol", sol(kFirstRow), 2, "line 7: ");
  expect_refused("m.sol", sol(std::string(kFirstRow) + kFirstRow, "1\n1 3"), 1, "more numbers than it says");
}

TEST_F(MetricFile, WithATensorThatIsNoMetricIsRefusedByItsVertex) {
  const auto expect = [&](const std::string& row, const std::string& fault) {
    expect_refused("m.sol", sol(kFirstRow + row + "\n"), 2, "line 7: the tensor of vertex 2 " + fault);
  };
  expect("nan 0 1 0 0 1", "is not finite");
  expect("1 0 1 0 inf 1", "is not finite");
  expect("0 0 1 0 0 1", "is not positive definite");
  expect("1 0 1 0 0 -1", "is not positive definite");
  expect("1 2 1 0 0 1", "is not positive definite; the order is xx xy yy xz yz zz");
  expect("1 0 1 0 1 1", "is not positive definite");
  expect("1 0.9 1 0.9 -0.9 1", "is not positive definite");  // Every 2 x 2 minor is positive.
  expect("1 1 1 1 1 1", "is not positive definite");
  expect_refused("m.sol", sol("1\n0\n", "2\n1 1"), 2, "the size of vertex 2 is 0");
  expect_refused("m.sol", sol("1\n-3\n", "2\n1 1"), 2, "the size of vertex 2 is -3");
  expect_refused("m.sol", sol("1\n1e-200\n", "2\n1 1"), 2, "the size of vertex 2 is 1e-200");
  expect_refused("m.sol", sol("1\ninf\n", "2\n1 1"), 2, "the size of vertex 2 is inf");
  expect_refused("m.sol", sol("1\n1e999\n", "2\n1 1"), 2, "line 7: ");
}

TEST_F(MetricFile, MayBeVeryAnisotropicInAnyDirection) {
  // Sizes 1e-6, 1 and 0.1 mm along three orthonormal directions.
  const Vec3 a = Vec3(2, -3, 6) / 7, b = Vec3(6, -2, -3) / 7, c = Vec3(3, 6, 2) / 7;
  const Mat3 full = 1e12 * a * a.transpose() + b * b.transpose() + 100 * c * c.transpose();
  const std::vector<SymTensor> metric = {SymTensor::from(full), SymTensor::diagonal(1e200, 1e-200, 1)};
  write_metric(folder_ / "m.solb", metric);
  EXPECT_EQ(read_metric(folder_ / "m.solb", 2), metric);
  // Without a size along c there is no metric, whatever the rounding of the entries.
  const std::vector<SymTensor> flat = {SymTensor::from(Mat3(1e12 * a * a.transpose()))};
  fixtures::error_of([&] { write_metric(folder_ / "flat.solb", flat); });
}

TEST_F(MetricFile, WithAnotherFieldIsRefused) {
  expect_refused("m.sol", sol(kFirstRow, "1\n2 3 1"), 1, "has 2 fields");
  expect_refused("m.sol", sol("1 2 3\n", "1\n1 2"), 1, "kind 2");
  expect_refused("m.sol", sol("1 2 3\n", "1\n1 4"), 1, "kind 4");
  expect_refused("m.sol", sol(kFirstRow, "1\n0"), 1, "has 0 fields");
  expect_refused("m.sol", "MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n1\n1 3\n1 0 1\nEnd\n", 1,
                 "dimension 2");
  expect_refused("m.sol", "MeshVersionFormatted 2\nDimension 3\nEnd\n", 1, "no section SolAtVertices");
  expect_refused("m.sol", sol(kFirstRow + std::string("SolAtVertices\n1\n1 1\n2\n"), "1\n1 3"), 1,
                 "several sections");
  expect_refused("m.sol", "", 1, "MeshVersionFormatted");
}

TEST_F(MetricFile, CutOffAnywhereInTextIsRefused) {
  const std::string whole = sol(kFirstRow + std::string("8 1 18.2 -0.5 3 32\n"));
  const std::size_t needed = whole.size() - std::string_view("End\n").size();
  for (std::size_t size = 0; size < needed; ++size) {
    SCOPED_TRACE(size);
    write_file(folder_ / "m.sol", whole.substr(0, size));
    fixtures::error_of([&] { (void)read_metric(folder_ / "m.sol", 2); });
  }
}

TEST_F(MetricFile, HasAKnownName) {
  const auto expect = [&](const std::string& text, const std::string& words) {
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  expect(fixtures::error_of([&] { (void)read_metric(folder_ / "m.vtu", 1); }), "use .sol or .solb");
  expect(fixtures::error_of([&] { write_metric(folder_ / "m", {}); }), "use .sol or .solb");
  expect(fixtures::error_of([&] { (void)read_metric(folder_ / "none.solb", 1); }), "no such file");
  expect(fixtures::error_of([&] { write_metric(folder_ / "no folder" / "m.sol", different_tensors(1)); }),
         "no folder");
}

TEST_F(MetricFile, ThatCannotBeWrittenLeavesTheOlderOne) {
  write_file(folder_ / "m.sol", "before");
  std::vector<SymTensor> metric = different_tensors(3);
  metric[1].yy = std::numeric_limits<double>::quiet_NaN();
  const std::string text = fixtures::error_of([&] { write_metric(folder_ / "m.sol", metric); });
  EXPECT_NE(text.find("vertex 2 is not finite"), std::string::npos) << text;
  EXPECT_EQ(fixtures::read_file(folder_ / "m.sol"), "before");
  EXPECT_EQ(folder_.file_count(), 1U);
}

/// Medit's binary layout in one version and byte order, number by number.
struct SolbKind {
  int version;
  std::endian order;
};

void PrintTo(const SolbKind& kind, std::ostream* out) {
  *out << "version " << kind.version << (kind.order == std::endian::big ? ", high byte first" : "");
}

class SolbBytes {
 public:
  explicit SolbBytes(const SolbKind& kind) : kind_(kind) {
    put(std::int32_t{1});
    put(std::int32_t{kind.version});
    begin(3, 4);
    put(std::int32_t{3});
  }
  /// A section with the rows' numbers behind each other; fields and kinds have 32 bits in every version.
  SolbBytes& field(int rows, const std::vector<int>& kinds, const std::vector<double>& numbers) {
    const std::size_t real = kind_.version == 1 ? 4 : 8;
    begin(62, (kind_.version == 4 ? 8 : 4) + 4 * (1 + kinds.size()) + real * numbers.size());
    if (kind_.version == 4)
      put(std::int64_t{rows});
    else
      put(std::int32_t{rows});
    put(static_cast<std::int32_t>(kinds.size()));
    for (const int kind : kinds) put(std::int32_t{kind});
    for (const double number : numbers) {
      if (kind_.version == 1)
        put(static_cast<float>(number));
      else
        put(number);
    }
    return *this;
  }
  std::string end() {
    put(std::int32_t{54});
    put_position(0);
    return bytes_;
  }

 private:
  template <class Value>
  void put(Value value) {
    std::array<char, sizeof(Value)> raw;
    std::memcpy(raw.data(), &value, sizeof(Value));
    if (kind_.order != std::endian::native) std::reverse(raw.begin(), raw.end());
    bytes_.append(raw.data(), raw.size());
  }
  void put_position(std::size_t position) {
    if (kind_.version >= 3)
      put(static_cast<std::int64_t>(position));
    else
      put(static_cast<std::int32_t>(position));
  }
  void begin(std::int32_t keyword, std::size_t bytes) {
    put(keyword);
    put_position(bytes_.size() + (kind_.version >= 3 ? 8 : 4) + bytes);
  }

  SolbKind kind_;
  std::string bytes_;
};

/// Exact in single precision.
const std::vector<double> kTwoTensors = {4, 0.5, 9.25, -0.25, 1.5, 16, 8, 1, 18.5, -0.5, 3, 32};

class MetricBytes : public testing::TestWithParam<SolbKind> {
 protected:
  fixtures::TemporaryFolder folder_;
};

TEST_P(MetricBytes, AreRead) {
  const auto tensors = write_file(folder_ / "t.solb", SolbBytes(GetParam()).field(2, {3}, kTwoTensors).end());
  EXPECT_EQ(read_metric(tensors, 2),
            (std::vector<SymTensor>{{4, 0.5, -0.25, 9.25, 1.5, 16}, {8, 1, -0.5, 18.5, 3, 32}}));
  const auto sizes = write_file(folder_ / "s.solb", SolbBytes(GetParam()).field(1, {1}, {0.5}).end());
  EXPECT_EQ(read_metric(sizes, 1), std::vector<SymTensor>{SymTensor::diagonal(4, 4, 4)});
}

TEST_P(MetricBytes, CutOffAnywhereAreRefused) {
  const std::string whole = SolbBytes(GetParam()).field(2, {3}, kTwoTensors).end();
  // The last position is not needed: it says that nothing follows.
  const std::size_t needed = whole.size() - (GetParam().version >= 3 ? 8 : 4);
  for (std::size_t size = 0; size < needed; ++size) {
    SCOPED_TRACE(size);
    write_file(folder_ / "m.solb", whole.substr(0, size));
    fixtures::error_of([&] { (void)read_metric(folder_ / "m.solb", 2); });
  }
}

TEST_P(MetricBytes, OfAnotherKindAreRefused) {
  const auto expect = [&](const std::string& bytes, const std::string& words) {
    write_file(folder_ / "m.solb", bytes);
    const std::string text = fixtures::error_of([&] { (void)read_metric(folder_ / "m.solb", 1); });
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  expect(SolbBytes(GetParam()).field(1, {3, 1}, {1, 0, 1, 0, 0, 1, 2}).end(), "has 2 fields");
  expect(SolbBytes(GetParam()).field(1, {2}, {1, 2, 3}).end(), "kind 2");
  expect(SolbBytes(GetParam()).field(1, {3}, {1, 0, -1, 0, 0, 1}).end(), "vertex 1 is not positive definite");
  expect(SolbBytes(GetParam()).field(3, {3}, {1, 0, 1, 0, 0, 1}).end(), "has 3 tensors, the mesh has 1");
  expect(SolbBytes(GetParam()).field(1, {1}, {1}).field(1, {1}, {1}).end(), "several sections");
  expect(SolbBytes(GetParam()).end(), "no section SolAtVertices");
}

INSTANTIATE_TEST_SUITE_P(Versions, MetricBytes,
                         testing::Values(SolbKind{1, std::endian::little}, SolbKind{2, std::endian::little},
                                         SolbKind{3, std::endian::little}, SolbKind{4, std::endian::little},
                                         SolbKind{1, std::endian::big}, SolbKind{2, std::endian::big},
                                         SolbKind{3, std::endian::big}, SolbKind{4, std::endian::big}));

TEST_F(MetricFile, IsInBinaryTheLayoutOfVersion2) {
  write_metric(folder_ / "m.solb", different_tensors(1));
  EXPECT_EQ(fixtures::read_file(folder_ / "m.solb"),
            SolbBytes({2, std::endian::little}).field(1, {3}, {4, 0.5, 9.1, -0.25, 1.5, 16}).end());
}

TEST_F(MetricFile, OfDimension2IsRefusedInBinary) {
  std::string bytes = SolbBytes({2, std::endian::little}).field(1, {3}, {1, 0, 1, 0, 0, 1}).end();
  bytes[16] = 2;  // Behind byte order, version, keyword and position.
  expect_refused("m.solb", bytes, 1, "dimension 2");
}

/// The cube of the Unstructured Grid Adaptation Working Group, written by refine.
class MetricOfTheCube : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(cube_ / "cube-linear-00.solb")) GTEST_SKIP() << "no cube at " << cube_;
    mesh_ = read_mesh(cube_ / "cube-linear-00.mesh");
  }
  std::filesystem::path cube_ = std::filesystem::path(LUMESH_SHARED_DATA) / "ugawg" / "cube";
  MixedMesh mesh_;
};

TEST_F(MetricOfTheCube, IsTheFormulaInTextAndInBytes) {
  ASSERT_EQ(mesh_.points.size(), 64U);
  for (const char* name : {"cube-linear-00.sol", "cube-linear-00.solb"}) {
    SCOPED_TRACE(name);
    const std::vector<SymTensor> metric = read_metric(cube_ / name, mesh_.points.size());
    ASSERT_EQ(metric.size(), mesh_.points.size());
    for (std::size_t i = 0; i < metric.size(); ++i) {
      const double h_z = 0.001 + 0.198 * std::abs(mesh_.points[i].z() - 0.5);
      EXPECT_NEAR(metric[i].xx, 100, 1e-10);
      EXPECT_NEAR(metric[i].yy, 100, 1e-10);
      EXPECT_NEAR(metric[i].zz * h_z * h_z, 1, 1e-10) << i;
      EXPECT_EQ(std::abs(metric[i].xy) + std::abs(metric[i].xz) + std::abs(metric[i].yz), 0);
    }
  }
}

TEST_F(MetricOfTheCube, IsTheSameInTextAndInBytes) {
  const auto text = read_metric(cube_ / "cube-linear-00.sol", 64);
  const auto bytes = read_metric(cube_ / "cube-linear-00.solb", 64);
  for (std::size_t i = 0; i < text.size(); ++i) EXPECT_NEAR(text[i].zz, bytes[i].zz, 1e-12 * bytes[i].zz);
}

}  // namespace
}  // namespace lumesh
