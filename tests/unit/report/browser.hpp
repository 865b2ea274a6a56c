#pragma once
/// @file A page as a real browser sees it.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "lumesh/report/picture.hpp"

namespace lumesh::report {

/// Opens the page with scripts/check_report.sh; false if there is no browser here.
inline bool opened_in_browser(const std::string& html, const std::string& name) {
  const std::filesystem::path script = LUMESH_CHECK_REPORT;
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("lumesh_browser_" + name + "_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "report.html", std::ios::binary) << html;
  const int status = std::system(("'" + script.string() + "' '" + (folder / "report.html").string() + "' '" +
                                  (folder / "shot.png").string() + "'")
                                     .c_str());
  EXPECT_TRUE(WIFEXITED(status));
  constexpr int kNoBrowser = 77;
  const bool opened = WEXITSTATUS(status) != kNoBrowser;
  if (opened) {
    EXPECT_EQ(WEXITSTATUS(status), 0);
    EXPECT_TRUE(std::filesystem::exists(folder / "shot.png"));
  }
  std::filesystem::remove_all(folder);
  return opened;
}

}  // namespace lumesh::report
