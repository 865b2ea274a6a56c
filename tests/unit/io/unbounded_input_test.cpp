// Inputs that would never end, or take far more memory than they are long.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zlib.h>

#include "io_fixtures.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/io/point_data_file.hpp"
#include "lumesh/io/points_file.hpp"
#include "lumesh/io/polylines_file.hpp"
#include "lumesh/io/sha256.hpp"
#include "lumesh/io/text_file.hpp"

namespace lumesh {
namespace {

using fixtures::error_of;
using fixtures::write_file;

class UnboundedInput : public testing::Test {
 protected:
  template <class Read>
  void expect_refused(const std::string& name, const Read& read) {
    std::filesystem::create_symlink("/dev/zero", folder_ / name);
    const std::string of_device = error_of([&] { read(folder_ / name); });
    EXPECT_NE(of_device.find(name + ": is not a regular file"), std::string::npos) << of_device;
    std::filesystem::remove(folder_ / name);
    ASSERT_EQ(::mkfifo((folder_ / name).c_str(), 0600), 0);
    const std::string of_pipe = error_of([&] { read(folder_ / name); });
    EXPECT_NE(of_pipe.find(name + ": is not a regular file"), std::string::npos) << of_pipe;
    std::filesystem::remove(folder_ / name);
  }
  fixtures::TemporaryFolder folder_;
};

TEST_F(UnboundedInput, DevicesAndPipesAreNotOpened) {
  using Path = std::filesystem::path;
  for (const char* name : {"a.vtu", "a.vtk", "a.vtk.gz", "a.vtp", "a.stl", "a.msh", "a.mesh", "a.meshb"})
    expect_refused(name, [](const Path& path) { (void)read_mesh(path); });
  for (const char* name : {"a.vtp", "a.vtk", "a.csv"}) {
    expect_refused(name, [](const Path& path) { (void)read_points(path); });
    expect_refused(name, [](const Path& path) { (void)read_point_data(path); });
  }
  for (const char* name : {"a.sol", "a.solb"})
    expect_refused(name, [](const Path& path) { (void)read_metric(path, 4); });
  expect_refused("a.vtp", [](const Path& path) { (void)read_polylines(path); });
  expect_refused("a.toml", [](const Path& path) { (void)read_text_file(path); });
  expect_refused("a.raw", [](const Path& path) { (void)file_sha256(path); });
}

/// Points in one packed block, and arrays on them that are all this block.
std::string vtp_with_shared_arrays(std::size_t points, int arrays) {
  const std::string zeros(24 * points, '\0');
  std::string packed(compressBound(zeros.size()), '\0');
  uLongf size = packed.size();
  EXPECT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &size,
                     reinterpret_cast<const Bytef*>(zeros.data()), zeros.size()),
            Z_OK);
  packed.resize(size);
  std::string header;
  for (const std::uint64_t word :
       {std::uint64_t{1}, std::uint64_t{zeros.size()}, std::uint64_t{0}, std::uint64_t{packed.size()}})
    header.append(reinterpret_cast<const char*>(&word), sizeof word);
  const auto array = [](const std::string& name) {
    return R"(<DataArray type="Float64" Name=")" + name +
           R"(" NumberOfComponents="3" format="appended" offset="0"/>)";
  };
  std::string text = R"(<VTKFile type="PolyData" byte_order="LittleEndian" header_type="UInt64" )"
                     R"(compressor="vtkZLibDataCompressor"><PolyData><Piece NumberOfPoints=")" +
                     std::to_string(points) + R"("><Points>)" + array("points") + "</Points><PointData>";
  for (int i = 0; i < arrays; ++i) text += array("a" + std::to_string(i));
  return text + "</PointData></Piece></PolyData><AppendedData encoding=\"raw\">_" + header + packed +
         "</AppendedData></VTKFile>";
}

TEST_F(UnboundedInput, ArraysThatAreAllTheSameDataDoNotMultiplyIt) {
  const auto read = [&](int arrays) {
    return read_point_data(write_file(folder_ / "a.vtp", vtp_with_shared_arrays(300'000, arrays)));
  };
  EXPECT_EQ(read(0).points.size(), 300'000U);
  const std::string text = error_of([&] { (void)read(100); });
  EXPECT_NE(text.find("several are the same data"), std::string::npos) << text;
}

TEST_F(UnboundedInput, PatchesAreAsManyAsMeshesCanHave) {
  MixedMesh mesh = fixtures::every_cell_shape();
  mesh.triangle_patches[0] = 900'000;
  write_mesh(folder_ / "a.vtu", mesh.view());
  const std::string text = error_of([&] { (void)read_mesh(folder_ / "a.vtu"); });
  EXPECT_NE(
      text.find(
          "no valid patch: its number in the array \"lumesh_triangle_patches\" is 900000, not from 0 to "
          "65534; number the faces anew"),
      std::string::npos)
      << text;
}

}  // namespace
}  // namespace lumesh
