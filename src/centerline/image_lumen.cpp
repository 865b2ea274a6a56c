#include <fmt/format.h>

#include <array>
#include <map>

#include "inputs.hpp"
#include "lumesh/core/error.hpp"

namespace lumesh::centerline {

namespace {

std::vector<Index3> foreground(const LabelImage& image) {
  const Index3& size = image.frame().size;
  const auto rows = static_cast<std::size_t>(size.y()) * static_cast<std::size_t>(size.z());
  return parallel::collect<Index3>(
      rows,
      [&](std::size_t row, std::vector<Index3>& out) {
        const auto j = static_cast<int>(row % static_cast<std::size_t>(size.y()));
        const auto k = static_cast<int>(row / static_cast<std::size_t>(size.y()));
        const LabelImage::Index* labels = image.voxels().data() + image.frame().offset({0, j, k});
        for (int i = 0; i < size.x(); ++i)
          if (labels[i] != 0) out.emplace_back(i, j, k);
      },
      512);
}

/// The faces of the frame that a voxel lies at: 2 axis + (1 at the far end).
std::vector<int> faces_at(const Index3& voxel, const Index3& size) {
  std::vector<int> faces;
  for (int a = 0; a < 3; ++a) {
    if (voxel[a] == 0) faces.push_back(2 * a);
    if (voxel[a] == size[a] - 1) faces.push_back(2 * a + 1);
  }
  return faces;
}

/// The voxel with the most room in a patch of border voxels, and the face of the border that most of them lie
/// at.
Opening opening_of(const Lumen& lumen, const std::vector<std::uint32_t>& patch) {
  std::array<std::size_t, 6> votes = {};
  Vec3 middle = Vec3::Zero();
  for (const std::uint32_t id : patch) {
    for (const int face : faces_at(lumen.voxel(id), lumen.frame().size))
      ++votes[static_cast<std::size_t>(face)];
    middle += lumen.position(id) / static_cast<double>(patch.size());
  }
  const auto face = static_cast<int>(std::max_element(votes.begin(), votes.end()) - votes.begin());
  Opening opening;
  const auto better = [&](std::uint32_t a, std::uint32_t b) {
    if (lumen.wall_mm(a) != lumen.wall_mm(b)) return lumen.wall_mm(a) > lumen.wall_mm(b);
    return (lumen.position(a) - middle).squaredNorm() < (lumen.position(b) - middle).squaredNorm();
  };
  for (const std::uint32_t id : patch) {
    const std::vector<int> faces = faces_at(lumen.voxel(id), lumen.frame().size);
    if (std::find(faces.begin(), faces.end(), face) == faces.end()) continue;
    if (opening.voxel == kNoVoxel || better(id, opening.voxel)) opening.voxel = id;
  }
  opening.normal = (face % 2 == 0 ? -1.0 : 1.0) * Vec3::Unit(face / 2);
  opening.point = lumen.position(opening.voxel) + 0.5 * opening.normal * lumen.frame().spacing_mm[face / 2];
  return opening;
}

std::vector<Opening> border_openings(const Lumen& lumen) {
  std::map<std::uint32_t, bool> border;  // Number of each voxel there, and whether its patch is known.
  for (std::uint32_t id = 0; id < lumen.size(); ++id)
    if (!faces_at(lumen.voxel(id), lumen.frame().size).empty()) border[id] = false;
  std::vector<Opening> openings;
  for (auto& [seed, seen] : border) {
    if (seen) continue;
    seen = true;
    std::vector<std::uint32_t> patch = {seed};
    for (std::size_t at = 0; at < patch.size(); ++at) {
      for (int a = 0; a < 6; ++a) {
        const auto next =
            border.find(lumen.find(lumen.voxel(patch[at]) + (a % 2 == 0 ? 1 : -1) * Index3::Unit(a / 2)));
        if (next == border.end() || next->second) continue;
        next->second = true;
        patch.push_back(next->first);
      }
    }
    openings.push_back(opening_of(lumen, patch));
  }
  return openings;
}

}  // namespace

Lumen lumen_of_image(const LabelImage& image, Context& context) {
  std::vector<Index3> voxels = foreground(image);
  if (voxels.empty()) throw Error(ErrorKind::kBadInput, "no voxel is foreground, so that there is no vessel");
  if (voxels.size() == image.frame().voxel_count())
    throw Error(ErrorKind::kBadInput, "every voxel is foreground, so that there is no wall");
  Lumen lumen(image.frame(), std::move(voxels));
  if (lumen.left_out() > 0)
    context.warn(fmt::format("{} voxels outside the largest connected piece are left out", lumen.left_out()));
  lumen.openings = border_openings(lumen);
  return lumen;
}

}  // namespace lumesh::centerline
