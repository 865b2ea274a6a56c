#include "lumesh/stages/image_shape.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/mesh/all_cells.hpp"
#include "lumesh/mesh/label_shapes.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/quality/surface.hpp"

namespace lumesh {
namespace {

constexpr std::size_t kMinVoxels = 27, kMaxListed = 3;

/// Whether any cell of the piece's label has its middle in the piece's box.
std::vector<bool> found_pieces(const ImageShape& image, const MeshView& mesh) {
  std::map<Label, std::vector<std::size_t>> missing;
  for (std::size_t p = 0; p < image.pieces.size(); ++p) missing[image.pieces[p].label].push_back(p);
  std::vector<bool> is_found(image.pieces.size(), false);
  const auto look = [&](const auto& corners, Label label) {
    const auto pieces = missing.find(label);
    if (pieces == missing.end()) return;
    Vec3 sum = Vec3::Zero();
    for (const std::uint32_t v : corners) sum += mesh.points[v];
    const Vec3 index = image.frame.to_index(sum / static_cast<double>(corners.size()));
    std::erase_if(pieces->second, [&](std::size_t p) {
      const VoxelBox& box = image.pieces[p].box;
      const bool is_inside = ((index - box.low.cast<double>()).array() >= -1).all() &&
                             ((box.high.cast<double>() - index).array() >= 0).all();
      if (is_inside) is_found[p] = true;
      return is_inside;
    });
    if (pieces->second.empty()) missing.erase(pieces);
  };
  const AllCells cells(mesh);
  for (std::size_t i = 0; i < cells.size() && !missing.empty(); ++i) cells.visit(i, look);
  return is_found;
}

std::vector<LabelShape> shapes_of_mixed(const MeshView& mesh) {
  std::vector<LabelShape> shapes;
  const quality::MeshSurface surface = quality::extract_surface(mesh);
  for (const quality::SolidTopology& solid : quality::analyse_solids(mesh)) {
    if (solid.label == quality::kOutside) continue;
    const std::vector<Cell<3>> around = surface.around(solid.label);
    shapes.push_back({solid.label, solid.components, solid.euler,
                      std::ssize(quality::analyse_surface(mesh.points, around).components)});
  }
  return shapes;
}

bool is_any_of(std::span<const LabelShape> shapes, Label label) {
  return std::ranges::any_of(shapes, [&](const auto& s) { return s.label == label; });
}

std::string lost_pieces(const ImageShape& image, const std::vector<bool>& is_found, const char* remedy) {
  std::string list;
  std::size_t lost = 0;
  for (std::size_t p = 0; p < image.pieces.size(); ++p) {
    if (is_found[p] || ++lost > kMaxListed) continue;
    const VoxelComponent& piece = image.pieces[p];
    const Vec3 middle =
        image.frame.to_physical(0.5 * (piece.box.low + piece.box.high).cast<double>() - Vec3::Constant(0.5));
    list += fmt::format("{}label {} at {} mm of {} voxels", lost == 1 ? "" : "; ", piece.label,
                        coordinates_text(middle, 4), piece.voxel_count);
  }
  if (lost == 0) return {};
  return fmt::format("{} of labels not in the mesh: {}{}; {}", counted(lost, "piece"), list,
                     lost > kMaxListed ? "; ..." : "", remedy);
}

/// "label 1 with 1 piece and Euler number 1, of 2 and 2"; nothing if it is as in the image.
std::string other_shape(const ImageShape& image, const LabelTopology& voxels, const LabelShape& mesh) {
  if (image.is_cut) {
    const std::uint64_t least = static_cast<std::uint64_t>(
        std::ranges::count_if(image.pieces, [&](const auto& p) { return p.label == voxels.label; }));
    if (mesh.components >= least && mesh.components <= voxels.component_count) return {};
    return fmt::format("label {} with {}, of {}", voxels.label, counted(mesh.components, "piece"),
                       mesh.components < least ? least : voxels.component_count);
  }
  if (mesh.components != voxels.component_count || mesh.euler != voxels.euler_number)
    return fmt::format("label {} with {} and Euler number {}, of {} and {}", voxels.label,
                       counted(mesh.components, "piece"), mesh.euler, voxels.component_count,
                       voxels.euler_number);
  // Fewer where two pieces share a vertex: nothing can be said of cavities then.
  const std::int64_t cavities = mesh.surfaces - static_cast<std::int64_t>(mesh.components);
  if (cavities < 0 || cavities == static_cast<std::int64_t>(voxels.cavity_count)) return {};
  return fmt::format("label {} with {}, of {}", voxels.label,
                     counted(static_cast<std::uint64_t>(cavities), "cavity", "cavities"),
                     voxels.cavity_count);
}

std::string other_shapes(const ImageShape& image, std::span<const LabelShape> shapes, const char* remedy) {
  std::string list;
  std::size_t others = 0;
  for (const LabelTopology& label : image.labels) {
    const auto found = std::ranges::find_if(shapes, [&](const auto& s) { return s.label == label.label; });
    const std::string other =
        other_shape(image, label, found == shapes.end() ? LabelShape{label.label} : *found);
    if (other.empty() || ++others > kMaxListed) continue;
    list += (others == 1 ? "" : "; ") + other;
  }
  if (others == 0) return {};
  return fmt::format("{} from the image's voxels: {}{}; {}",
                     counted(others, "label in the mesh differs", "labels in the mesh differ"), list,
                     others > kMaxListed ? "; ..." : "", remedy);
}

std::string other_volumes(const ImageShape& image, const TetMesh& mesh) {
  const std::map<Label, double> volumes = volumes_of_labels(mesh);
  std::size_t others = 0;
  double worst = 0;
  Label label = 0;
  for (const LabelTopology& one : image.labels) {
    const auto found = volumes.find(one.label);
    if (one.voxel_count == 0 || found == volumes.end()) continue;
    const double change = found->second / one.volume_mm3 - 1;
    if (std::abs(change) <= much_of_volume(static_cast<double>(one.voxel_count))) continue;
    ++others;
    if (std::abs(change) <= std::abs(worst)) continue;
    worst = change;
    label = one.label;
  }
  if (others == 0) return {};
  return fmt::format("{}; a smaller `delta`{} may help", volume_text(label, worst, others),
                     image.is_exact ? "" : " or `boundary` exact");
}

std::vector<std::string> without_empty(std::vector<std::string> lines) {
  std::erase(lines, "");
  return lines;
}

/// What lies beyond the planes becomes background.
LabelImage cut_off(LabelImage image, std::span<const CutPlane> planes) {
  const ImageFrame& frame = image.frame();
  const auto is_beyond = [&](const Vec3& x) {
    return std::ranges::any_of(planes, [&](const CutPlane& plane) { return plane.beyond_mm(x) > 0; });
  };
  parallel::for_each_index(static_cast<std::size_t>(frame.size.z()), 1, [&](std::size_t k) {
    for (int j = 0; j < frame.size.y(); ++j)
      for (int i = 0; i < frame.size.x(); ++i) {
        const Index3 voxel(i, j, static_cast<int>(k));
        if (image.at(voxel) != 0 && is_beyond(frame.to_physical(voxel.cast<double>()))) image.at(voxel) = 0;
      }
  });
  return image;
}

ImageShape shape_of_whole(const LabelImage& image) {
  ImageShape shape{image.frame(), label_topology(image), voxel_components(image, ComponentScope::kEachLabel)};
  std::erase_if(shape.pieces, [](const VoxelComponent& c) { return c.voxel_count < kMinVoxels; });
  return shape;
}

}  // namespace

ImageShape shape_of(const LabelImage& image, std::span<const CutPlane> planes) {
  ImageShape shape = planes.empty() ? shape_of_whole(image) : shape_of_whole(cut_off(image, planes));
  shape.is_cut = !planes.empty();
  return shape;
}

std::string small_pieces_warning(const LabelImage& image, std::span<const CutPlane> planes) {
  std::vector<VoxelComponent> pieces =
      voxel_components(planes.empty() ? image : cut_off(image, planes), ComponentScope::kUnion);
  if (pieces.size() < 2) return "";
  const std::size_t others = pieces.size() - 1;
  const double most = kSmallPiece * static_cast<double>(pieces.front().voxel_count);
  std::erase_if(pieces,
                [&](const VoxelComponent& piece) { return static_cast<double>(piece.voxel_count) >= most; });
  if (pieces.empty()) return "";
  std::size_t voxels = 0;
  for (const VoxelComponent& piece : pieces) voxels += piece.voxel_count;
  return fmt::format(
      "{} besides the largest ({} at {}); {}`drop_below` {} removes {}",
      counted(pieces.size(), "small piece"),
      pieces.size() == 1 ? counted(voxels, "voxel") : fmt::format("{} voxels together, one", voxels),
      place_text(image.frame().to_physical(pieces.front().first.cast<double>())),
      pieces.size() == others ? "`largest_component` or " : "", pieces.front().voxel_count + 1,
      pieces.size() == 1 ? "it" : "them");
}

std::vector<std::string> differences(const ImageShape& image, const TetMesh& mesh) {
  MeshView cells;
  cells.points = mesh.points();
  cells.tetrahedra = mesh.tets();
  cells.tetrahedron_labels = mesh.labels();
  return without_empty(
      {lost_pieces(image, found_pieces(image, cells), "a smaller `delta` keeps more"),
       other_shapes(image, label_shapes(mesh),
                    image.is_exact ? "a smaller `delta` keeps more"
                                   : "`boundary` exact keeps more details of about a voxel, a smaller "
                                     "`delta` larger ones"),
       image.is_cut ? "" : other_volumes(image, mesh)});
}

std::vector<std::string> differences_of_lattice(const ImageShape& image, const MeshView& mesh) {
  const bool is_mixed = mesh.cell_count() > mesh.tetrahedra.size();
  const std::vector<LabelShape> shapes =
      is_mixed ? shapes_of_mixed(mesh) : label_shapes(TetMesh::build(mesh));
  ImageShape there = image;
  std::erase_if(there.labels, [&](const auto& label) { return !is_any_of(shapes, label.label); });
  std::erase_if(there.pieces, [&](const auto& piece) { return !is_any_of(shapes, piece.label); });
  const char* const remedy = image.is_exact
                                 ? "an `edge_length` of 0.7 voxels keeps more"
                                 : "`boundary` exact with an `edge_length` of 0.7 voxels keeps more";
  return without_empty(
      {lost_pieces(there, found_pieces(there, mesh), remedy), other_shapes(there, shapes, remedy)});
}

}  // namespace lumesh
