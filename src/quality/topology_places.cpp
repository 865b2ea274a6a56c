#include "lumesh/quality/topology_places.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "lumesh/core/counted.hpp"
#include "pieces.hpp"

namespace lumesh::quality {

namespace {

/// "one handle less", of a number that is not zero.
std::string more_or_less(std::int64_t more, const char* one, const char* many) {
  const auto count = static_cast<std::uint64_t>(more < 0 ? -more : more);
  return counted(count, one, many) + (more < 0 ? " less" : " more");
}

std::string what_changes(const TopologyPlace& place) {
  std::string words;
  if (place.handles != 0) words = more_or_less(place.handles, "handle", "handles");
  if (place.cavities != 0)
    words += (words.empty() ? "" : " or ") + more_or_less(place.cavities, "cavity", "cavities");
  return words;
}

}  // namespace

std::vector<TopologyPlace> find_topology_places(const MeshView& mesh, const LabelImage& image,
                                                std::span<const TopologyDifference> differences) {
  std::vector<TopologyPlace> places;
  if (differences.empty()) return places;
  places = find_piece_places(mesh, image, differences);
  std::size_t warped = 0;
  for (const TopologyDifference& difference : differences) {
    const bool is_of_pieces =
        difference.handles == 0 && difference.cavities == 0 && difference.components != 0;
    if (is_of_pieces || ++warped > kMaxWarped) continue;
    const std::vector<TopologyPlace> more = find_warping_places(mesh, image, difference);
    places.insert(places.end(), more.begin(), more.end());
  }
  std::ranges::stable_sort(places,
                           [](const TopologyPlace& a, const TopologyPlace& b) { return a.label < b.label; });
  return places;
}

std::string in_words(const TopologyPlace& place) {
  switch (place.change) {
    case TopologyChange::kExtraPiece:
      return fmt::format("a piece of {:.3g} mm³ ({}) that holds no voxel", place.volume_mm3,
                         counted(place.cells, "cell"));
    case TopologyChange::kMissingPiece:
      return fmt::format("a piece of {} voxels ({:.3g} mm³) that the mesh does not have", place.voxels,
                         place.volume_mm3);
    case TopologyChange::kJoined:
      return fmt::format("a piece of {} voxels ({:.3g} mm³) is joined to another", place.voxels,
                         place.volume_mm3);
    case TopologyChange::kSplit:
      return fmt::format("a part of {:.3g} mm³ ({}) is split off", place.volume_mm3,
                         counted(place.cells, "cell"));
    case TopologyChange::kFilled:
      return fmt::format("{}: {:.3g} mm³ too much", what_changes(place), place.volume_mm3);
    case TopologyChange::kCut:
      return fmt::format("{}: {:.3g} mm³ too little", what_changes(place), place.volume_mm3);
  }
  return "";
}

}  // namespace lumesh::quality
