#include <fmt/core.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <string>

#include "band.hpp"
#include "commands.hpp"
#include "label_pairs.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/field/label_field.hpp"

namespace lumesh::boundary {

namespace {

/// With about 0.1, 0.3, 1, 3 and 10 million voxels in their bands.
constexpr std::array<int, 5> kRadii = {35, 61, 111, 193, 352};

/// A ball off the voxels' symmetries.
LabelImage ball(int radius) {
  ImageFrame frame;
  frame.size = Index3::Constant(2 * radius + 12);
  LabelImage image(frame, {0, 1});
  const Vec3 centre = Vec3(0.31, 0.07, -0.22) + Vec3::Constant(radius + 5.5);
  for (int k = 0; k < frame.size.z(); ++k) {
    for (int j = 0; j < frame.size.y(); ++j) {
      const double squared = radius * radius - std::pow(j - centre.y(), 2) - std::pow(k - centre.z(), 2);
      if (squared < 0) continue;
      const auto first = static_cast<int>(std::ceil(centre.x() - std::sqrt(squared))),
                 last = static_cast<int>(std::floor(centre.x() + std::sqrt(squared)));
      for (int i = first; i <= last; ++i) image.at({i, j, k}) = 1;
    }
  }
  return image;
}

/// "VmRSS" or "VmHWM" of this process, in bytes.
double process_bytes(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(name + ":")) return 1024 * std::stod(line.substr(name.size() + 1));
  throw Error(ErrorKind::kBadInput, "/proc/self/status: no " + name);
}

/// Begins a new peak of memory.
void forget_peak() {
  std::ofstream file("/proc/self/clear_refs");
  file << "5" << std::flush;
  if (!file) throw Error(ErrorKind::kBadInput, "/proc/self/clear_refs: cannot be written");
}

}  // namespace

void run_cost(const RunOptions& options) {
  JsonLines lines(options.json_path);
  fmt::print(
      "The field of balls: nanoseconds of wall and processor time for each voxel in the band, and the most "
      "memory\nthat the process takes beyond what it had before.\n{:>7} {:>11} {:>11} {:>11} {:>9} {:>9} "
      "{:>11}\n",
      "radius", "voxels", "faces", "band", "wall ns", "CPU ns", "bytes/voxel");
  for (const int radius : kRadii) {
    const LabelImage image = ball(radius);
    const auto pairs = field::touching_pairs(image);
    const std::size_t band = field::Band(image, pairs.at(0)).voxel_count();
    forget_peak();
    const double before = process_bytes("VmRSS");
    const std::clock_t cpu_start = std::clock();
    const auto start = std::chrono::steady_clock::now();
    const LabelField built(image, LabelFieldOptions{});
    const std::chrono::duration<double, std::nano> wall = std::chrono::steady_clock::now() - start;
    const double cpu_ns = 1e9 * static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
    const double bytes = process_bytes("VmHWM") - before, count = static_cast<double>(band);
    fmt::print("{:>7} {:>11} {:>11} {:>11} {:>9.0f} {:>9.0f} {:>11.0f}\n", radius, image.voxels().size(),
               pairs[0].faces.size(), band, wall.count() / count, cpu_ns / count, bytes / count);
    std::fflush(stdout);
    lines.write({{"radius_voxels", radius},
                 {"voxels", image.voxels().size()},
                 {"faces", pairs[0].faces.size()},
                 {"band_voxels", band},
                 {"wall_ns_per_voxel", wall.count() / count},
                 {"cpu_ns_per_voxel", cpu_ns / count},
                 {"bytes_per_voxel", bytes / count}});
  }
}

}  // namespace lumesh::boundary
