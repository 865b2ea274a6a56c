// What is peculiar about an image: pieces, cavities, handles, thin places, holes in walls.
#include "check_image.hpp"

#include <fmt/core.h>

#include "lumesh/image/topology.hpp"
#include "lumesh/image/touching.hpp"

namespace lumesh {
namespace {

void add_if_any(Finding finding, CheckReport& report) {
  if (finding.count > 0) report.findings.push_back(std::move(finding));
}

Finding remark(const char* kind, const char* text, const char* remedy) {
  return {kind, Severity::kRemark, 0, text, remedy, {}, {}};
}

void add_place(const LabelImage& image, const Index3& voxel, Finding& finding) {
  finding.add(image.frame().to_physical(voxel.cast<double>()));
  if (finding.voxels.size() < finding.places_mm.size()) finding.voxels.push_back(voxel);
}

void find_islands(const LabelImage& image, CheckReport& report) {
  Finding finding = remark("islands", "pieces besides the largest one",
                           "`drop_below` N drops those of fewer than N voxels, `largest_component` all");
  const std::vector<VoxelComponent> all = voxel_components(image, ComponentScope::kUnion);
  for (std::size_t i = 1; i < all.size(); ++i) add_place(image, all[i].first, finding);
  if (all.size() > 1)
    finding.text += fmt::format(", of {} to {} voxels", all.back().voxel_count, all[1].voxel_count);
  add_if_any(std::move(finding), report);
}

void find_hollows(const LabelImage& image, CheckReport& report) {
  Finding finding = remark("cavities", "cavities that the labels enclose", "`fill_cavities` fills them");
  std::size_t voxels = 0;
  for (const Cavity& cavity : find_cavities(image)) {
    add_place(image, cavity.first, finding);
    voxels += cavity.voxel_count;
  }
  finding.text += fmt::format(", of {} voxels in all", voxels);
  add_if_any(std::move(finding), report);
}

void find_handles(const LabelImage& image, const std::vector<ThinPlace>& thin, CheckReport& report) {
  const std::int64_t handles = union_topology(image).handle_count();
  if (handles <= 0) return;
  Finding finding = remark("handles", "handles: the object closes a ring",
                           "a ring of vessels is one, and so is each place where vessels touch");
  for (const ThinPlace& place : thin)
    if (place.kind != ThinPlace::Kind::kNear) add_place(image, place.voxel, finding);
  finding.count = static_cast<std::uint64_t>(handles);
  if (!finding.places_mm.empty()) finding.text += "; thin places, which may be theirs,";
  report.findings.push_back(std::move(finding));
}

void find_thin(const LabelImage& image, const std::vector<ThinPlace>& thin, CheckReport& report) {
  Finding touching =
      remark("touching", "places where vessels side by side touch", "`touching` separate or join");
  Finding near = remark("near", "places where vessels side by side are at most a voxel apart",
                        "`touching` join fills the cleft; separate parts only what touches");
  Finding bridges = remark("bridges", "bridges or narrowings one or two voxels thick",
                           "where it is no vessel, take it out of the segmentation");
  for (const ThinPlace& place : thin)
    add_place(image, place.voxel,
              place.kind == ThinPlace::Kind::kTouching ? touching
              : place.kind == ThinPlace::Kind::kNear   ? near
                                                       : bridges);
  for (Finding* finding : {&touching, &near, &bridges}) add_if_any(std::move(*finding), report);
}

void find_holes(const LabelImage& image, CheckReport& report) {
  Finding finding = remark("wall_holes", "places where an enclosed label comes to the outside",
                           "close the wall in the segmentation, unless the vessel is open there");
  const std::vector<WallHole> holes = find_wall_holes(image);
  for (const WallHole& hole : holes) add_place(image, hole.voxel, finding);
  if (!holes.empty())
    finding.text +=
        fmt::format(", of {} to {} voxel faces; label {} within label {} first", holes.back().faces,
                    holes.front().faces, holes.front().inside, holes.front().wall);
  add_if_any(std::move(finding), report);
}

}  // namespace

CheckReport check_image(const LabelImage& image) {
  const Index3& size = image.frame().size;
  CheckReport report = {
      "image",
      fmt::format("{} x {} x {} voxels, {} labels", size.x(), size.y(), size.z(), image.values().size() - 1),
      {}};
  const std::vector<ThinPlace> thin = find_thin_places(image);
  find_islands(image, report);
  find_hollows(image, report);
  find_handles(image, thin, report);
  find_thin(image, thin, report);
  find_holes(image, report);
  return report;
}

}  // namespace lumesh
