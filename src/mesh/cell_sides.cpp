#include "lumesh/mesh/cell_sides.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "lumesh/core/error.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/mesh/cell_faces.hpp"

namespace lumesh {

Cell<4> key_of(const FaceCorners& face) {
  Cell<4> key = face;
  if (is_triangle(face)) key[3] = VertexId::kNone;
  std::ranges::sort(key);
  return key;
}

bool are_opposite(const FaceCorners& a, const FaceCorners& b) {
  const std::size_t count = is_triangle(a) ? 3 : 4;
  if (is_triangle(b) != is_triangle(a)) return false;
  const auto first = static_cast<std::size_t>(
      std::find(b.begin(), b.begin() + static_cast<std::ptrdiff_t>(count), a[0]) - b.begin());
  for (std::size_t i = 0; i < count; ++i)
    if (first == count || b[(first + count - i) % count] != a[i]) return false;
  return true;
}

Vec3 middle_of(std::span<const Vec3> points, const FaceCorners& face) {
  const std::size_t count = is_triangle(face) ? 3 : 4;
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < count; ++i) sum += points[face[i]];
  return sum / static_cast<double>(count);
}

CellSides::CellSides(const MeshView& mesh)
    : mesh_(mesh),
      cells_(mesh_),
      sides_(
          cells_.size(), mesh.points.size(),
          [&](std::size_t cell, const auto& take) {
            cells_.visit(cell, [&](const auto& corners, Label) {
              for (std::uint32_t f = 0; f < faces_of_cell(corners.size()).size(); ++f)
                take(CellSide{key_of(corners_of(corners, f)), static_cast<std::uint32_t>(cell), f});
            });
          },
          [](const CellSide& side) { return side.key[0]; }) {}

void CellSides::check() const {
  const auto faults = collect<CellSide>([&](std::span<const CellSide> run, std::vector<CellSide>& out) {
    if (run.size() > 2 || (run.size() == 2 && !are_opposite(outward(run[0]), outward(run[1]))))
      out.push_back(run[0]);
  });
  if (faults.empty()) return;
  throw Error(
      ErrorKind::kBadInput,
      fmt::format("cells overlap: {} faces have more than two cells, or two on the same side, such as "
                  "that at {}; repair the mesh",
                  faults.size(), coordinates_text(middle_of(mesh_.points, outward(faults.front())))));
}

std::vector<CellSide> CellSides::outer() const {
  return collect<CellSide>([](std::span<const CellSide> run, std::vector<CellSide>& out) {
    if (run.size() == 1) out.push_back(run[0]);
  });
}

std::span<const CellSide> CellSides::find(const FaceCorners& face) const {
  const Cell<4> key = key_of(face);
  const std::span<const CellSide> near = sides_.of(key[0]);
  const auto first =
      std::partition_point(near.begin(), near.end(), [&](const CellSide& side) { return side.key < key; });
  auto last = first;
  while (last != near.end() && last->key == key) ++last;
  return {first, last};
}

FaceCorners CellSides::outward(const CellSide& side) const {
  return cells_.visit(side.cell, [&](const auto& corners, Label) { return corners_of(corners, side.face); });
}

}  // namespace lumesh
