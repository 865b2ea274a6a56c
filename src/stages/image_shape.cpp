#include "lumesh/stages/image_shape.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "lumesh/mesh/label_shapes.hpp"

namespace lumesh {
namespace {

constexpr std::size_t kLeastVoxels = 27, kMostListed = 3;

/// Whether any tetrahedron of the piece's label has its middle in the piece's box.
std::vector<bool> found_pieces(const ImageShape& image, const TetMesh& mesh) {
  std::map<Label, std::vector<std::size_t>> missing;
  for (std::size_t p = 0; p < image.pieces.size(); ++p) missing[image.pieces[p].label].push_back(p);
  std::vector<bool> is_found(image.pieces.size(), false);
  for (std::uint32_t i = 0; i < mesh.tet_count() && !missing.empty(); ++i) {
    const TetId t(i);
    const auto pieces = missing.find(mesh.label(t));
    if (pieces == missing.end()) continue;
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < 4; ++k) sum += mesh.corner(t, k);
    const Vec3 index = image.frame.to_index(0.25 * sum);
    std::erase_if(pieces->second, [&](std::size_t p) {
      const VoxelBox& box = image.pieces[p].box;
      const bool is_inside = ((index - box.low.cast<double>()).array() >= -1).all() &&
                             ((box.high.cast<double>() - index).array() >= 0).all();
      if (is_inside) is_found[p] = true;
      return is_inside;
    });
    if (pieces->second.empty()) missing.erase(pieces);
  }
  return is_found;
}

std::string lost_pieces(const ImageShape& image, const TetMesh& mesh) {
  const std::vector<bool> is_found = found_pieces(image, mesh);
  std::string list;
  std::size_t lost = 0;
  for (std::size_t p = 0; p < image.pieces.size(); ++p) {
    if (is_found[p] || ++lost > kMostListed) continue;
    const VoxelComponent& piece = image.pieces[p];
    const Vec3 middle =
        image.frame.to_physical(0.5 * (piece.box.low + piece.box.high).cast<double>() - Vec3::Constant(0.5));
    list += fmt::format("{}label {} at ({:.4g}, {:.4g}, {:.4g}) mm of {} voxels", lost == 1 ? "" : "; ",
                        piece.label, middle.x(), middle.y(), middle.z(), piece.voxel_count);
  }
  if (lost == 0) return {};
  return fmt::format("{} piece{} of labels not in the mesh: {}{}; a smaller `delta` keeps more", lost,
                     lost == 1 ? "" : "s", list, lost > kMostListed ? "; ..." : "");
}

std::string other_shapes(const ImageShape& image, const TetMesh& mesh) {
  const std::vector<LabelShape> solids = label_shapes(mesh);
  std::string list;
  std::size_t others = 0;
  for (const LabelTopology& label : image.labels) {
    const auto solid =
        std::find_if(solids.begin(), solids.end(), [&](const auto& s) { return s.label == label.label; });
    const std::uint64_t pieces = solid == solids.end() ? 0 : solid->components;
    const std::int64_t euler = solid == solids.end() ? 0 : solid->euler;
    if (pieces == label.component_count && euler == label.euler_number) continue;
    if (++others <= kMostListed)
      list +=
          fmt::format("{}label {} with {} pieces and Euler number {}, of {} and {}", others == 1 ? "" : "; ",
                      label.label, pieces, euler, label.component_count, label.euler_number);
  }
  if (others == 0) return {};
  return fmt::format(
      "{} label{} in the mesh differ{} from the image's voxels: {}{}; `boundary` exact keeps more details of "
      "about a voxel, a smaller `delta` larger ones",
      others, others == 1 ? "" : "s", others == 1 ? "s" : "", list, others > kMostListed ? "; ..." : "");
}

std::string other_volumes(const ImageShape& image, const TetMesh& mesh) {
  constexpr double kMuch = 0.05;
  constexpr std::uint64_t kLeast = 100;  // Voxels.
  const std::map<Label, double> volumes = volumes_of_labels(mesh);
  std::size_t others = 0;
  double worst = 0;
  Label label = 0;
  for (const LabelTopology& one : image.labels) {
    const auto found = volumes.find(one.label);
    if (one.voxel_count < kLeast || found == volumes.end()) continue;
    const double change = found->second / one.volume_mm3 - 1;
    others += std::abs(change) > kMuch ? 1 : 0;
    if (std::abs(change) <= std::abs(worst)) continue;
    worst = change;
    label = one.label;
  }
  if (others == 0) return {};
  return fmt::format(
      "label {} fills {:.1f} % {} than its voxels{}; a smaller `delta` or `boundary` exact may help", label,
      100 * std::abs(worst), worst < 0 ? "less" : "more",
      others > 1 ? fmt::format(", the worst of {} labels that are more than 5 % off", others) : "");
}

}  // namespace

ImageShape shape_of(const LabelImage& image) {
  ImageShape shape{image.frame(), label_topology(image), voxel_components(image, ComponentScope::kEachLabel)};
  std::erase_if(shape.pieces, [](const VoxelComponent& c) { return c.voxel_count < kLeastVoxels; });
  return shape;
}

std::vector<std::string> differences(const ImageShape& image, const TetMesh& mesh) {
  std::vector<std::string> lines;
  for (std::string line : {lost_pieces(image, mesh), other_shapes(image, mesh), other_volumes(image, mesh)})
    if (!line.empty()) lines.push_back(std::move(line));
  return lines;
}

}  // namespace lumesh
