// Inputs that would never end.
#include <gtest/gtest.h>
#include <sys/stat.h>

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

}  // namespace
}  // namespace lumesh
