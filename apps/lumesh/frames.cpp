#include "frames.hpp"

#include <fmt/core.h>

#include <filesystem>

#include "common.hpp"

namespace lumesh::cli {

std::string numbered(const std::string& path, std::size_t frame) {
  if (path.empty() || path == kStandardOutput) return path;
  const std::size_t percent = path.find('%');
  const std::size_t end =
      percent == std::string::npos ? percent : path.find_first_not_of("0123456789", percent + 1);
  if (end != std::string::npos && path[end] == 'd' && end - percent <= 3) {
    const std::string digits = path.substr(percent + 1, end - percent - 1);
    const std::size_t width = digits.empty() ? 0 : std::stoul(digits);
    return fmt::format("{}{:0{}}{}", path.substr(0, percent), frame, width, path.substr(end + 1));
  }
  const std::filesystem::path whole(path);
  std::string name = whole.filename().string();
  std::size_t dot = name.find('.', 1);
  if (name.ends_with("-mesh-complete")) dot = name.size() - std::string("-mesh-complete").size();
  if (dot == std::string::npos) dot = name.size();
  name.insert(dot, fmt::format("_{:03}", frame));
  return (whole.parent_path() / name).string();
}

}  // namespace lumesh::cli
