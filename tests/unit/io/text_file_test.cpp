#include "lumesh/io/text_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "io_fixtures.hpp"
#include "lumesh/core/error.hpp"

namespace lumesh {
namespace {

namespace fs = std::filesystem;

TEST(TextFile, ReplacesTheTargetAndLeavesNothingBehindOnFailure) {
  const fixtures::TemporaryFolder folder;
  write_text_file(folder / "a.txt", "one");
  write_text_file(folder / "a.txt", "two");
  EXPECT_EQ(fixtures::read_file(folder / "a.txt"), "two");
  fs::create_directories(folder / "occupied" / "inside");
  EXPECT_THROW(write_text_file(folder / "occupied", "x"), Error);
  EXPECT_THROW(write_text_file(folder / "missing" / "b.txt", "x"), Error);
  EXPECT_EQ(folder.file_count(), 2U) << "a.txt and the folder";
}

TEST(TextFile, FollowsLinksKeepsPermissionsAndTheFilesOfOthers) {
  const fixtures::TemporaryFolder folder;
  write_text_file(folder / "real.json", "old");
  write_text_file(folder / "real.json.part", "of the user");
  fs::permissions(folder / "real.json", fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("real.json", folder / "link.json");
  write_text_file(folder / "link.json", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link.json"));
  EXPECT_EQ(fixtures::read_file(folder / "real.json"), "new");
  EXPECT_EQ(fixtures::read_file(folder / "real.json.part"), "of the user");
  EXPECT_EQ(fs::status(folder / "real.json").permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST(TextFile, WritesWhereALinkLeadsThatNothingIsAtYet) {
  const fixtures::TemporaryFolder folder;
  fs::create_symlink("second.json", folder / "first.json");
  fs::create_symlink(folder / "real.json", folder / "second.json");
  write_text_file(folder / "first.json", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "first.json"));
  EXPECT_TRUE(fs::is_symlink(folder / "second.json"));
  EXPECT_EQ(fixtures::read_file(folder / "real.json"), "new");
  fs::create_symlink("missing/real.json", folder / "third.json");
  EXPECT_THROW(write_text_file(folder / "third.json", "new"), Error);
  EXPECT_TRUE(fs::is_symlink(folder / "third.json"));
}

}  // namespace
}  // namespace lumesh
