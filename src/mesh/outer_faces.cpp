#include "lumesh/mesh/outer_faces.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>

#include "lumesh/core/counted.hpp"
#include "lumesh/mesh/cell_sides.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

template <std::size_t N>
std::vector<std::uint8_t> faces_between(const CellSides& sides, std::span<const Cell<N>> faces) {
  std::vector<std::uint8_t> between(faces.size());
  parallel::for_each_index(
      faces.size(), [&](std::size_t f) { between[f] = sides.find(face_of(faces[f])).size() > 1 ? 1 : 0; });
  return between;
}

}  // namespace

OuterFaces::OuterFaces(const MeshView& mesh) : mesh_(mesh), left_out_(mesh.info->patches.size()) {
  if (mesh.cell_count() == 0) return;
  const CellSides sides(mesh);
  const auto keep = [&]<std::size_t N>(std::span<const Cell<N>> faces, std::span<const std::int32_t> patches,
                                       std::vector<Cell<N>>& kept, std::vector<std::int32_t>& of_kept) {
    const std::vector<std::uint8_t> between = faces_between(sides, faces);
    for (std::size_t f = 0; f < faces.size(); ++f) {
      if (between[f] != 0) {
        const auto patch = static_cast<std::size_t>(patches[f]);
        if (patch >= left_out_.size()) left_out_.resize(patch + 1);
        ++left_out_[patch];
        continue;
      }
      kept.push_back(faces[f]);
      of_kept.push_back(patches[f]);
    }
  };
  keep(mesh.triangles, mesh.triangle_patches, triangles_, triangle_patches_);
  keep(mesh.quadrilaterals, mesh.quadrilateral_patches, quadrilaterals_, quadrilateral_patches_);
}

MeshView OuterFaces::view() const {
  if (mesh_.cell_count() == 0) return mesh_;
  MeshView outside;
  outside.points = mesh_.points;
  outside.triangles = triangles_;
  outside.triangle_patches = triangle_patches_;
  outside.quadrilaterals = quadrilaterals_;
  outside.quadrilateral_patches = quadrilateral_patches_;
  outside.info = mesh_.info;
  return outside;
}

std::string OuterFaces::left_out_text() const {
  const std::size_t count = std::accumulate(left_out_.begin(), left_out_.end(), std::size_t{0});
  if (count == 0) return {};
  std::vector<std::string> names;
  for (std::size_t p = 0; p < std::min(left_out_.size(), mesh_.info->patches.size()); ++p)
    if (left_out_[p] > 0) names.push_back(mesh_.info->patches[p].name);
  constexpr std::size_t kMostNames = 4;
  const std::size_t more = names.size() > kMostNames ? names.size() - kMostNames : 0;
  names.resize(names.size() - more);
  const std::string which =
      fmt::format("{}{}", fmt::join(names, ", "), more > 0 ? fmt::format(" and {} more", more) : "");
  return fmt::format("{} between cells{}", counted(count, "face", "faces"),
                     names.empty() ? "" : fmt::format(" ({})", which));
}

}  // namespace lumesh
