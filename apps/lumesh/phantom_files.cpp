#include "phantom_files.hpp"

#include <fstream>

#include "lumesh/core/error.hpp"

namespace lumesh::cli {

/// Written beside the target and renamed when complete.
void write_parameters(const std::filesystem::path& path, const PhantomSpec& spec) {
  std::filesystem::path partial = path;
  partial += ".part";
  std::error_code failed;
  {
    std::ofstream file(partial);
    file << to_json_text(spec);
    file.close();
    if (!file) failed = std::make_error_code(std::errc::io_error);
  }
  if (!failed) std::filesystem::rename(partial, path, failed);
  if (!failed) return;
  std::error_code ignored;
  std::filesystem::remove(partial, ignored);
  throw Error(ErrorKind::kBadInput,
              path.string() + ": cannot be written; does its folder exist and have room?");
}

namespace {

void append_line(Polylines& lines, const std::vector<Vec3>& points) {
  std::vector<std::uint32_t>& line = lines.lines.emplace_back();
  for (const Vec3& point : points) {
    line.push_back(static_cast<std::uint32_t>(lines.points.size()));
    lines.points.push_back(point);
  }
}

}  // namespace

Polylines centerline_of(const Phantom& phantom) {
  Polylines lines;
  for (const PhantomCurve& curve : phantom.centerline()) {
    append_line(lines, curve.points_mm);
    std::vector<double>& radius = lines.scalars["radius"];
    radius.insert(radius.end(), curve.radius_mm.begin(), curve.radius_mm.end());
    lines.scalars["branch"].resize(lines.points.size(), curve.branch);
  }
  return lines;
}

Polylines velocity_of(const Phantom& phantom) {
  Polylines lines;
  for (const PhantomStreamline& streamline : phantom.velocity_streamlines()) {
    append_line(lines, streamline.points_mm);
    std::vector<Vec3>& velocity = lines.vectors["velocity"];
    velocity.insert(velocity.end(), streamline.velocity_m_s.begin(), streamline.velocity_m_s.end());
  }
  return lines;
}

}  // namespace lumesh::cli
