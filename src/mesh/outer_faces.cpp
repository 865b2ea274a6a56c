#include "lumesh/mesh/outer_faces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/enumerated.hpp"
#include "lumesh/mesh/all_cells.hpp"
#include "lumesh/mesh/cell_faces.hpp"
#include "lumesh/mesh/cell_sides.hpp"
#include "lumesh/parallel/key_table.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

/// Triangles and quadrilaterals of a mesh under one number, and of each whether it lies between two cells.
/// Faces of all cells, which are far more, are not sorted.
class GivenFaces {
 public:
  explicit GivenFaces(const MeshView& mesh)
      : cells_of_(mesh.triangles.size() + mesh.quadrilaterals.size()),
        by_lowest_(
            cells_of_.size(), mesh.points.size(),
            [&](std::size_t f, const auto& take) {
              const std::size_t triangles = mesh.triangles.size();
              take(Given{key_of(f < triangles ? face_of(mesh.triangles[f])
                                              : face_of(mesh.quadrilaterals[f - triangles])),
                         static_cast<std::uint32_t>(f)});
            },
            [](const Given& given) { return given.key[0]; }) {
    const AllCells cells(mesh);
    const auto found = parallel::collect<std::uint32_t>(
        cells.size(), [&](std::size_t cell, std::vector<std::uint32_t>& out) {
          cells.visit(cell, [&](const auto& corners, Label) { find_faces_of(corners, out); });
        });
    for (const std::uint32_t f : found) ++cells_of_[f];
  }

  [[nodiscard]] bool is_between(std::size_t face) const { return cells_of_[face] > 1; }

 private:
  struct Given {
    Cell<4> key;
    std::uint32_t number;
    auto operator<=>(const Given&) const = default;
  };

  void find_faces_of(const auto& cell, std::vector<std::uint32_t>& out) const {
    for (std::size_t f = 0; f < faces_of_cell(cell.size()).size(); ++f) {
      const FaceCorners face = corners_of(cell, f);
      const std::span<const Given> near = by_lowest_.of(std::ranges::min(face));
      if (near.empty()) continue;
      const Cell<4> key = key_of(face);
      for (const Given& given : near)
        if (given.key == key) out.push_back(given.number);
    }
  }

  std::vector<std::uint32_t> cells_of_;
  parallel::KeyTable<Given> by_lowest_;
};

}  // namespace

OuterFaces::OuterFaces(const MeshView& mesh) : mesh_(mesh), left_out_(mesh.info->patches.size()) {
  if (mesh.cell_count() == 0) return;
  const GivenFaces given(mesh);
  const auto keep = [&]<std::size_t N>(std::span<const Cell<N>> faces, std::span<const std::int32_t> patches,
                                       std::size_t first, std::vector<Cell<N>>& kept,
                                       std::vector<std::int32_t>& of_kept) {
    for (std::size_t f = 0; f < faces.size(); ++f) {
      if (given.is_between(first + f)) {
        const auto patch = static_cast<std::size_t>(patches[f]);
        if (patch >= left_out_.size()) left_out_.resize(patch + 1);
        ++left_out_[patch];
        continue;
      }
      kept.push_back(faces[f]);
      of_kept.push_back(patches[f]);
    }
  };
  keep(mesh.triangles, mesh.triangle_patches, 0, triangles_, triangle_patches_);
  keep(mesh.quadrilaterals, mesh.quadrilateral_patches, mesh.triangles.size(), quadrilaterals_,
       quadrilateral_patches_);
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
  constexpr std::size_t kMaxNames = 4;
  return fmt::format("{} between cells{}", counted(count, "face", "faces"),
                     names.empty() ? "" : fmt::format(" ({})", enumerated(names, kMaxNames)));
}

}  // namespace lumesh
