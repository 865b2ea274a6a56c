#include <fmt/format.h>

#include <array>
#include <map>

#include "cut_voxels.hpp"
#include "inputs.hpp"
#include "lumesh/core/error.hpp"

namespace lumesh::centerline {

namespace {

/// The faces of the frame that a voxel lies at: 2 axis + (1 at the far end).
std::vector<int> faces_at(const Index3& voxel, const Index3& size) {
  std::vector<int> faces;
  for (int a = 0; a < 3; ++a) {
    if (voxel[a] == 0) faces.push_back(2 * a);
    if (voxel[a] == size[a] - 1) faces.push_back(2 * a + 1);
  }
  return faces;
}

/// The voxel with the most room; of equals the one nearest to a place. None of an empty list.
std::uint32_t roomiest(const Lumen& lumen, const std::vector<std::uint32_t>& ids, const Vec3& middle) {
  std::uint32_t best = kNoVoxel;
  const auto better = [&](std::uint32_t a, std::uint32_t b) {
    if (lumen.wall_mm(a) != lumen.wall_mm(b)) return lumen.wall_mm(a) > lumen.wall_mm(b);
    return (lumen.position(a) - middle).squaredNorm() < (lumen.position(b) - middle).squaredNorm();
  };
  for (const std::uint32_t id : ids)
    if (best == kNoVoxel || better(id, best)) best = id;
  return best;
}

Vec3 middle_of(const Lumen& lumen, const std::vector<std::uint32_t>& ids) {
  Vec3 middle = Vec3::Zero();
  for (const std::uint32_t id : ids) middle += lumen.position(id) / static_cast<double>(ids.size());
  return middle;
}

/// At the face of the border that most voxels of a patch of border voxels lie at.
Opening opening_of(const Lumen& lumen, const std::vector<std::uint32_t>& patch) {
  std::array<std::size_t, 6> votes = {};
  for (const std::uint32_t id : patch)
    for (const int face : faces_at(lumen.voxel(id), lumen.frame().size))
      ++votes[static_cast<std::size_t>(face)];
  const auto face = static_cast<int>(std::ranges::max_element(votes) - votes.begin());
  std::vector<std::uint32_t> at_face;
  for (const std::uint32_t id : patch) {
    const std::vector<int> faces = faces_at(lumen.voxel(id), lumen.frame().size);
    if (std::ranges::find(faces, face) != faces.end()) at_face.push_back(id);
  }
  Opening opening;
  opening.voxel = roomiest(lumen, at_face, middle_of(lumen, patch));
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

Vec3 to_space(const Lumen& lumen, const Vec3& position) {
  return lumen.frame().origin_mm + lumen.frame().direction * position;
}

/// Moves an opening along the normal of a plane into it.
void lay_into(const CutPlane& plane, const Lumen& lumen, Opening& opening) {
  opening.normal = lumen.frame().direction.transpose() * plane.normal;
  opening.point -= plane.height(to_space(lumen, opening.point)) * opening.normal;
}

std::vector<Opening> cut_openings(const Lumen& lumen, const std::vector<CutSection>& sections) {
  std::vector<Opening> openings;
  for (const CutSection& section : sections) {
    std::vector<std::uint32_t> ids;
    for (const Index3& v : section.voxels)
      if (const std::uint32_t id = lumen.find(v); id != kNoVoxel) ids.push_back(id);
    if (ids.empty()) continue;  // Of a piece that is left out.
    Opening& opening = openings.emplace_back();
    opening.voxel = roomiest(lumen, ids, middle_of(lumen, ids));
    opening.point = lumen.position(opening.voxel);
    lay_into(section.plane, lumen, opening);
  }
  return openings;
}

/// Openings at the border and at the planes; of those at the border a plane may take off half a voxel.
std::vector<Opening> all_openings(const Lumen& lumen, const CutVoxels& cut) {
  std::vector<Opening> openings = border_openings(lumen);
  for (Opening& opening : openings)
    for (const CutPlane& plane : cut.planes)
      if (plane.beyond_mm(to_space(lumen, opening.point)) > 0) lay_into(plane, lumen, opening);
  const std::vector<Opening> at_planes = cut_openings(lumen, cut.sections);
  openings.insert(openings.end(), at_planes.begin(), at_planes.end());
  return openings;
}

}  // namespace

Lumen lumen_of_image(const LabelImage& image, std::span<const CutPlane> cuts, Context& context) {
  CutVoxels cut = voxels_before(image, cuts);
  if (cut.inside.empty())
    throw Error(ErrorKind::kBadInput, "no voxel is foreground, so that there is no vessel");
  if (cut.inside.size() == image.frame().voxel_count())
    throw Error(ErrorKind::kBadInput, "every voxel is foreground, so that there is no wall");
  Lumen lumen(image.frame(), std::move(cut.inside), cut.beyond);
  if (lumen.left_out() > 0)
    context.warn(fmt::format("{} voxels outside the largest connected piece are left out", lumen.left_out()));
  lumen.openings = all_openings(lumen, cut);
  return lumen;
}

}  // namespace lumesh::centerline
